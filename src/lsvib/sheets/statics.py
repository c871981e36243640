"""The statics of a screw: torque, efficiency, self-locking, pressure in the nut, column and critical speed.

Formulas are plain, in SI units, for floats and arrays alike. A row of the result has the value at the middle of all
entries and of the window, and the worst one: at the ends of the operating window and of all uncertain entries.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from lsvib.drives.mechanics import holding_coefficient, relieved_half
from lsvib.errors import InputError
from lsvib.sheets import motor, window
from lsvib.sheets.draw import Draw
from lsvib.sheets.formulas import Values, flank_coefficient, sliding_speed, torque
from lsvib.sheets.motor import Floats, Judged
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.threads import NUT_MATERIALS, SCREW_MATERIALS
from lsvib.sheets.uncertainty import ends
from lsvib.sheets.words import ABOUT, TORQUE_PARTS, VERDICTS, WEAK, percent, shown, size

SAFE = 0.8  # share of a critical load or speed that may be used, as Thomson recommends
ENDS = {  # of the shaft: end factor K of the column, and β of its first bending mode (Euler, Bernoulli)
    "fixed-free": (0.25, 1.8751),
    "supported-supported": (1.0, math.pi),
    "fixed-supported": (2.0, 3.9266),
    "fixed-fixed": (4.0, 4.7300),
}


@dataclass(frozen=True)
class Row:
    """One quantity of :data:`lsvib.sheets.words.ABOUT`: ``middle`` and ``worst`` value, its ``limit`` there, if any.

    ``exceeded``: whether the worst value is beyond the limit. ``middle`` is None where a load is lifted or lowered in
    the middle of the window at no time, but at its ends. Of the speed of a screw that the sheet does not give there is
    the limit alone, and ``worst`` is NaN.
    """

    key: str
    middle: float | None
    worst: float
    limit: float | None
    exceeded: bool


@dataclass(frozen=True)
class Statics:
    """All rows; ``back_drives``: whether the load can turn the screw when the current is off.

    False, ``at the middle values`` or ``within the uncertainties``; None if nothing pushes the load. ``falls``: whether
    what pushes it may have the direction of its weight; ``lifts``: that of a draw. ``verdict`` on motor and
    brake, of :data:`lsvib.sheets.words.VERDICTS`, None if they are strong enough; its ``sentence``; ``highest_speed``:
    :func:`lsvib.sheets.motor.highest_speeds`. ``parts``: of the worst torque against the load, by
    :data:`lsvib.sheets.words.TORQUE_PARTS`, ``torque`` [N m], ``share`` [1], and ``guess``, the name of one behind it.
    """

    rows: dict[str, Row]
    back_drives: str | bool | None
    falls: bool
    lifts: int = 0
    verdict: str | None = None
    sentence: str = ""
    highest_speed: dict[str, dict[str, float]] = field(default_factory=dict)
    parts: dict[str, dict[str, Any]] = field(default_factory=dict)

    @property
    def limited(self) -> list[Row]:
        """The rows that have a limit, and a value that is held against it."""
        return [row for row in self.rows.values() if row.limit is not None and not math.isnan(row.worst)]


def nut_pressure(force: Any, pitch_diameter: Any, length: Any, engaged_depth: Any = 0.5) -> Any:
    """Return the pressure [Pa] on the projected area of the threads in a nut, F P / (π d h L).

    ``engaged_depth`` h / P [1]: threads half as deep as their pitch P unless the standard says otherwise.
    """
    return force / (math.pi * pitch_diameter * engaged_depth * length)


def column_load(modulus: Any, yield_strength: Any, diameter: Any, length: Any, end_factor: float) -> Any:
    """Return the axial load [N] at which a round column buckles: Euler's, or Johnson's where it is short.

    Euler: K π² E I / l²; Johnson, where Euler's stress is above half of the yield strength σ: A σ (1 − σ / (4 σ_E)).
    ``modulus`` and ``yield_strength`` [Pa], ``diameter`` of the root and ``length`` [m], ``end_factor`` K [1].

    >>> round(column_load(200e9, 250e6, 0.0155, 0.6, 1.0))
    15535
    """
    area = math.pi / 4 * diameter**2
    euler = end_factor * math.pi**2 * modulus * (diameter / (4 * length)) ** 2
    return area * np.where(2 * euler < yield_strength, euler, yield_strength * (1 - yield_strength / (4 * euler)))


def root_stress(force: Any, torque: Any, diameter: Any) -> Any:
    """Return the stress [Pa] of an axial ``force`` [N] and a ``torque`` [N m] in a round root, √(σ² + 3 τ²), by Mises.

    >>> f"{root_stress(6400.0, 26.18, 28e-3):.4g}"
    '1.479e+07'
    """
    area, section = math.pi / 4 * diameter**2, math.pi / 16 * diameter**3
    return np.sqrt((force / area) ** 2 + 3 * (torque / section) ** 2)


def critical_speed(modulus: Any, density: Any, diameter: Any, length: Any, root: float) -> Any:
    """Return the speed [rad/s] of the first bending mode of a round shaft, β² d / (4 l²) √(E / density).

    ``root`` β [1]: of the ends, π if both are supported; other arguments as :func:`column_load`, in SI units.

    >>> round(critical_speed(200e9, 7850.0, 0.0155, 0.6, math.pi) * 30 / math.pi)
    5121
    """
    return root**2 * diameter / (4 * length**2) * np.sqrt(modulus / density)


def row_of(sheet: Sheet, key: str, side: str = "middle") -> Row | None:
    """Return a row with its value and limit, None where the sheet has no such row.

    ``side``: ``middle`` values, ``worst`` ones, or the ``best`` for which the worst of the window can be hoped within
    the uncertainties.
    """
    found = _at_middle(Draw.of(sheet)) if side == "middle" else _everywhere(Draw.of(sheet, ends(sheet)))
    if key not in found or key in _unasked(sheet):
        return None
    return _row(key, found[key], None, side == "best")


def statics(sheet: Sheet) -> Statics:
    """Return all rows for which a sheet has the entries, at the middle values and at the worst ones."""
    draw = Draw.of(sheet)
    middle, lifts = _at_middle(draw), draw.lifts
    nominal, surely_pushed = _everywhere(draw), _pushed(draw).any()
    draw = Draw.of(sheet, ends(sheet))
    if sheet.friction.curve and not np.all(draw.friction_at(draw.values["speed_high"])[0]):
        raise InputError(
            f"friction.curve ends at {sheet.friction.curve[-1][0]:g} m/s, and the law that fits it falls to zero "
            "before the fastest sliding of the threads; give points up to there."
        )
    worst, unasked = _everywhere(draw), _unasked(sheet)
    rows = {key: _row(key, worst[key], middle.get(key)) for key in ABOUT if key in worst}
    parts = _parts(draw, worst["lifting_torque"][0], *_points(draw)) if "lifting_torque" in worst else {}
    more = {**_weak(rows, nominal), "lifts": lifts, "highest_speed": motor.highest_speeds(draw), "parts": parts}
    holding, pushed = rows["holding_friction"], _pushed(draw)
    falls = bool((pushed * draw.weight > 0).any())
    if not pushed.any():
        rows[holding.key] = replace(holding, exceeded=False)
    whirls = [replace(rows[key], middle=None, worst=math.nan) for key in rows.keys() & {"screw_speed"} & unasked]
    rows = {key: row for key, row in rows.items() if key not in unasked} | {row.key: row for row in whirls}
    if not pushed.any():
        return Statics(rows, None, falls, **more)
    if not holding.exceeded:
        return Statics(rows, False, falls, **more)
    surely = surely_pushed and _row(holding.key, middle[holding.key], None).exceeded
    return Statics(rows, "at the middle values" if surely else "within the uncertainties", falls, **more)


def _at_middle(draw: Draw) -> dict[str, Judged]:
    """All quantities with their limits in the middle of the window."""
    return motor.in_motion(draw, middle=True) | _judged(draw, *_middle(_window(draw)))


def _everywhere(draw: Draw) -> dict[str, Judged]:
    """All quantities with their limits, over the window; the speed of a screw has none from a move."""
    return motor.in_motion(draw) | _judged(draw, *_points(draw))


def _weak(rows: dict[str, Row], nominal: dict[str, Judged]) -> dict[str, Any]:
    """Verdict and sentence on motor and brake, of several rows on one that is exceeded at the ``nominal`` values."""
    exceeded = [rows[key] for key in motor.LIMITED if key in rows and rows[key].exceeded]
    surely = [row for row in exceeded if row.key in nominal and _row(row.key, nominal[row.key], None).exceeded]
    for row in surely or exceeded:
        verdict = f"{'brake' if row.key == 'brake_torque' else 'motor'} {'' if surely else 'may be '}too weak"
        most, has = size(row.worst, "N m"), shown(row.limit, "N m")
        more = f", {percent(1 - (row.limit or 0.0) / row.worst)} too little" if most == has else ""
        has = WEAK["limit" if row.limit else "no limit"].format(has)
        said = VERDICTS[verdict].format(what=WEAK[row.key], needed=most, given=has, more=more)
        return {"verdict": verdict, "sentence": said}
    return {}


def _unasked(sheet: Sheet) -> set[str]:
    """The rows that need a speed or a diameter which the sheet does not give."""
    still, flat = {"sliding_speed", "pv", "screw_speed"}, {"sliding_speed", "pv", "nut_pressure", "holding_friction"}
    return (set() if sheet.runs else still) | (flat if sheet.thread.bare else set())


def _parts(draw: Draw, whole: Floats, speed: Floats, held: Floats, load: Floats) -> dict[str, dict[str, Any]]:
    """The parts of the largest torque of a table (k, n); none where it jams."""
    worst, at = float(np.nanmax(whole)), int(np.nanargmax(whole))
    force, guide, preload = np.abs(load), draw.values.get("slide_friction", 0.0), draw.entries.get("nut.preload", 0.0)
    thread = draw.pitch_radius, draw.lead_angle, draw.friction_at(speed)[0], True
    each, relieved = torque(1.0, *thread), relieved_half(force, preload, draw.entries.get("nut.load_share", 1.0))
    drag = draw.values["translation_damping"] * draw.travel
    rest = {"bearing": draw.values.get("bearing_friction", 0.0), "damping": draw.values["support_damping"] * speed}
    found = rest | {"threads": each * held, "guide": each * guide, "drag": each * drag * speed}
    found["collar"] = draw.pitch_radius * draw.collar * force
    found["preload"] = torque(0.0, *thread, relieved=relieved)
    sizes = {name: float(np.broadcast_to(part, whole.shape).flat[at]) for name, part in found.items()}
    shares: dict[str, dict[str, Any]] = {}
    for name in sorted(filter(sizes.get, sizes), key=lambda name: -abs(sizes[name])) if worst < math.inf else ():
        guesses = filter(None, map(draw.sheet.assumption, TORQUE_PARTS[name]["entries"]))
        shares[name] = {"torque": sizes[name], "share": sizes[name] / worst, "guess": next(guesses, None)}
    return shares


def lets_go(draw: Draw, changed: Draw) -> bool:
    """Whether a drive that holds its load at rest no longer does with ``changed`` quantities."""
    return "holding_friction" in worsened(draw, changed)


def worsened(draw: Draw, changed: Draw) -> set[str]:
    """Return the rows whose limit a drive keeps, but a ``changed`` one does not."""

    def over(own: Draw) -> set[str]:
        """The rows beyond their limits."""
        rows = (_row(key, one, None) for key, one in _everywhere(own).items() if one[1] is not None)
        return {row.key for row in rows if row.exceeded and (row.key != "holding_friction" or _pushed(own).any())}

    return over(changed) - over(draw)


def _pushed(draw: Draw) -> Floats:
    """What pushes the load at rest, against outward travel [N], at both ends of the window (2, n)."""
    return np.stack(np.broadcast_arrays(*(draw.values[f"force_{end}"] + draw.weight for end in ("low", "high"))))


def _window(draw: Draw) -> list[tuple[Floats, Floats, Floats]]:
    """Speeds [rad/s], loads against the travel without and with drag [N], at points of the window, (k, n) a direction.

    They are those at which stability is asked, between its ends too where friction depends on the speed, and those
    nearest to no load and to one that the guide just holds.
    """
    found, drag = [], draw.values["translation_damping"] * draw.values["lead"] / (2 * math.pi)
    pushed, guide = _pushed(draw), draw.values.get("slide_friction", 0.0)
    own = [np.clip(held, pushed.min(), pushed.max()) for held in (0.0, guide, -guide)]
    for direction in draw.sheet.directions:
        speed, force = (table.reshape(len(table), -1) for table in window.points(draw, direction))
        speed = np.concatenate([speed, *(speed[:1] for _ in own)])
        held = direction * np.concatenate([force + draw.weight, *(0 * force[:1] + one for one in own)])
        found.append((speed, held, held + drag * speed + draw.values.get("slide_friction", 0.0)))
    return found


def _points(draw: Draw) -> Iterator[Floats]:
    """The same of all directions together, (k, n)."""
    return (np.concatenate(parts) for parts in zip(*_window(draw), strict=True))


def _middle(window: Sequence[tuple[Floats, Floats, Floats]]) -> tuple[Floats, Floats, Floats]:
    """Speeds and loads (k, 1) in the middle of a window: against which travel goes in it, and with which it goes.

    Where a guide holds the load both ways go against it: then of the way that takes more.
    """
    speed = np.concatenate([one.ravel() for one, _, _ in window])
    found: list[list[float]] = []
    for sign in (1, -1):
        sizes = [[np.clip(sign * load, 0, None) for load in side[1:]] for side in window]
        pairs = [[sign * 0.5 * float(one.min() + one.max()) for one in both] for both in sizes]
        if any(pair[1] for pair in pairs):
            found.append(max(pairs, key=lambda pair: abs(pair[1])))
    held, load = np.array(found or [[0.0, 0.0]]).T[:, :, None]
    return np.full(load.shape, 0.5 * (speed.min() + speed.max())), held, load


def _judged(draw: Draw, speed: Floats, held: Floats, load: Floats) -> dict[str, Judged]:
    """All quantities with their limits, for speeds and loads (k, n), ``held`` at rest; NaN where one does not occur.

    Where the threads jam, μ ≥ cot λ, the torque against the load is infinite.
    """
    sheet, values, entries, collar = draw.sheet, draw.values, draw.entries, draw.collar
    radius, angle, coefficient = draw.pitch_radius, draw.lead_angle, draw.friction_at(speed)[0]
    turns = coefficient * np.tan(angle) < 1  # else the threads jam
    if sheet.preloaded and not turns.all():
        raise InputError(
            "the friction coefficient is at least cot(lead angle), so a preloaded nut jams at any torque; lower "
            "friction or the lead of the thread."
        )
    found: dict[str, Judged] = {}
    at_rest, rest, standing = motor.at_rest(draw)
    bearing, guide = (values.get(key, 0.0) for key in ("bearing_friction", "slide_friction"))
    motion, still = (coefficient, collar, bearing), rest[2]
    left, stuck = (np.clip(np.abs(held) - own, 0.0, None) for own in (guide, standing))  # what the guide does not hold
    nut, needed = (entries.get("nut.preload", 0.0), entries.get("nut.load_share", 1.0)), partial(motor.needed, draw)
    drag, size = values["support_damping"] * speed, np.abs(load)
    against, along = (needed(size, motion, lifting) + drag for lifting in (True, False))
    against = np.where(turns, against, np.inf)
    # The dampings are guesses, on which no brake should count.
    holding, braking = motor.to_hold(draw, held), -needed(left, motion, False)
    for name, acting, effort in (
        ("holding", holding > 0, holding),
        ("starting", (held + standing > 0) & sheet.followed, needed(held + standing, rest, True)),
        ("lifting", (load > 0) | (not load.any()), against),
        ("lowering", (load <= 0) & (along > 0) & (load < 0).any(), along),  # most torque may be next to no load
        ("braking", (held < 0) & (braking > 0), braking),
    ):
        for row, factor in ((f"{name}_torque", 1.0), (f"{name}_power", speed)):
            if row in ABOUT and acting.any() and (sheet.runs or row.endswith("_torque")):
                found[row] = np.where(acting, effort * factor, np.nan), None
    found |= motor.judged(draw, speed, held)
    with np.errstate(divide="ignore", invalid="ignore"):
        useful = np.abs(held) * radius * np.tan(angle)  # per radian
        share = np.where(turns, useful / needed(held + guide, motion, True), 0.0)  # NaN where nothing rubs or moves
        driving = np.where((left > 0) | ~turns, braking, -needed(guide - np.abs(held), motion, True)) / useful
    if (held > 0).any():
        found["load"] = np.where(held > 0, held, np.nan), None
        found["lifting_efficiency"] = np.where(held >= 0, share, np.nan), None
    if held.any():
        found["lowering_efficiency"] = np.where(held != 0, driving, np.nan), None
    asked = (still, stuck, relieved_half(stuck, *nut)) if held.any() else (0.0, 1.0)  # else what any load would need
    found["holding_friction"] = at_rest, _holds_from(draw, *asked)
    found |= _nut(draw, size + relieved_half(size, *nut), sliding_speed(speed, radius, angle))
    loaded = whole = np.where(load >= 0, against, np.abs(along))
    if "collar_friction" in values:  # which stands between the motor and the part that bears the load
        up, down = (needed(size, (coefficient, 0.0, 0.0), lifting) for lifting in (True, False))
        loaded = np.where(load >= 0, np.where(turns, up, np.inf), np.abs(down))
    return found | _shaft(sheet, entries, speed, size, (whole, loaded))


def _holds_from(draw: Draw, bearing: Any, left: Any, relieved: Any = 0.0) -> Any:
    """The friction of the flanks from which on threads, collar and bearing hold what is ``left`` of the load [N]."""
    helps, tangent = draw.collar * left + bearing / draw.pitch_radius, np.tan(draw.lead_angle)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = holding_coefficient(-helps, left, relieved, tangent, 1)
    needed = np.where(left > 0, root, 0.0)  # nothing, where the guide holds all of it
    return flank_coefficient(np.clip(needed, 0.0, None), draw.lead_angle, draw.values["half_angle"])


def _nut(draw: Draw, force: Floats, sliding: Any) -> dict[str, Judged]:
    """Pressure by the ``force`` on the flanks, sliding speed and their product in the nut, or its more loaded half.

    A limit of the sheet goes before that of the material.
    """
    nut, size, entries = draw.sheet.nut, draw.sheet.thread.size, draw.entries
    if nut is None or "nut.length" not in entries:
        return {}
    material = NUT_MATERIALS.get(nut.material or "")
    depth = size.engaged_depth if size else 0.5
    pressure = nut_pressure(force, draw.values["pitch_diameter"], entries["nut.length"], depth)
    return {
        "nut_pressure": (pressure, entries.get("nut.pressure_limit", material and material.pressure_limit)),
        "sliding_speed": (sliding, entries.get("nut.speed_limit")),
        "pv": (pressure * sliding, entries.get("nut.pv_limit", material and material.pv_limit)),
    }


def _shaft(
    sheet: Sheet, entries: Values, speed: Floats, force: Floats, torques: tuple[Floats, Floats]
) -> dict[str, Judged]:
    """The screw as a column, whichever way the ``force`` acts, its speed, and the larger stress of its two sides.

    ``torques``: the whole one, on the side of the motor, and that of the part which bears the load.
    """
    found: dict[str, Judged] = {}
    diameter = entries.get("screw.root_diameter", sheet.thread.size and sheet.thread.size.root_diameter)
    material = SCREW_MATERIALS[sheet.screw.material or "steel"]
    modulus = entries.get("screw.modulus", material.modulus)
    strength = entries.get("screw.yield_strength", material.yield_strength)
    if sheet.screw.ends is not None:
        length = entries["screw.unsupported_length" if "screw.unsupported_length" in entries else "screw.length"]
        factor, root = ENDS[sheet.screw.ends]
        column = column_load(modulus, strength, diameter, length, factor)
        whirling = critical_speed(modulus, entries.get("screw.density", material.density), diameter, length, root)
        found = {"column_load": (force, SAFE * column), "screw_speed": (speed, SAFE * whirling)}
    if diameter is not None and (sheet.screw.density is None or sheet.screw.yield_strength is not None):
        sides = (root_stress(*both, diameter) for both in zip((0.0, force), torques, strict=True))
        found["root_stress"] = np.maximum(*sides), strength
    return found


def _row(key: str, judged: Judged, middle: Judged | None, best: bool = False) -> Row:
    """The row of a quantity at its worst point: nearest to the limit or beyond it, or the largest where it has none.

    ``best``: in that of all draws, the last axis, which is best at its worst point.
    """
    value, limit = judged
    low = key in ("lifting_efficiency", "holding_friction")  # of these the lowest is the worst
    with np.errstate(divide="ignore", invalid="ignore"):  # where no friction is needed to hold
        score = (-1 if low else 1) * (value if limit is None else value / limit)
    value, limits, score = np.broadcast_arrays(value, np.nan if limit is None else limit, score)
    if best and score.ndim:
        highest = np.where(np.isnan(score), -np.inf, score).reshape(-1, score.shape[-1]).max(axis=0)
        score = np.where(highest == np.min(highest[highest > -np.inf]), score, np.nan)
    # several are the worst where a motor gives nothing
    ends = np.where(score == np.nanmax(score), -value if low else value, -np.inf)
    k = np.unravel_index(np.argmax(ends), score.shape) if score.ndim else ()
    found, most = float(value[k]), None if limit is None else float(limits[k])
    exceeded = most is not None and (found < most if low else found > most)
    return Row(key, None if middle is None else _row(key, middle, None).worst, found, most, exceeded)
