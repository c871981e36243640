"""The inverse of statics: the value of one entry of a sheet with which a row has some value, or is at its limit.

The row is looked at over the allowed range of the entry; where it passes the value, that place is closed in on.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any, get_args

import numpy as np
from pydantic import BaseModel

from lsvib.errors import InputError
from lsvib.numbers import shown as plainly
from lsvib.sheets.drive_entries import Part
from lsvib.sheets.fields import Allowed, NotQuantity, Spread, quantity
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import Row, row_of
from lsvib.sheets.words import ABOUT, percent, shown
from lsvib.stability.solve import crossings

_DECADES, _PLACES = 14, 43  # of the range of an entry that are looked at, and at how many places
_CLOSE = 1e-9  # relative, of a row to what it shall be: what is further off is a jump


@dataclass(frozen=True)
class Solved:
    """The ``values`` of an ``entry`` in ``unit`` at which a ``row`` has the ``wanted`` value [SI unit], or its limit.

    They are for the middle values of all other entries; the first is nearest to what the sheet gives, or else the
    largest, and ``sheet`` has it. Nearest to it are ``worst``, for the worst case of the row in window and
    uncertainties, and ``best``, for the best case within uncertainties; None where that is the same.
    """

    entry: str
    unit: str
    values: tuple[float, ...]
    worst: float | None
    best: float | None
    row: str
    wanted: float | None
    sheet: Sheet

    @property
    def sentence(self) -> str:
        """The answer in one sentence."""
        found = ", or ".join(shown(value, self.unit, digits=4) for value in self.values)
        ends = {"in the worst case": self.worst, "in the best case": self.best}
        more = ", ".join(
            f"{shown(value, self.unit, digits=4)} {case}" for case, value in ends.items() if value is not None
        )
        goal = "at its limit" if self.wanted is None else _said(self.row, self.wanted)
        return f"{self.entry} = {found}: {self.row} is {goal}{f' ({more})' if more else ''}."

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {"value": self.values[0]} | {key: value for key, value in vars(self).items() if key != "sheet"}


def solved(values: Mapping[str, Any], entry: str, goal: str) -> Solved:
    """Solve the statics of a sheet, as names and values, for one ``entry``, such as load.force, which it need not give.

    ``goal``: a row of statics with its value, or alone for its limit; motor.torque is the torque against the load, at
    the motor or, without a gear, at the screw. Raises ``InputError``, also if no value of the entry meets the goal.

    >>> sheet = {"thread": {"size": "Tr 32x6"}, "friction": {"coefficient": 0.08}}
    >>> solved(sheet, "load.force", "motor.torque = 60 N*m").sentence
    'load.force = 27.68 kN: lifting_torque is 60 N m.'
    """
    row, equals, wanted = (part.strip() for part in goal.partition("="))
    if row == "motor.torque" and equals:  # else what is given of the motor is its limit
        geared = entry == "coupling.gear_ratio" or _given(values, "coupling.gear_ratio") is not None
        row = "motor_torque" if geared else "lifting_torque"
    row, asked = row.replace(".", "_"), row
    if row not in ABOUT:
        more = "; changes that end vibration are listed in the answer without --solve."
        raise InputError(f"{plainly(asked)} is not one of the rows of statics: motor.torque, {', '.join(ABOUT)}{more}")
    ranges = dict(_ranges(Sheet))
    if entry not in ranges:
        own = [one for one in ranges if one.split(".")[0] == entry.split(".")[0]] or ranges
        raise InputError(f"{plainly(entry)} is not a quantity of the sheet; it could be {', '.join(own)}.")
    name, said = row, _given(values, entry)
    try:
        target = quantity(wanted, ABOUT[row]["unit"].strip("1"))[0] if equals else None
        name = entry
        given = None if said is None else Spread.of(said, ranges[entry])
    except NotQuantity as error:
        raise InputError(f"{name} {error}.") from None
    unit = given.unit if given else next(iter(ranges[entry]))
    search = _Search(values, entry, unit, row, target, ranges[entry][unit])
    found = search.roots("middle", given.nominal if given else 0.0)[:: 1 if given else -1]
    if not found:
        raise InputError(search.failure)
    if target is None:  # on the side on which the limit is kept, far below what counts
        beside = (found[0] * (1 + step) for step in (1e-12, -1e-12))
        found[0] = next((one for one in beside if (kept := search.at("middle", one)) and not kept.exceeded), found[0])
    worst, best = (search.other(side, found[0]) for side in ("worst", "best"))
    sheet = search.sheet(found[0])
    sources = sheet.sources | {entry: f"solved for {row}"}
    guesses = {key: text for key, text in sheet.assumptions.items() if key != entry}
    sheet = sheet.model_copy(update={"sources": sources, "assumptions": guesses})
    # Where nothing is uncertain it is the window alone that has a worst case.
    return Solved(entry, unit, tuple(found), worst, None if best == worst else best, row, target, sheet)


def _given(values: Any, path: str) -> Any:
    """What the sheet says of an entry, None if nothing."""
    for part in path.split("."):
        values = values.get(part) if isinstance(values, Mapping) else None
    return values


def _said(row: str, value: float) -> str:
    return percent(value) if row.endswith("efficiency") else shown(value, ABOUT[row]["unit"], digits=4)


def _ranges(model: type[BaseModel], before: str = "") -> Iterator[tuple[str, Allowed]]:
    """Yield the quantities of all parts of a sheet, such as load.mass, with what is allowed of them."""
    for key, about in model.model_fields.items():
        kinds = (about.annotation, *get_args(about.annotation))
        for one in (*about.metadata, *(more for kind in kinds for more in getattr(kind, "__metadata__", ()))):
            if isinstance(one, tuple):
                yield f"{before}{key}", dict(one)
        for kind in kinds:
            if isinstance(kind, type) and issubclass(kind, Part):
                yield from _ranges(kind, f"{before}{key}.")


@dataclass
class _Search:
    """A search for the values of an entry at which a row has the ``wanted`` value, or its limit.

    ``seen``: values of the row over what they shall be; ``refused``: why there was none.
    """

    values: Mapping[str, Any]
    entry: str
    unit: str
    row: str
    wanted: float | None
    ends: tuple[float, float]
    seen: list[float] = field(default_factory=list)
    refused: str = ""

    def sheet(self, value: float) -> Sheet:
        """Return the sheet with a value of the entry."""
        found = place = {**self.values}
        *parts, last = self.entry.split(".")
        for part in parts:
            inner = place.get(part) or {}
            if not isinstance(inner, Mapping):
                raise InputError(f"{part} = {plainly(inner)} is not a set of names and values.")
            place[part] = place = {**inner}
        place[last] = f"{value!r} {self.unit}"
        return Sheet.of(found)

    def at(self, side: str, value: float) -> Row | None:
        """Return the row with a value of the entry, None where there is none to compare; why is kept."""
        try:
            row = row_of(self.sheet(value), self.row, side)
        except InputError as error:
            self.refused = self.refused or str(error)
            return None
        if row is not None and (self.wanted is not None or row.limit is not None):
            return row
        lack = f"{self.row} whatever {self.entry} is" if row is None else f"limit of {self.row}; give a value"
        self.refused = f"The sheet has no {lack}."
        return None

    def gap(self, side: str, value: float) -> float | None:
        """Return how far the row is above what it shall be, between −1 and 1; None where there is no row."""
        if (row := self.at(side, value)) is None or math.isinf(row.worst):
            return None if row is None else 1.0
        aim = (row.limit or 0.0) if self.wanted is None else self.wanted
        self.seen.append(row.worst / (aim or 1.0))
        return (row.worst - aim) / (abs(row.worst) + abs(aim) or 1.0)

    def roots(self, side: str, near: float) -> list[float]:
        """Return the values of the entry, that next to ``near`` first; of its sign, or if there is none the other."""
        at = cache(partial(self.gap, side))
        for sign in (-1, 1) if near < 0 else (1, -1):
            least, most = sorted(sign * end for end in self.ends)
            if most <= 0:
                continue
            sizes = np.geomspace(max(least, most * 10.0**-_DECADES), most, _PLACES).tolist()
            places = sorted({sign * size for size in sizes} | ({0.0} if least <= 0 else set()) | ({near} - {0.0}))
            at(near or places[len(places) // 2])  # which tells best what is wrong, if there is no solution
            found = {place for place in places if at(place) == 0} | set(crossings(at, places, 1e-15))
            true = sorted((one for one in found if abs(at(one) or 0.0) <= _CLOSE), key=lambda one: abs(one - near))
            if true:
                return [one for k, one in enumerate(true) if not any(math.isclose(one, two) for two in true[:k])]
        return []

    def other(self, side: str, near: float) -> float | None:
        """Return the value next to that of the middle values; None where it is the same, or there is none."""
        gap = self.gap(side, near)
        return None if gap is not None and abs(gap) <= _CLOSE else next(iter(self.roots(side, near)), None)

    @property
    def failure(self) -> str:
        """Why there is no solution, in one sentence."""
        if not self.seen:
            return self.refused
        wanted, ends = self.wanted, " and ".join(shown(end, self.unit) for end in self.ends)
        goal = f"brings {self.row} to its limit" if wanted is None else f"makes {self.row} {_said(self.row, wanted)}"
        both = sorted((min(self.seen), max(self.seen)), key=lambda one: one * (wanted or 1.0))
        said = [f"{percent(one)} of it" if wanted is None else _said(self.row, one * wanted) for one in both]
        return f"No {self.entry} between {ends} {goal}: it is {' to '.join(dict.fromkeys(said))}."
