"""All cycles of a drive, with what is proved about them, and how a cycle changes over a parameter."""

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from lsvib import numbers, words
from lsvib.answers import attributes as cf
from lsvib.answers.sweep import known_key
from lsvib.drives import friction
from lsvib.drives.drive import IN_WORDS, PART_OF, Drive, zero_if_close
from lsvib.drives.model import model_of
from lsvib.dynamics.boundary import Boundary, known_basin
from lsvib.dynamics.curves import Arc, state_on
from lsvib.dynamics.cycles import Cycle, random_starts, starts
from lsvib.errors import EngineError, InputError
from lsvib.systems.attractor import Attractor, SteadyState, shrinks_areas
from lsvib.systems.automaton import Automaton
from lsvib.systems.continuation import CycleBranch, follow_cycle, span_of
from lsvib.systems.cycles import cycle_from, search
from lsvib.systems.motion import enter
from lsvib.systems.system import MADE_BY


@dataclass(frozen=True)
class Cycles:
    """The ``cycles`` of a drive, attracting ones first, and one of each of its neutral ``families`` (docs/cycles.md).

    ``proved``: a sentence on what is certain beyond the cycles themselves, or empty; ``searched``: a sentence on where
    cycles were sought, empty if none can exist; ``unresolved``: the number of starts whose attractor is not known.

    >>> lsvib.Drive(translation_damping=1000).cycles().cycles
    (Cycle(STICK_SLIP_CYCLE, period=0.0106716029, amplitude=0.0742795197, multipliers=[0.+0.j], found_by='start'),)
    >>> lsvib.Drive().cycles().proved
    'There is no cycle: slip contracts every area of the phase plane.'
    """

    cycles: tuple[Cycle, ...]
    families: tuple[SteadyState, ...]
    proved: str
    searched: str = ""
    unresolved: int = 0

    def to_json(self) -> dict[str, Any]:
        """Return it as plain numbers and names; the period of a family with several frequencies is None."""
        return {
            "cycles": [cycle.to_json() for cycle in self.cycles],
            "neutral_families": [
                {"period": family.period if family.orbit else None, "state": family.state.tolist()}
                for family in self.families
            ],
            "proved": self.proved,
            "searched": self.searched,
            "unresolved_starts": self.unresolved,
        }

    def text(self) -> Iterator[str]:
        """Yield them in lines of text."""
        yield from filter(None, (self.proved, self.searched))
        if not self.cycles:
            yield f"no cycle found{' from the resolved starts' if self.unresolved else ''}"
        for one in self.cycles:
            cycle = one.to_json()
            yield f"{words.plain(cycle['label'])}, {cycle['stability']} (found by: {cycle['found_by']})"
            work = cycle["work"]
            motor, load, *losses = (f"{key} {work[key]:.6g} J" for key in _WORKS)
            rows = [
                ("period", f"{cycle['period']:.12g} s, {1 / cycle['period']:.6g} Hz"),
                ("amplitude", f"{cycle['amplitude']:.12g} rad"),
                ("multipliers", one.multipliers_in_words()),
                ("residual", f"{cycle['residual']:.1g}"),
                ("work per cycle", f"done by {motor}, {load}"),
                ("", f"dissipated by {', '.join(losses)}"),
            ]
            yield words.table([("", *row) for row in rows])
        for family in self.families:
            period = f"one of them with period {family.period:.9g} s" if family.orbit else "of several frequencies"
            yield f"a family of neutral oscillations, {period}"


_WORKS = ("motor", "load", "friction", "damping", "impacts")


def find_cycles(drive: Drive, automaton: Automaton) -> Cycles:
    """Return all cycles of a drive that are found; ``automaton`` is the drive's, with its resume rule.

    From starts, on the edges of basins, and at the boundary of the basin of steady sliding where that is known.
    """
    if shrinks_areas(automaton):
        return Cycles((), (), "There is no cycle: slip contracts every area of the phase plane.")
    proved, known = "", None
    if (basin := known_basin(drive)) is not None:
        if basin.boundary == Boundary.NONE:
            far = " up to 10⁵ times the input speed" if friction.depends_on_speed(drive) else ""
            return Cycles((), (), f"There is no cycle{far}: steady sliding is globally stable{far}.")
        kind = basin.boundary.name.lower().replace("_", " ")
        proved = f"Not every motion settles: the basin of steady sliding is bounded by a {kind}."
        if basin.boundary == Boundary.CYCLE:
            arcs = [piece for piece in basin.curves[0] if isinstance(piece, Arc)]
            mode, start = enter(automaton, state_on(basin.flow, arcs[0], 0.5 * arcs[0].duration))
            known = cycle_from(automaton, start, mode, len(arcs), "boundary of the basin")
    model = model_of(drive)
    given = [{"u": u, "w": w} for u, w in starts(drive)]
    if "motor" in drive.parts:  # the starts leave the motor at steady sliding; here all stands
        given.append(model.from_rest(drive))
    states = [model.initial_state(drive, start) for start in given] + random_starts(drive)
    found = search(automaton, states, known)
    if not found.cycles and len(found.unresolved) == len(states):
        why = "; ".join(sorted(set(found.unresolved)))
        # A contact may be so stiff that motions take too much work.
        softer = ", or reduce contact_stiffness and contact_damping" if "threads" in drive.parts else ""
        raise EngineError(
            f"the motions from all {len(states)} starts are unresolved ({why}), so the cycles of this drive are "
            f"not known; examine one motion with lsvib simulate{softer}."
        )
    searched = f"Searched: {found.searched}; there may be other cycles."
    cycles = tuple(Cycle.of(drive, cycle) for cycle in found.cycles)
    return Cycles(cycles, found.families, proved, searched, len(found.unresolved))


def followed(
    drive: Drive,
    cycle: Cycle,
    parameter: str,
    span: Any,
    points: Any,
    build: Callable[[Any], Automaton],
    progress: numbers.Progress | None = None,
) -> CycleBranch:
    """Follow a cycle over a parameter as :meth:`lsvib.Drive.follow`; ``build`` makes the automaton of a drive."""
    if not isinstance(cycle, Cycle):
        raise InputError("follow takes one cycle, such as drive.cycles().cycles[0].")
    if cycle.drive != drive:
        raise InputError("the cycle belongs to another drive; take one of this drive's cycles().")
    known_key(parameter)
    if getattr(drive, parameter) is None:
        raise InputError(
            f"{parameter} is a parameter of {IN_WORDS[PART_OF[parameter]]}, which this drive does not have."
        )
    here = float(getattr(drive, parameter))
    ends, most = span_of("drive", parameter, here, span, points)
    for end in ends:
        drive.replace(**{parameter: end})

    def at(value: float) -> Drive:
        return drive.replace(**{parameter: zero_if_close(parameter, value)})

    made = lru_cache(8)(lambda value: build(at(value)))
    branch = follow_cycle(cycle, made, parameter, here, ends, most, progress)
    return replace(branch, points=tuple(replace(x, cycle=Cycle.of(at(x.value), x.cycle)) for x in branch.points))


def branch_dataset(branch: CycleBranch) -> xr.Dataset:
    """Return a branch of cycles, of a drive or of any system, along ``point``; its changes are an attribute."""
    cycles, values = [point.cycle for point in branch.points], [point.value for point in branch.points]
    of_drive, parts = isinstance(cycles[0], Cycle), np.array([cycle.multipliers for cycle in cycles])
    table = {
        "along": ([point.along for point in branch.points], "1", "length of the branch from its start"),
        "period": ([cycle.period for cycle in cycles], "s", "period of the cycle", "$T$"),
        "amplitude": ([x.amplitude for x in cycles], "rad" if of_drive else "1", "amplitude, half its peak-to-peak"),
        "multiplier_error": ([cycle.multiplier_error for cycle in cycles], "1", "error bound of the multipliers"),
        "period_residual": ([cycle.residual for cycle in cycles], "1", "change of the state over a period"),
    }
    data = {branch.parameter: cf.variable("point", values, "1", f"parameter {branch.parameter}")}
    data |= cf.columns("point", table)
    data["attracting"] = cf.yes_no("point", [cycle.attracting for cycle in cycles], "whether the cycle attracts")
    for part, word in (("real", "real"), ("imag", "imaginary")):
        dims, words_of = ("point", "multiplier_number"), f"{word} part of the Floquet multipliers"
        own = getattr(parts, part).reshape(len(cycles), -1)
        data[f"multiplier_{word}_part"] = cf.variable(dims, own, "1", words_of)
    about = {"title": f"A cycle of a system over {branch.parameter}", **MADE_BY, "system": branch.system}
    if isinstance(cycles[0], Cycle):
        drive = cycles[0].drive
        fixed = [(key, value) for key, value in drive if key != branch.parameter]
        data |= cf.varied("point", **{branch.parameter: values}) | cf.given(fixed)
        data["attractor"] = cf.flagged("point", [cycle.label for cycle in cycles], "kind of cycle", Attractor)
        about = cf.about_drive(drive, fixed) | {
            "title": f"A cycle of the lead-screw drive over {branch.parameter}",
            "source": "lsvib, Newton's method on the exact return map, pseudo-arclength continuation",
            "references": "doi:10.1007/978-1-4419-1752-2_8",
        }
    return cf.answer(data, {}, about | {"changes": json.dumps(branch_json(branch)["changes"])})


def branch_json(branch: CycleBranch) -> dict[str, Any]:
    """Return a branch as plain numbers and names."""
    names = ("attracting", "period", "amplitude", "residual")
    points: list[dict[str, Any]] = []
    for x in branch.points:
        label = {"label": x.cycle.label.name.lower()} if isinstance(x.cycle, Cycle) else {}
        own = {name: getattr(x.cycle, name) for name in names}
        points.append({"value": x.value, **label, **own, "multipliers": x.cycle.to_json_multipliers()})
    return {"parameter": branch.parameter, "points": points, "changes": [asdict(x) for x in branch.changes]}


def branch_text(branch: CycleBranch) -> Iterator[str]:
    """Say a branch in lines."""
    name, values = branch.parameter, [point.value for point in branch.points]
    yield f"{len(values)} cycles, {name} from {min(values):.9g} to {max(values):.9g}"
    for change in branch.changes:
        kind = f"{change.kind} ({change.name})" if change.name not in ("", change.kind) else change.kind
        yield f"{kind} at {name} = {change.value:.12g}: {change.what}"
