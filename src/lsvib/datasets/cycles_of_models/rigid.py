"""The cycles of the rigid drive: what the contraction of areas and the exact basin prove of them."""

import numpy as np

from lsvib.basins.boundary import Basin, Boundary, basin
from lsvib.datasets.cycles import Cycles, searched
from lsvib.dynamics.cycles import Seed
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import layout
from lsvib.errors import LsvibError
from lsvib.models.drive import RigidDrive
from lsvib.models.rigid import rigid_automaton


def find_cycles(drive: RigidDrive, automaton: Automaton) -> Cycles:
    """Return all cycles of a drive that are found, as :func:`lsvib.datasets.cycles.find_cycles` does."""
    if automaton.contracts and (automaton.tables.flow[:, layout.ALPHA] > 0).any():
        return Cycles((), (), "There is no cycle: slip makes every area of the phase plane smaller.")
    try:
        exact = basin(drive)
    except LsvibError:  # steady sliding attracts nothing, or its basin is of a shape that is not covered
        return searched(drive, automaton)
    if exact.boundary == Boundary.NONE:
        return Cycles((), (), "There is no cycle: steady sliding is globally stable.")
    kind = exact.boundary.name.lower().replace("_", " ")
    proved = f"Not every motion settles; the boundary of the basin of steady sliding is exact (its kind: {kind})."
    return searched(drive, automaton, _boundary(exact, automaton), proved)


def _boundary(found: Basin, automaton: Automaton) -> list[Seed]:
    """The cycle that bounds a basin, as a start of the search."""
    if found.boundary != Boundary.CYCLE:
        return []
    codes = rigid_automaton(found.drive).codes
    arcs = [piece for piece in found.curves[0] if hasattr(piece, "mode")]
    mode = automaton.codes.tolist().index(codes[arcs[0].mode])
    return [Seed(np.array(arcs[0].start, dtype=float), mode, len(arcs), "boundary of the basin")]
