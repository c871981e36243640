"""The report: the verdict on a drive in plain words, with pictures and numbers, for an engineer."""

import math

from lsvib.assess import pictures, report
from lsvib.assess.assessment import Assessment
from lsvib.assess.drive import UNITS, flank_coefficient
from lsvib.assess.margins import Chart
from lsvib.assess.report import Html, data_sheet, left_out, method, motions, rigid, where
from lsvib.assess.words import CHANGES, MECHANISMS, SHORT, VERDICTS, change, percent, shown, signed

_TONES = {"vibrates": "bad", "steady": "good"}  # all else warns
_ADVICE = 3  # changes that the summary names
_MARGINS = 3  # causes whose margins are drawn
_NEAR = 10.0  # factor within which a margin is worth a bar


def report(assessment: Assessment, charts: list[Chart]) -> str:
    """Return the report on an assessment as the text of one HTML page, which needs no other file."""
    name = assessment.sheet.name
    parts = [
        report.heading(f"Will it vibrate? {name}", 1),
        report.paragraph(VERDICTS[assessment.verdict], kind=f"verdict {_TONES.get(assessment.verdict, 'warn')}"),
        report.paragraph(_summary(assessment)),
        report.cards(_cards(assessment)),
        *_mechanisms(assessment),
        *_changes(assessment),
        *_operating(assessment, charts),
        *motions(assessment),
        *_uncertainty(assessment),
        *_locking(assessment),
        *data_sheet(assessment),
        *left_out(),
        *method(assessment),
    ]
    return report.page(f"{name}: will it vibrate?", parts)


def shown_mechanisms(assessment: Assessment) -> list[str]:
    """Return the names of the mechanisms proper, those that occur or are nearest first."""
    own = [name for name in assessment.mechanisms if name != "push_needed"]
    return sorted(own, key=lambda name: assessment.mechanisms[name].reserve)


def _summary(assessment: Assessment) -> str:
    found = [assessment.mechanisms[name] for name in shown_mechanisms(assessment)]
    occurring = [one for one in found if one.occurs]
    if occurring:
        one, *others = occurring
        too = f" So does {' and '.join(SHORT[other.name] for other in others)}." if others else ""
        best = [row for row in assessment.margins if row.factor is not None][:_ADVICE]
        changes = "; or ".join(f"the {CHANGES[row.quantity]} {change(row.factor)}" for row in best)
        advice = (
            f" The smallest single changes that make it run steadily at the middle values: {changes}."
            if best
            else " No single change of one quantity alone makes it run steadily."
        )
        return f"The cause is {SHORT[one.name]}, worst {where(one, assessment)}.{too}{advice}{_absent(assessment)}"
    near = [(abs(math.log(row.factor)), one, row) for one in found for row in one.margins if row.factor is not None]
    if not near:
        return (
            "No single change of any quantity, from a thousandth to a thousandfold, would make it vibrate."
            f"{_absent(assessment)}"
        )
    _, one, row = min(near, key=lambda entry: entry[0])
    return (
        f"The nearest cause of vibration is {SHORT[one.name]}: it would set in with the "
        f"{CHANGES[row.quantity]} {change(row.factor)}, {shown(row.value, UNITS[row.quantity])}.{_absent(assessment)}"
    )


def _absent(assessment: Assessment) -> str:
    """A sentence on each damping that the sheet leaves out and that would alter the verdict."""
    effect = "end" if assessment.verdict == "vibrates" else "start"
    rows = [row for row in assessment.margins if row.factor is None and row.value is not None]
    return "".join(
        f" No {CHANGES[row.quantity]} is given; from {shown(row.value, UNITS[row.quantity])} on it would {effect} "
        "vibration."
        for row in rows
    )


def _cards(assessment: Assessment) -> list[tuple[str, str]]:
    lowering = assessment.efficiency["lowering"]
    holds, least = assessment.uncertainty.holds, assessment.uncertainty.any
    locking = "yes" if assessment.self_locking else "no"
    if 0 < holds.value < 1:
        locking = f"in {percent(holds.value)} of cases"
    cards = [
        (locking, "self-locking: holds its load without the motor"),
        (percent(assessment.efficiency["lifting"]), "efficiency when moving against the load"),
        ("needs torque" if lowering is None else percent(lowering), "efficiency when the load drives the screw back"),
        (
            percent(least.value) if least.value or least.interval[1] == 0 else f"below {percent(least.interval[1])}",
            "probability that it vibrates somewhere in the window",
        ),
    ]
    worst = assessment.worst.vibration
    if worst.frequency is not None:
        cards.append(
            (shown(worst.frequency, "Hz"), "frequency in the worst case" + (", audible" if worst.audible else ""))
        )
    if worst.amplitude is not None:
        cards.append((shown(worst.amplitude, "m"), "oscillation of the load in the worst case, to either side"))
    return cards


def _mechanisms(assessment: Assessment) -> list[Html]:
    rows = []
    for name in (*shown_mechanisms(assessment), "push_needed"):
        one, (title, meaning) = assessment.mechanisms[name], MECHANISMS[name]
        low, high = one.interval
        spread = "" if low == high else f" (95 % sure: {percent(low)} to {percent(high)})"
        best = next((row for row in one.margins if row.factor is not None), None)
        if name == "push_needed" and one.occurs != (one.reserve < 0):  # by its motions, to which the reserve is blind
            margin = "not known"
        elif best is None:
            margin = "no single change brings it about" if not one.occurs else "no single change ends it"
        else:
            margin = f"the {CHANGES[best.quantity]} {change(best.factor)} {'ends' if one.occurs else 'starts'} it"
        place = where(one, assessment) if one.occurs else ""
        verdict = Html(f"{'<b>occurs</b>' if one.occurs else 'does not occur'}{report.small(place) if place else ''}")
        if name == "push_needed" and one.occurs and not rigid(assessment):
            how = "computed with stiff threads and support" if one.reserve < 0 else "found by perturbed motions"
            verdict = Html(f"possible{report.small(f'{how}; {place}')}")
        cause = Html(f"{report.text(title)}{report.small(meaning)}")
        most = "at most " if name == "push_needed" and one.probability > 0 else ""  # beyond some force none does
        rows.append((cause, verdict, f"{most}{percent(one.probability)}{spread}", signed(one.reserve, 2), margin))
    absent = []
    if "mode_coupling" not in assessment.mechanisms:
        absent.append("Mode coupling of the support was not examined: the data sheet gives no support.")
    if "thread_contact" not in assessment.mechanisms:
        absent.append("The thread contact is taken as rigid: the data sheet gives no stiffness of it.")
    return [
        report.heading("What can make it vibrate"),
        report.paragraph(
            "The reserve says how far each cause is from setting in: +1 means that nothing drives it, 0 is the brink, "
            "below 0 it occurs. It is what keeps the drive steady less what drives the oscillation, over the sum "
            "of both. The operating window is every speed and force that the data sheet allows."
        ),
        report.table(["Cause", "At the given values", "Probability", "Reserve", "Nearest change"], rows),
        *(report.paragraph(sentence) for sentence in absent),
    ]


def _changes(assessment: Assessment) -> list[Html]:
    names = [
        name for name in shown_mechanisms(assessment)
        if any(row.factor and 1 / _NEAR <= row.factor <= _NEAR for row in assessment.mechanisms[name].margins)
    ]  # fmt: skip
    if not names:
        return []
    charts = [
        report.picture(
            pictures.embedded(pictures.margin_chart, assessment, name),
            f"{MECHANISMS[name][0]}: factor on each quantity at which it starts or ends.",
        )
        for name in names[:_MARGINS]
    ]
    text = []
    # A reserve at its lower end, -1, has no slope: then no small change helps against that cause.
    first = next((name for name in names if any(assessment.mechanisms[name].sensitivities.values())), None)
    if first is not None:
        best = max(assessment.mechanisms[first].sensitivities.items(), key=lambda pair: abs(pair[1]))
        text.append(
            report.paragraph(
                f"Per cent for per cent, the strongest single lever on {SHORT[first]} is the "
                f"{CHANGES[best[0]]}: 1 % more changes the reserve by {signed(0.01 * best[1], 4)}."
            )
        )
        charts.append(
            report.picture(
                pictures.embedded(pictures.sensitivity_chart, assessment, first),
                f"What 1 % more of each quantity does to the reserve against {SHORT[first]}.",
            )
        )
    return [
        report.heading("How close it is, and what to change"),
        *_single_changes(assessment),
        report.paragraph(
            "Each bar is one quantity changed alone, all others as given, until the verdict on a cause changes: ×0.5 "
            "means half of it, ×3 three times as much. Bars that would need more than a factor of ten either way are "
            "left out; the complete table is in assessment.json."
        ),
        report.side_by_side(*charts),
        *text,
    ]


def _single_changes(assessment: Assessment) -> list[Html]:
    """Say in numbers which single changes alter the verdict on the whole drive, at the middle values."""
    rows = [
        (
            CHANGES[row.quantity][0].upper() + CHANGES[row.quantity][1:],
            shown(row.value / row.factor, UNITS[row.quantity]),
            shown(row.value, UNITS[row.quantity]),
            f"×{row.factor:.3g}" + (f", {change(row.factor)}" if row.factor < 2 else ""),  # else it says the same twice
        )
        for row in assessment.margins
        if row.factor is not None and row.value is not None and 1 / _NEAR <= row.factor <= _NEAR
    ]
    if not rows:
        return []
    occurs = any(one.occurs for name, one in assessment.mechanisms.items() if name != "push_needed")
    effect = "ends all vibration that starts by itself" if occurs else "makes the drive start to vibrate by itself"
    return [
        report.paragraph(f"At the middle values each of these changes alone {effect}."),
        report.table(["One change alone", "Given", "Needed" if occurs else "Limit", "That is"], rows),
    ]


def _operating(assessment: Assessment, charts: list[Chart]) -> list[Html]:
    weight = assessment.values["tilt"] != 0
    note = " The weight of the load comes on top of the force shown." if weight else ""
    return [
        report.heading("Where it vibrates"),
        report.picture(
            pictures.embedded(pictures.operating_chart, charts, assessment),
            "Operating chart at the middle values: what happens at each speed and force. The blue frame is the "
            f"operating window; a force above zero opposes outward travel.{note}",
        ),
    ]


def _uncertainty(assessment: Assessment) -> list[Html]:
    spread = assessment.uncertainty
    if spread.samples == 1:
        return [
            report.heading("How sure this is"),
            report.paragraph("The data sheet gives single values only, so nothing was sampled."),
        ]
    names = shown_mechanisms(assessment)
    low, high = spread.any.interval
    parts = [
        report.heading("How sure this is"),
        report.paragraph(
            f"{spread.samples} drives were drawn from the given ranges and distributions. {percent(spread.any.value)} "
            f"of them vibrate somewhere in the operating window (95 % sure: {percent(low)} to {percent(high)})."
        ),
    ]
    charts = [
        report.picture(
            pictures.embedded(pictures.reserve_chart, assessment, names), "How the reserve is spread over these drives."
        )
    ]
    name = next((name for name in names if name in spread.total), None)
    if name is not None:
        charts.append(
            report.picture(
                pictures.embedded(pictures.sobol_chart, assessment, name),
                f"Which uncertainty causes the spread of the reserve against {SHORT[name]} (Sobol "
                "indices). The longest bar is what to measure first.",
            )
        )
    return [*parts, report.side_by_side(*charts)]


def locking_sentence(assessment: Assessment) -> str:
    """Say how well the thread lifts, whether it holds its load, and what the rule of thumb says of that."""
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
    third = assessment.values["lead"] < assessment.values["pitch_diameter"] / 3
    # The rule knows no friction, which decides: the thread holds where that of its flanks is above this.
    enough = flank_coefficient(math.tan(assessment.lead_angle), assessment.lead_angle, assessment.values["half_angle"])
    rule = (
        "By the rule of thumb (a lead below a third of the diameter hardly back-drives) it would be "
        f"{'self-locking' if third else 'back-drivable'}; with this lead that is right for friction "
        f"{'above' if third else 'below'} {enough:.3f} only."
    )
    return f"Against the load the thread works with an efficiency of {percent(lifting)}{ends}. {holds} {rule}"


def _locking(assessment: Assessment) -> list[Html]:
    return [
        report.heading("Efficiency and self-locking"),
        report.paragraph(locking_sentence(assessment)),
        report.picture(
            pictures.embedded(pictures.locking_chart, assessment),
            "Friction at which a thread holds its load by itself.",
        ),
    ]
