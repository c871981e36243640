"""All cycles of a drive, with what is proved about them: exact boundaries of basins, attractors, and return maps."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lsvib.basins.exact_basin import Basin, Boundary, basin
from lsvib.cycles.attractors import SteadyState
from lsvib.cycles.periodic import Cycle
from lsvib.cycles.search import Seed, search, starts
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.registry import find_model
from lsvib.drives.rigid import rigid_automaton
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar
from lsvib.errors import LsvibError


@dataclass(frozen=True)
class Cycles:
    """The ``cycles`` of a drive, attracting ones first, and ``families`` of neutral oscillations, one of each.

    ``proved`` is a sentence on what is certain beyond the cycles themselves; empty if nothing is.
    """

    cycles: tuple[Cycle, ...]
    families: tuple[SteadyState, ...]
    proved: str

    def to_json(self) -> dict[str, Any]:
        """Return the cycles, the families and what is proved, as plain numbers and names."""
        return {
            "cycles": [cycle.to_json() for cycle in self.cycles],
            "neutral_families": [{"period": family.period, "state": family.state.tolist()} for family in self.families],
            "proved": self.proved,
        }


def find_cycles(drive: RigidParameters, automaton: Automaton) -> Cycles:
    """Return all cycles of a drive that are found; ``automaton`` is the drive's, with its rule of resuming.

    Of the rigid drive attracting and repelling ones, of others those that some starts reach.
    """
    if len(automaton.states) > 2:
        model = find_model(drive.model)
        states = [model.initial_state(drive, {"u": u, "w": w}) for u, w in starts(drive)]
        return Cycles(*map(tuple, search(drive, automaton, states)), "")
    if automaton.contracts and (automaton.tables.flow[:, flow_planar.ALPHA] > 0).any():
        return Cycles((), (), "There is no cycle: slip makes every area of the phase plane smaller.")
    try:
        found = basin(drive)
    except LsvibError:  # steady sliding attracts nothing, or its basin is of a shape that is not covered
        found = None
    if found is not None and found.boundary == Boundary.NONE:
        return Cycles((), (), "There is no cycle: steady sliding is globally stable.")
    states = [np.array(start) for start in starts(drive)]
    cycles, families = search(drive, automaton, states, _boundary(found, automaton) if found else ())
    proved = ""
    if found is not None:
        kind = found.boundary.name.lower().replace("_", " ")
        proved = f"Not every motion settles; the boundary of the basin of steady sliding is exact (its kind: {kind})."
    return Cycles(tuple(cycles), tuple(families), proved)


def _boundary(found: Basin, automaton: Automaton) -> list[Seed]:
    """The cycle that bounds a basin, as a start of the search."""
    if found.boundary != Boundary.CYCLE:
        return []
    codes = rigid_automaton(found.drive).codes
    arcs = [piece for piece in found.curves[0] if hasattr(piece, "mode")]
    mode = automaton.codes.tolist().index(codes[arcs[0].mode])
    return [Seed(np.array(arcs[0].start, dtype=float), mode, len(arcs), "boundary of the basin")]
