"""The parts of the report that say what went in: the data sheet with its sources, the limits, and the method."""

from lsvib.assess import report
from lsvib.assess.assessment import Assessment
from lsvib.assess.drive import QUANTITIES
from lsvib.assess.fields import FrictionBySpeed, Spread
from lsvib.assess.report import Html
from lsvib.assess.words import LEFT_OUT, entry_name, shown

_KINDS = {"uniform": "anywhere in the range", "triangular": "triangular", "normal": "normal", "lognormal": "lognormal"}
_TAKEN = {
    "damping.rotational": "no rotational damping is given: none is taken, which is on the safe side",
    "damping.translational": "no damping of the load's travel is given: none is taken; such damping can start negative "
    "damping, so it is not always on the safe side",
    "load.force": "no force on the load is given: none is taken besides its weight",
    "screw.material": "no material of the screw is given: steel is taken",
    "thread.half_angle": "no flank angle is given: a square thread is taken",
}


def data_sheet(assessment: Assessment) -> list[Html]:
    """The entries as given, each with its source or marked as an assumption, and the quantities that follow."""
    sheet, rows = assessment.sheet, []
    for path, entry in sheet.entries():
        if entry is None:
            continue
        rows.append((entry_name(path), _entry(entry), _origin(assessment, path)))
    found = [(QUANTITIES[key][0], shown(value, QUANTITIES[key][1])) for key, value in assessment.values.items()]
    return [
        report.heading("The data sheet"),
        report.table(["Entry", "Given", "Where it comes from"], rows),
        *(
            [report.paragraph("Assumed because it is not given:"), report.bullets(_missing(assessment))]
            if _missing(assessment)
            else []
        ),
        report.heading("What follows from it, at the middle values", 3),
        report.table(["Quantity", "Value"], [(name[0].upper() + name[1:], value) for name, value in found]),
    ]


def _entry(entry: object) -> str:
    if isinstance(entry, Spread):
        return entry.text if entry.kind == "value" else f"{entry.text} ({_KINDS[entry.kind]})"
    if isinstance(entry, FrictionBySpeed):
        pairs = zip(entry.speeds, entry.coefficients, strict=True)
        return "; ".join(f"{coefficient:g} at {shown(speed, 'm/s')}" for speed, coefficient in pairs)
    lead = getattr(entry, "lead", None)
    if lead is not None:
        return f"lead {shown(lead, 'm')}, pitch diameter {shown(entry.pitch_diameter, 'm')}"
    return str(entry)


def _origin(assessment: Assessment, path: str) -> Html:
    part = path.partition(".")[0]
    sheet = assessment.sheet
    for key in (path, part):
        if key in sheet.assumptions:
            return Html(f'<span class="assumed">assumed</span> {report.text(sheet.assumptions[key])}')
        if key in sheet.sources:
            return report.text(sheet.sources[key])
    return report.text("as given")


def _missing(assessment: Assessment) -> list[str]:
    given, sheet = assessment.sheet.paths(), assessment.sheet
    needed = {path: sentence for path, sentence in _TAKEN.items() if path not in given}
    if sheet.screw.inertia is not None or sheet.screw.density is not None:
        needed.pop("screw.material", None)
    if sheet.thread.size is not None:
        needed.pop("thread.half_angle", None)
    return [sentence[0].upper() + sentence[1:] + "." for sentence in needed.values()]


def left_out() -> list[Html]:
    """What the model does not know."""
    return [report.heading("What this model leaves out"), report.bullets(LEFT_OUT)]


def method(assessment: Assessment) -> list[Html]:
    """How the numbers were found, in a few sentences."""
    return [
        report.heading("How it was computed"),
        report.paragraph(
            "The screw, its coupling and the load are an oscillator with friction in the threads (Vahid-Araghi and "
            "Golnaraghi, Friction-Induced Vibration in Lead Screw Drives, Springer 2011, chapter 8). Whether a cause "
            "occurs is decided by exact signs of closed formulas; where there is none, by the equation of small "
            "oscillations. Motions are computed exactly from one event (standstill, loss of contact, impact) to the "
            "next, without time steps. Margins are found by root finding on those conditions."
        ),
        report.paragraph(
            f"{_samples(assessment)}All of the numbers are in assessment.json and, with the chart and the motions, in "
            "assessment.nc."
        ),
    ]


def _samples(assessment: Assessment) -> str:
    """How the drives were drawn, in sentences; empty if nothing is uncertain."""
    if assessment.uncertainty.samples == 1:
        return ""
    return (
        f"Samples: {assessment.uncertainty.samples} drives, spread evenly over what is uncertain (random points that "
        f"avoid each other: a scrambled Sobol sequence, seed {assessment.seed}). The intervals of probability hold the "
        "true value in 95 of 100 cases (Clopper and Pearson); they are those of independent samples, which is on the "
        "safe side. "
    )
