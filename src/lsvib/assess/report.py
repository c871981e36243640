"""The report: the verdict on a drive in plain words, with pictures and numbers; and many drives in one table.

What is said of every drive stands in the templates beside this file, what depends on the drive is put together here.
"""

import json
import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import yaml
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from lsvib.assess import pictures, summary, words
from lsvib.assess.assessment import AssessedMotion, Assessment
from lsvib.assess.chart import Chart
from lsvib.assess.fields import FrictionBySpeed, Spread
from lsvib.assess.operation import Operation
from lsvib.assess.quantities import QUANTITIES
from lsvib.assess.sheet import Sheet
from lsvib.assess.threads import ThreadSize
from lsvib.assess.words import ATTRACTORS, MECHANISMS, SHORT, change, entry_name, percent, shown, signed
from lsvib.errors import InputError
from lsvib.files import write_json, write_text
from lsvib.stability.conditions import stability


def _page(template: str, **values: Any) -> str:
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    own = (_capital, _end_in_words, _interval, _simplified, _tolerated, _where)
    environment.globals |= vars(words) | {function.__name__.strip("_"): function for function in own}
    environment.globals |= {"QUANTITIES": QUANTITIES, "pictures": pictures}
    environment.filters["yaml"] = partial(yaml.safe_dump, sort_keys=False)
    return environment.get_template(template).render(**values).lstrip()


def report(assessment: Assessment, charts: list[Chart]) -> str:
    """Return the report on an assessment as the text of one HTML page, which needs no other file."""
    sheet, names, found = assessment.draw.sheet, shown_mechanisms(assessment), assessment.mechanisms
    near = [name for name in names if any(row.is_near() for row in found[name].margins)]
    # A reserve at its lower end, -1, has no slope, or as good as none: then no small change helps against that cause.
    steep = next((name for name in near if max(map(abs, found[name].sensitivities.values()), default=0) > 1e-3), None)
    same = assessment.worst is assessment.nominal
    motions = {"At the given values" if same else "At the middle values": assessment.nominal}
    if not same:
        motions["In the worst case within the uncertainties"] = assessment.worst
    return _page(
        "report.html.j2",
        title=f"{sheet.name}: will it vibrate?",
        assessment=assessment,
        sheet=sheet,
        given=sheet.paths(),
        spread=assessment.uncertainty,
        worst=assessment.worst.vibration,
        summary=_summary(assessment),
        causes=[_from_rest(assessment), *(_cause(assessment, name) for name in (*names, "after_perturbation"))],
        names=names,
        changes=assessment.starting.changes
        if assessment.verdict == "jerks"
        else [row for row in assessment.margins if row.is_near() and row.value],
        near=near,
        oscillations=_oscillations(assessment) if sheet.motor is not None else [],
        lever=max(found[steep].sensitivities.items(), key=lambda item: abs(item[1])) if steep else None,
        steep=steep,
        charts=charts,
        motions=motions,
        random=sheet.random,
        locking=locking_sentence(assessment),
        static=summary,
        endangered=bool(assessment.statics.back_drives) or any(row.exceeded for row in assessment.statics.limited),
        entries=[
            (entry_name(path), _entry(one), _origin(sheet, path)) for path, one in sheet.entries() if one is not None
        ],
    )


def _oscillations(assessment: Assessment) -> list[str]:
    """Frequencies with damping ratios of small oscillations, with the motor's control and without its damping."""
    drive, found = assessment.nominal.there.drive, []
    for gain in (drive.speed_gain, 0.0):
        try:
            roots = stability(drive.replace(speed_gain=gain)).eigenvalues
        except InputError:  # the contact carries no force
            return []
        pairs = sorted((root for root in roots if root.imag > 0), key=abs)
        found.append(", ".join(f"{shown(abs(z) / (2 * math.pi), 'Hz')} (ζ = {-z.real / abs(z):.2g})" for z in pairs))
    return found


def shown_mechanisms(assessment: Assessment) -> list[str]:
    """Return the names of the mechanisms proper, those that occur or are nearest first."""
    own = [name for name in assessment.mechanisms if name != "after_perturbation"]
    return sorted(own, key=lambda name: assessment.mechanisms[name].reserve)


def _where(there: Operation) -> str:
    """A point of operation in words."""
    speed, force = there.speed, there.force
    way = "outward" if there.direction > 0 else "back"
    side = "against" if force >= 0 else "in the direction of"
    load = f"{shown(abs(force), 'N')} {side} outward travel" if force else "no force on the load"
    along, turning = shown(there.draw.travel * speed, "m/s"), shown(speed, "rad/s")
    weight = " besides its weight" if there.draw.values["tilt"] != 0 else ""
    return f"travelling {way} at {along} ({turning}) with {load}{weight}"


def _summary(assessment: Assessment) -> str:
    found = [assessment.mechanisms[name] for name in shown_mechanisms(assessment)]
    occurring, absent = [one for one in found if one.occurs], _absent(assessment)
    started = f" {told}" if (told := summary.from_rest(assessment)) else ""
    best = "; or ".join(f"the {summary.changed(assessment, row)}" for row in summary.helping(assessment))
    if assessment.verdict == "jerks":
        return _of_jerks(assessment, best)
    if occurring:
        one, *others = occurring
        too = f" Also {' and '.join(SHORT[other.name] for other in others)} would do it." if others else ""
        advice = f"The smallest single changes that make it run steadily at the middle values: {best}."
        if not best:
            advice = "No change of one quantity alone, up to a factor of three, makes it run steadily."
        return f"The cause is {SHORT[one.name]}, worst {_where(one.there)}.{too} {advice}{started}{absent}"
    near = [(abs(math.log(row.factor)), one, row) for one in found for row in one.margins if row.factor is not None]
    if not near:
        nothing = "No single change of any quantity, from a thousandth to a thousandfold, would make it vibrate."
        return f"{nothing}{started}{absent}"
    _, one, row = min(near, key=lambda entry: entry[0])
    return (
        f"The nearest cause of vibration is {SHORT[one.name]}: it would set in with the "
        f"{row.about.words} {change(row.factor)}, {shown(row.value, row.about.unit)}.{started}{absent}"
    )


def _of_jerks(assessment: Assessment, best: str) -> str:
    """What a drive does that jerks from rest, why, and what ends it, the ``best`` changes."""
    found = assessment.starting
    cause = "the vibration that a perturbation could start as well, which the start from rest reaches"
    if found.cause == "static":
        cause = "static friction above that of sliding: without the difference it would become steady there"
    elif found.cause == "law":
        cause = "friction that changes with the speed: with that of its coefficient alone it would become steady there"
    advice = f"The smallest single changes that end the jerks at all points of the window that were tried: {best}."
    if not best:
        advice = "No change of one quantity alone that was tried, by a factor of three at most, ends them."
    return f"{summary.from_rest(assessment)} The cause is {cause}. {advice}"


def _absent(assessment: Assessment) -> str:
    """A sentence on each damping that the sheet leaves out and that would alter the verdict."""
    effect = "end" if assessment.verdict == "vibrates" else "start"
    return "".join(
        f" No {row.about.words} is given; from {shown(row.value, row.about.unit)} on it would {effect} vibration."
        for row in assessment.margins
        if row.factor is None and row.value is not None
    )


def _interval(ends: tuple[float, float]) -> str:
    return f"{percent(ends[0])} to {percent(ends[1])}"


def _cause(assessment: Assessment, name: str) -> tuple[Any, ...]:
    """A row of the table of causes."""
    one, perturbed = assessment.mechanisms[name], name == "after_perturbation"
    best = next((f"the {row.about.words} {change(row.factor)}" for row in one.margins if row.factor), "")
    margin = f"{best} {'ends' if one.occurs else 'starts'} it"
    if not best:
        margin = f"no single change {'ends it' if one.occurs else 'brings it about'}"
    elif perturbed and not one.occurs:
        margin = f"none before {best}"
    if perturbed and (one.probability is None or (not best and one.occurs) or bool(one.occurs) != (one.reserve < 0)):
        margin = "not known"  # its motions decide, of which the reserve knows only what is necessary
    verdict: Any = "not known" if one.occurs is None else "does not occur"
    if one.occurs:
        place, verdict = _where(one.there), Markup("<b>occurs</b>")
        if perturbed and one.probability is None:
            place, verdict = f"found by a perturbed motion; {place}", "possible"
        verdict = (verdict, place)
    share = "not known" if one.probability is None else percent(one.probability)
    if one.interval is not None and one.interval[0] != one.interval[1]:
        share += f" (95 % sure: {_interval(one.interval)})"
    return MECHANISMS[name], verdict, share, signed(one.reserve, 2), margin


def _from_rest(assessment: Assessment) -> tuple[Any, ...]:
    """The row of what happens when the drive is switched on."""
    found = assessment.starting
    verdict: Any = "not known" if found.jerks is None else "does not occur"
    if found.jerks:
        verdict = (Markup("<b>occurs</b>"), _where(found.there))
    share = f"{percent(found.share)} of {found.drawn} drawn" if found.drawn else percent(found.share)
    margin = "" if not found.jerks else "no single change that was tried ends it"
    if found.changes:
        margin = f"the {found.changes[0].about.words} {change(found.changes[0].factor)} ends it"
    return MECHANISMS["from_rest"], verdict, share, "–", margin


def _end_in_words(motion: AssessedMotion, start: str) -> str:
    """What becomes of a motion that is no cycle with a frequency."""
    moved = motion.vibration
    if moved.reason is not None:
        return f"Of the motion {start} this is known: {moved.reason}"
    if moved.frequency is not None:
        return ""
    verb = "returns to" if moved.attractor == "steady sliding" else "ends in"
    return f"{_capital(start)} it {verb} {ATTRACTORS.get(moved.attractor, moved.attractor)}."


def _tolerated(motion: AssessedMotion) -> str:
    """Which sudden change of speed steady running tolerates, if that is known."""
    size, sentence = motion.tolerated
    if size is None or size <= 0:
        return ""
    if math.isinf(size):
        return sentence
    load, speed = shown(motion.there.draw.travel * size, "m/s"), motion.there.speed
    start = f" A start without a ramp is a larger one, of {shown(speed, 'rad/s')}." if size < speed else ""
    return (
        f"Steady running tolerates a sudden change of the screw's speed of up to {shown(size, 'rad/s')}, which is "
        f"{load} at the load.{start} {sentence}"
    )


def _simplified(motion: AssessedMotion, assessment: Assessment) -> str:
    """What the motion leaves out of the data sheet, in sentences."""
    sheet = assessment.draw.sheet
    stiff = " and ".join(part for part in reversed(sheet.parts) if part not in motion.vibration.parts)
    text = f" Its motion is computed with stiff {stiff}." if stiff else ""
    slope = float(motion.there.friction[1])
    if slope != 0 and not sheet.friction.law:
        effect = "its rise with speed adds" if slope > 0 else "its fall with speed takes away"
        text += f" Friction is taken as constant at its value there; the damping that {effect} is not in this motion."
    return text


def locking_sentence(assessment: Assessment) -> str:
    """Say how well the thread lifts, and whether it holds its load."""
    lifting, lowering = assessment.efficiency["lifting"], assessment.efficiency["lowering"]
    holds = (
        "The thread is self-locking: friction alone holds the load, and the motor has to drive it down as well as up."
        if assessment.self_locking
        else "The thread is not self-locking: the load can drive the screw back, with an efficiency of "
        f"{percent(lowering)}."
    )
    spread = assessment.uncertainty
    if 0 < spread.holds.value < 1:
        holds += f" That is so at the middle values; of all drives that were drawn, {percent(spread.holds.value)} hold."
    low, high = spread.lifting
    ends = f" (from {percent(low)} to {percent(high)} within the uncertainties)" if low < high else ""
    return f"Against the load the thread works with an efficiency of {percent(lifting)}{ends}. {holds}"


def _entry(entry: object) -> str:
    if isinstance(entry, Spread):
        kind = "anywhere in the range" if entry.kind == "uniform" else entry.kind
        return entry.text if kind == "value" else f"{entry.text} ({kind})"
    if isinstance(entry, FrictionBySpeed):
        points = zip(entry.speeds, entry.coefficients, strict=True)
        return "; ".join(f"{coefficient:g} at {shown(speed, 'm/s')}" for speed, coefficient in points)
    if isinstance(entry, ThreadSize):
        return f"lead {shown(entry.lead, 'm')}, pitch diameter {shown(entry.pitch_diameter, 'm')}"
    return str(entry)


def _origin(sheet: Sheet, path: str) -> str:
    for key in (path, path.partition(".")[0]):
        if key in sheet.assumptions:
            return Markup('<span class="assumed">assumed</span> {}').format(sheet.assumptions[key])
        if key in sheet.sources:
            return sheet.sources[key]
    return "as given"


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]


def compare(verdicts: Sequence[Path], page_file: Path, json_file: Path) -> None:
    """Write the comparison of drives from their files ``assessment.json``, the most likely to vibrate first.

    The page links to ``index.html`` in the folder of each file, from the folder that holds these folders. Raises
    ``InputError`` in one sentence if a file is missing or damaged.
    """
    found = [{"report": f"{path.parent.name}/index.html", **_short(path)} for path in verdicts]
    found.sort(key=lambda short: (-short["probability"], short["reserve"]))
    names = {about.name: about.words for about in QUANTITIES.values()}
    page = _page("report_comparison.html.j2", title="Which drives vibrate?", drives=found, names=names)
    write_text(page, page_file)
    write_json(found, json_file)


def _short(path: Path) -> dict[str, Any]:
    """What the comparison says of a drive, from its file ``assessment.json``."""
    try:
        verdict = json.loads(path.read_text(encoding="utf-8"))
        name, one = min(verdict["mechanisms"].items(), key=lambda item: item[1]["reserve"])
        margins = verdict["any_mechanism"]["margin"].items()
        nearest = ((key, row["factor"]) for key, row in margins if row["factor"] is not None)
        worst = verdict["worst_case"]
        return {
            "name": verdict["name"],
            "verdict": verdict["verdict"],
            "probability": verdict["any_mechanism"]["probability"],
            "interval": verdict["any_mechanism"]["interval"],
            "nearest_mechanism": name,
            "reserve": one["reserve"],
            "nearest_change": dict(zip(("quantity", "factor"), next(nearest, (None, None)), strict=True)),
            "worst_case": {key: worst[key] for key in ("attractor", "frequency", "amplitude", "peak_contact_force")},
            "self_locking": verdict["self_locking"],
            "efficiency": verdict["efficiency"],
        }
    except OSError as error:
        raise InputError(f"Cannot read {path}: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(f"{path} is not a readable assessment; delete it, and run again what makes it.") from None
