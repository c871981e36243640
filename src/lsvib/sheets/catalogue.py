"""Changes that can be bought, as entries that a reader could type; of each is asked all that the verdict asks."""

import math
import re
from collections.abc import Iterator
from itertools import combinations, islice, product
from typing import Any, NamedTuple

from lsvib.drives.drive import STATIC
from lsvib.drives.pairings import PAIRINGS
from lsvib.errors import InputError
from lsvib.sheets.changes import MOST, Asker, Change, applied, damping_sizes, knocked
from lsvib.sheets.draw import PAIRS, Draw
from lsvib.sheets.formulas import FRICTION, torque
from lsvib.sheets.from_rest import Starter
from lsvib.sheets.statics import lets_go, worsened
from lsvib.sheets.threads import ThreadSize, catalogue, pairings
from lsvib.sheets.uncertainty import ends
from lsvib.sheets.words import BUY, QUANTITIES

NEAR = 2.0  # the factor within which one change is enough, and each of two
STEPS = (1.5, NEAR, MOST)  # of the stiffness of couplings, and one over the friction of guides and bearings
_STARTED = 60  # drives that are started for single things, and as many for pairs
_SAID = {"holding_friction"}  # rows whose limit may be exceeded, as the answer says so
_FAMILY = {name: re.sub("_(dry|lubricated|wet|oil)$", "", name) for name in PAIRINGS}
_UNITS = {one.entry: re.sub(" ([a-z]+)-1$", r"/\1", one.unit) for one in QUANTITIES.values()}


class Step(NamedTuple):
    """One thing that can be bought, of a ``kind`` (of :data:`lsvib.sheets.words.BUY`) and a ``name``, if it has one.

    ``entries`` of the sheet with it, None for one that is left out; ``change`` [1]: the largest factor of a quantity,
    above 1, :data:`NEAR` of a damper by its size; ``value``: what it has or adds, in SI units.
    """

    kind: str
    name: str
    entries: dict[str, Any]
    change: float
    value: float | None = None


class Purchase(NamedTuple):
    """One thing or two that end vibration or jerks, the ``draw`` that has them; ``left`` as of a change advised."""

    steps: tuple[Step, ...]
    draw: Draw
    left: str = ""


def purchases(draw: Draw, starter: Starter) -> list[Purchase]:
    """Return what can be bought to end what a drive does at its middle values, the nearest first.

    Up to three single things, and two pairs where none is within a factor of two; none that exceeds another limit.
    Last come those that let go of a load which the screw held, of kinds of which none holds it.
    """
    asker, ways = Asker(draw, starter), [way for way in _ways(draw) if way]
    found, last = dict[str, Purchase](), dict[str, Purchase]()
    for step in sorted((step for way in ways for step in way), key=lambda step: step.change):
        if step.kind not in found and len(found) < 3 and (one := _ending(asker, _STARTED, step)):
            (last if drops(draw, one) else found).setdefault(step.kind, one)
    found = dict(islice((found | {kind: one for kind, one in last.items() if kind not in found}).items(), 3))
    if not any(step.change <= NEAR for one in found.values() for step in one.steps):
        near = [own for way in ways if (own := [step for step in way if step.change <= NEAR])]
        found |= {" ".join(step.kind for step in one.steps): one for one in islice(_pairs(asker, near), 2)}
    return [one._replace(left=knocked(one.draw)) for one in found.values()]


def drops(draw: Draw, row: Change | Purchase) -> str:
    """Say that a load held at rest ``drops``, or ``can drop`` within the uncertainties, with a change, or nothing."""
    old = _both(draw)
    new = [applied(one, row) for one in old] if isinstance(row, Change) else _both(row.draw)
    found = zip(("drops", "can drop"), old, new, strict=True)
    return next((verb for verb, *pair in found if lets_go(*pair)), "")


def _both(draw: Draw) -> tuple[Draw, Draw]:
    """A drive at the middle values, and those at the ends of all uncertain entries."""
    return draw, Draw.of(draw.sheet, ends(draw.sheet))


def _pairs(asker: Asker, ways: list[list[Step]]) -> Iterator[Purchase]:
    """Yield pairs that end all, of two kinds each: if the strongest ones do, the nearest."""
    last = asker.started + _STARTED
    for first, second in combinations(ways, 2):
        if first[0].kind != second[0].kind and (most := _ending(asker, last, first[-1], second[-1])):
            both = sorted(product(first, second), key=lambda pair: max(step.change for step in pair))
            yield next((one for pair in both if (one := _ending(asker, last, *pair))), most)


def _ending(asker: Asker, last: int, *steps: Step) -> Purchase | None:
    """What is bought, if it ends all and exceeds no limit; None as well once so many drives were started."""
    if asker.started >= last:
        return None
    entries = {path: value for step in steps for path, value in step.entries.items()}
    if "friction.pairing" in entries:
        entries.pop("friction.coefficient", None)  # of a thread
    try:
        own, worst = _both(Draw.of(asker.draw.sheet.with_entries(entries)))
    except InputError:  # it does not fit the rest of the sheet
        return None
    good = worsened(asker.draw, own) <= _SAID and not asker.left(own)
    return Purchase(steps, own) if good and worsened(_both(asker.draw)[1], worst) <= _SAID else None


def _ways(draw: Draw) -> Iterator[list[Step]]:
    """Yield the ways in which something else can be bought, of each the nearest step first."""
    entries, most = draw.entries, _dampers(draw)
    for way in (*_threads(draw), *_pairings(draw), _oil(draw)):
        yield sorted((step for step in way if step.change <= MOST), key=lambda step: step.change)
    for kind, about in BUY.items():
        free = [path for path in about.get("entries", ()) if not draw.sheet.is_fixed(path)]
        given = [path for path in free if entries.get(path)]
        if "power" in about and given:
            scaled = [{path: _typed(entries[path] * by ** about["power"], path) for path in given} for by in STEPS]
            yield [Step(kind, "", own, by) for by, own in zip(STEPS, scaled, strict=True)]
        elif "adds" in about and free and not draw.sheet.is_fixed(QUANTITIES[about["adds"]].entry):
            (path,), old = free, draw.values[about["adds"]]
            top = max(most.get(about["adds"], 0.0), (MOST - 1) * old)
            powers = range(math.floor(math.log10(top)) - 2, 1 + math.floor(math.log10(top))) if top else ()
            series = (float(f"{figure}e{power}") for power in powers for figure in (1, 2, 5))
            sizes = [size for size in series if 0.2 * old <= size <= top]  # less would hardly matter
            by = {more: 1 + more / old if more <= (MOST - 1) * old else NEAR for more in sizes}
            yield [Step(kind, "", {path: _typed(entries.get(path, 0.0) + x, path)}, by[x], x) for x in sizes]


def _dampers(draw: Draw) -> dict[str, float]:
    """The largest dampers that are worth buying: critical ones, which at most double the force or torque in motion."""
    values, speed = draw.values, draw.values["speed_high"]
    push = max(abs(values[key] + draw.weight) for key in PAIRS["force"]) + values.get("slide_friction", 0.0)
    effort = torque(push, draw.pitch_radius, draw.lead_angle, draw.friction_at(speed)[0], True, draw.collar)
    found = {"support_damping": float(effort) / speed, "translation_damping": push / (draw.travel * speed)}
    return {key: min(most or math.inf, 2 * damping_sizes(values)[key]) for key, most in found.items()}


def _typed(value: float, path: str) -> str:
    """An entry as one types it, in SI units."""
    return f"{value:.6g} {_UNITS.get(path, 'kg m2')}".removesuffix(" 1")  # one without a quantity is coupling.inertia


def _oil(draw: Draw) -> list[Step]:
    """A slideway oil, with which friction of threads and guide is no higher at rest than in slow sliding."""
    changes = {}
    for key in ("static_friction_coefficient", "slide_static_friction"):
        slow, path = sum(draw.values.get(one, 0.0) for one in STATIC[key]), QUANTITIES[key].entry
        if key in draw.values and slow and not draw.sheet.is_fixed(path):
            changes[path] = draw.values[key] / slow
    return [Step("oil", "", dict.fromkeys(changes), max(changes.values()))] if changes else []


def _threads(draw: Draw) -> Iterator[list[Step]]:
    """Yield ways to larger and smaller leads of the same diameter, and to larger and smaller diameters."""
    sheet, values, size, found = draw.sheet, draw.values, draw.sheet.thread.size, dict[Any, ThreadSize]()
    both = ("lead", "pitch_diameter")
    fixed = [key for key in both if sheet.is_fixed(QUANTITIES[key].entry)]
    slides = values["friction_coefficient"] >= 0.03  # else it is a ball screw, which is another catalogue
    sizes = catalogue(values["half_angle"]) if slides else []

    def change(one: ThreadSize) -> float:
        """The larger of the changes of lead and pitch diameter."""
        return round(math.exp(max(abs(math.log(getattr(one, key) / values[key])) for key in both)), 9)

    base = size or min(sizes, key=change, default=None)
    for one in sorted(sizes, key=lambda one: abs(round(math.log(one.lead / values["lead"]), 6))):
        if (
            base
            and one != size
            and len(fixed) < 2
            and all(math.isclose(getattr(one, key), values[key]) for key in fixed)
        ):
            same = math.isclose(one.nominal_diameter, base.nominal_diameter)
            found.setdefault(("lead", round(one.lead, 9)) if same else (both[1], round(one.nominal_diameter, 9)), one)
    # A measured efficiency is that of the old thread; the friction behind it stays.
    friction = _friction(draw) if sheet.friction.efficiency else {}
    for key, larger in product(both, (True, False)):
        own = [one for (what, _), one in found.items() if what == key and (getattr(one, key) > values[key]) == larger]
        yield [Step("thread", one.name, {"thread.size": one.name, **friction}, change(one)) for one in own]


def _pairings(draw: Draw) -> Iterator[list[Step]]:
    """Yield ways to less friction: another lubricant for the same nut, and another nut on a steel screw."""
    sheet, level, screw = draw.sheet, draw.values["friction_coefficient"], draw.sheet.screw.material or "steel"
    named = (*pairings(sheet.nut and sheet.nut.material, screw), sheet.friction.pairing or "")
    own, found = {_FAMILY.get(name) for name in named}, dict[str, list[Step]](lubricant=[], nut=[])
    for name, one in PAIRINGS.items():
        middle, kind = one.parameters()["friction_coefficient"], "lubricant" if _FAMILY[name] in own else "nut"
        barred = kind == "nut" and (sheet.is_fixed("nut.material") or "steel_on_steel" in name)  # which would seize
        if barred or one.law or middle >= level or not screw.endswith("steel"):
            continue
        changing = sheet.friction.law or sheet.friction.sloped
        entries: dict[str, Any] = _friction(draw, middle) if changing else {"friction.pairing": name}
        if kind == "nut" and sheet.nut and sheet.nut.length:
            entries["nut.material"] = _FAMILY[name].removeprefix("steel_on_")
        found[kind].append(Step(kind, name, entries, level / middle, middle))
    yield from () if sheet.is_fixed("friction.coefficient") else found.values()


def _friction(draw: Draw, level: float | None = None) -> dict[str, Any]:
    """Entries of friction with its coefficient or another one, and what changes it with the speed in proportion."""
    share = level / draw.values["friction_coefficient"] if level else 1.0
    found = dict[str, Any]({"friction.stribeck_exponent": 2} if draw.sheet.friction.stribeck_exponent == 2 else {})
    for key in (*FRICTION, "stribeck_speed"):
        if key == "friction_coefficient" or QUANTITIES[key].entry in draw.entries:
            value = draw.values[key] * (share if key in FRICTION else 1.0)
            found[QUANTITIES[key].entry] = _typed(value, QUANTITIES[key].entry)
    return found
