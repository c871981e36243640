"""The short answer: what statics and margins say of a drive, in a few sentences and one table."""

import math
from typing import Any

from markupsafe import Markup

from lsvib.assess.assessment import Assessment
from lsvib.assess.margins import Margin, changeable
from lsvib.assess.materials import NUT_MATERIALS
from lsvib.assess.starting import BEYOND
from lsvib.assess.statics import ABOUT, Row, Statics, lets_go
from lsvib.assess.words import VERDICTS, change, percent, shown

_NUT_LIMITS = {"nut_pressure": "pressure_limit", "sliding_speed": "speed_limit", "pv": "pv_limit"}


def brief(assessment: Assessment) -> list[str]:
    """Return the short answer for the shell, a sentence or two to a line: verdict, statics, limits, three changes."""
    known = 0 < (assessment.starting.even_speed or 0.0) < math.inf
    told = assessment.verdict not in ("vibrates", "steady without reserve") or known
    first = " ".join(filter(None, (VERDICTS[assessment.verdict], from_rest(assessment) if told else "")))
    return [first, *of_statics(assessment.statics), *_changes(assessment)]


def from_rest(assessment: Assessment) -> str:
    """Say from which speed on a drive runs evenly once started from rest, and how it jerks below; or nothing."""
    found = assessment.starting
    if found.jerks is None:
        return "Whether it becomes steady once started from rest is not known."
    if not found.jerks and not found.even_speed:
        return ""
    if not found.jerks:
        return f"Started from rest it runs evenly from {_speed(assessment, found.even_speed)} on."
    moved, end = found.motion, "up to which speed it does so is not known"
    if found.even_speed == math.inf:
        end = f"it does so up to {BEYOND:g} times the highest speed of the window, at least"
    elif found.even_speed:
        end = f"from {_speed(assessment, found.even_speed)} on it runs evenly"
    how = "goes on vibrating"
    if moved is not None and moved.frequency is not None and moved.amplitude is not None:
        size = shown(2 * moved.amplitude, "m")
        how = f"jerks {shown(moved.frequency, '')} times a second by {size}"
        if moved.audible:
            how = f"vibrates with {shown(moved.frequency, 'Hz')} over {size}"
    way = ""
    if assessment.draw.sheet.operation.direction == "both":
        way = " outward" if found.there.direction > 0 else " back"
    return f"Started from rest{way} at {_speed(assessment, found.there.speed)} it {how}; {end}."


def _speed(assessment: Assessment, speed: float | None) -> str:
    """A speed of the screw in words, with that of the load."""
    load = assessment.draw.travel * (speed or 0.0)
    return f"{shown(speed, 'rad/s')} ({shown(load, 'm/s')} at the load)"


def of_statics(found: Statics) -> list[str]:
    """Return what statics say: whether the load is held, torques and efficiency, limits that are exceeded."""
    return [line for line in (holding(found), _effort(found), limits(found)) if line]


def holding(statics: Statics) -> str:
    """Say whether the load stays where it is when the current is off; static friction counts."""
    found, row = statics.back_drives, statics.rows["holding_friction"]
    if found is None:
        return "Nothing pushes the load while it is at rest."
    worst = "" if row.worst == row.middle else " at worst"
    why = f"friction at rest is {shown(row.worst, '')}{worst}; at least {shown(row.limit, '')} is needed to hold"
    if found is False:
        back = statics.rows["lowering_efficiency"]
        never = " Once it moves, it does not stop by itself." if (back.middle or 0.0) > 0 else ""
        runs_on = never or (" Once it moves, it may not stop by itself." if back.worst > 0 else "")
        return f"The screw holds its load when the current is off: {why}.{runs_on}"
    drops = found == "at the middle values"
    if statics.falls:
        text = f"The load {'drops' if drops else 'can drop'} when the current is off"
    else:
        text = f"The force on the load {'turns' if drops else 'can turn'} the screw back when the current is off"
    return f"{text}, unless a brake or the motor holds it: {why}."


EFFORTS = {"lifting": "against the load", "lowering": "with the load", "braking": "to brake, where the load turns it"}
"""What torques are for, the most demanding first."""


def _effort(statics: Statics) -> str:
    """Say which torque, power and efficiency the drive has."""
    rows, found = statics.rows, []
    for name, way in EFFORTS.items():
        if f"{name}_torque" in rows:
            pair = [(rows[f"{name}_torque"], "N m"), (rows[f"{name}_power"], "W")]
            worst = " and ".join(size(row.worst, unit) for row, unit in pair)
            middle = " and ".join(shown(row.middle, unit) for row, unit in pair)
            if pair[0][0].middle is None:
                middle, end = f"{worst} at worst", ""
            else:
                end = f" ({worst} at worst)" if worst != middle else ""
            found.append(f"{middle}{end} {way}")
    for name, way in (("starting_torque", "to start"), ("holding_torque", "to hold at rest")):
        if name in rows:
            found.append(f"{shown(rows[name].worst, 'N m')} {way} at worst")
    row = rows["lifting_efficiency"]
    low = "" if row.worst == row.middle else f", {percent(row.worst)} at worst"
    return f"The screw takes {'; '.join(found)}. Efficiency against the load: {percent(row.middle)}{low}."


def limits(statics: Statics) -> str:
    """Say which limits of nut and screw are exceeded, if the sheet gives any."""
    found = [row for row in statics.limited if row.key != "holding_friction"]
    exceeded = [row for row in found if row.exceeded]
    if not found:
        return ""
    if not exceeded:
        return f"All limits of nut and screw are kept ({len(found)} checked)."
    each = []
    for row in exceeded:
        value, limit = (shown(figure, ABOUT[row.key][1]) for figure in (row.worst, row.limit))
        end = f"the limit is {limit}"
        if value == limit and row.limit:  # in three digits
            end = f"{percent(row.worst / row.limit - 1)} above the limit"
        each.append(f"{_short(row)} reaches {value}, {end}")
    return f"{len(exceeded)} of {len(found)} limits of nut and screw exceeded: {'; '.join(each)}."


def _short(row: Row) -> str:
    """The name of a row for the middle of a sentence."""
    name = ABOUT[row.key][0].partition(";")[0].partition(",")[0]
    return name if name == "PV" else name[0].lower() + name[1:]


def _changes(assessment: Assessment) -> list[str]:
    """What ends vibration or jerks at the middle values: the three smallest single changes, by a factor of three."""
    if assessment.verdict not in ("vibrates", "jerks"):
        return []
    each = [changed(assessment, row) for row in helping(assessment)]
    if assessment.verdict == "vibrates":
        each += [
            f"{row.about.words} of at least {shown(row.value, row.about.unit)}, of which the sheet gives none"
            for row in assessment.margins
            if row.factor is None and row.value is not None
        ]
    what = "the vibration" if assessment.verdict == "vibrates" else "the jerks"
    if not each:
        return [f"No change of one quantity that was tried, by a factor of three at most, ends {what}."]
    which = "Each of these changes alone" if len(each) > 1 else "This change alone"
    return [f"{which} ends {what} at the middle values: {'; '.join(each)}."]


def helping(assessment: Assessment) -> list[Margin]:
    """Return up to three changes of one quantity by a factor of three or less that end vibration or jerks."""
    rows = assessment.margins if assessment.verdict == "vibrates" else assessment.starting.changes
    return [row for row in rows if row.is_near(3.0)][:3]


def changed(assessment: Assessment, row: Margin) -> str:
    """Say how a quantity changes, and whether the load drops then."""
    values = assessment.draw.values
    keys = changeable(values).get(row.quantity, ())
    drops = lets_go(assessment.draw, {key: values[key] * (row.factor or 1.0) for key in keys})
    remark = " (but then the load drops when the current is off)" if drops else ""
    return f"{row.about.words} {change(row.factor)}{remark}"


def rows(assessment: Assessment) -> list[tuple[Any, ...]]:
    """Return the rows of the table: name, middle, worst, limit, formula with source; vibration first."""
    share = assessment.uncertainty.any.value
    often = f"vibrates in {percent(share)} of drives" if share > 0 else "steady in all drives that were drawn"
    if assessment.starting.jerks:
        often = "jerks or vibrates from rest"
    bad = "vibrate" in assessment.verdict or assessment.starting.jerks
    over = Markup('<b class="over">{}</b>').format
    worst = over(often) if bad else often
    found: list[tuple[Any, ...]] = [
        ("Vibration", assessment.verdict, worst, "none is wanted", ("see below", "what can make it vibrate"))
    ]
    for row in assessment.statics.rows.values():
        name, unit, formula, source = ABOUT[row.key]
        nut = assessment.draw.sheet.nut
        if nut is not None and row.key in _NUT_LIMITS and row.limit is not None:
            own = getattr(nut, _NUT_LIMITS[row.key]) is not None
            source += f"; limit: {'the data sheet' if own else NUT_MATERIALS[nut.material or ''].source}"
        write = percent if row.key.endswith("efficiency") else lambda value, unit=unit: size(value, unit)
        title = tuple(part.strip() for part in name.split(";")) if ";" in name else name
        most = (over(write(row.worst)), "limit exceeded") if row.exceeded else write(row.worst)
        found.append((title, write(row.middle), most, _limit(row, unit), (formula, source)))
    return found


def size(value: float | None, unit: str) -> str:
    """Return a quantity in words; a torque against threads that jam is infinite."""
    return "any (it jams)" if value is not None and math.isinf(value) else shown(value, unit)


def _limit(row: Row, unit: str) -> Any:
    if not row.limit:
        return "–" if row.limit is None else "none is needed"
    share = percent(row.worst / row.limit)
    if row.key == "holding_friction":
        return f"at least {shown(row.limit, unit)}", f"it has {share} of that at worst"
    return shown(row.limit, unit), f"{share} of it at worst"
