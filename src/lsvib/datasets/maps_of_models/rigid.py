"""Around a map of the rigid drive: the lines Q = 0 and θ′ = 0, and the exact boundary of its basin."""

from lsvib.basins.boundary import basin
from lsvib.basins.curves import Window
from lsvib.datasets import phase_plane
from lsvib.datasets.attributes import Variable, variable
from lsvib.errors import InputError
from lsvib.models.drive import RigidDrive

_LINES = ("contact_line_angle", "contact_line_slope", "stop_velocity")
_BOUNDARY_SAMPLES = 100  # of each arc


def surroundings(drive: RigidDrive, window: Window) -> dict[str, Variable]:
    """Return the lines of a drive and, where :mod:`lsvib.basins.boundary` covers it, boundary and area of its basin.

    The area is that within a window of u [rad] and w [rad/s].
    """
    lines = phase_plane.lines([drive])
    data: dict[str, Variable] = {name: ((), lines[name][1][0], lines[name][2]) for name in lines if name in _LINES}
    try:
        found = basin(drive)
    except InputError:  # the few drives that docs/basin.md lists; the map itself needs no boundary
        return data
    line, words = found.line(window, _BOUNDARY_SAMPLES), "area of the basin of steady sliding within the map, exact"
    data |= phase_plane.curve("boundary", "boundary_point", line, "on the exact boundary")
    data["basin_area"] = variable((), found.area(window), "rad2 s-1", words)
    return data
