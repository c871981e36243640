"""The basin of steady sliding: its exact size against force, damping, mass and friction, and against grids."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from lsvib.basins.boundary import Basin, Boundary, basin
from lsvib.basins.curves import Window, sampled
from lsvib.basins.grid import Axis, Grid
from lsvib.basins.mapper import mapper
from lsvib.datasets import phase_plane, spans
from lsvib.datasets.attributes import CRITICAL_MASS, axis, drive_parameters, flagged, labels, variable
from lsvib.dynamics.attractor import Attractor
from lsvib.figures.basin_sweep.checks import checks
from lsvib.models.drive import RigidDrive
from lsvib.stability.conditions import critical_friction, critical_mass
from lsvib.stability.force_thresholds import global_stability_force

__all__ = ["build", "checks"]

SWEPT = ("axial_force", "support_damping", "mass", "friction_coefficient")
_CLOSE = 1e-6  # relative distance of the two values between which a kind of boundary gives way to another
_ARC = 60  # samples of an arc
_FRACTION = "fraction of the window that steady sliding attracts, exact"
_TURNS = 16  # cells more, for the ends of a boundary and where it turns


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the basins of a few drives, exactly and on grids, and the exact share of a window along four sweeps."""
    drive, window = RigidDrive.of(settings["drive"]), Window(**settings["window"])
    variables, coordinates = {}, {}
    for name in SWEPT:
        values, basins = _swept(drive, name, spans.even(settings[name]))
        coordinates |= axis(f"swept_{name}", values)
        variables |= _along(name, basins, window)
    variables |= _cases(drive, settings["cases"], settings["resolutions"])
    variables |= _readings(drive, settings["masses"], settings["axial_forces"], window)
    variables |= phase_plane.window_edges("window", "edge", window)
    variables |= _critical_values(drive, coordinates["swept_support_damping"][1])
    return xr.Dataset(
        variables,
        coords=coordinates | drive_parameters(drive, printed=("Fig. 8.14", "Sect. 8.6")),
        attrs={
            "title": "The region of attraction of steady sliding and its size",
            "source": "lsvib, exact boundary of the basin; grids by the map of the region of attraction",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.7, Fig. 8.14",
        },
    )


def _critical_values(drive: RigidDrive, dampings: np.ndarray) -> phase_plane.Variables:
    """Values of force, mass and friction up to which the basin is the whole plane; of the force for each damping."""
    stable = ("N", phase_plane.GLOBAL_STABILITY, "$R$")
    mass, friction = (np.nan if x is None else x for x in (critical_mass(drive), critical_friction(drive)))
    forces = [global_stability_force(drive.replace(support_damping=c)) for c in dampings]
    words = "friction coefficient at which the effective inertia of law + vanishes, missing if at none"
    return {
        "swept_global_stability_force": variable("swept_support_damping", forces, *stable),
        "critical_mass": ((), mass, CRITICAL_MASS),
        "critical_friction_of_rigid_drive": variable((), friction, "1", words, r"$\mu_\mathrm{cr}$"),
        "global_stability_force": variable((), global_stability_force(drive), *stable),
    }


def _swept(drive: RigidDrive, name: str, values: np.ndarray) -> tuple[np.ndarray, list[Basin]]:
    """The basins along one parameter; where the kind of boundary changes, two more values close to the change."""

    def at(value: float) -> Basin:
        return basin(drive.replace(**{name: float(value)}))

    found = {float(value): at(value) for value in values}
    for low, high in zip(values[:-1].tolist(), values[1:].tolist(), strict=True):
        first, last = found[low], found[high]
        if first.boundary == last.boundary:
            continue
        while high - low > _CLOSE * max(abs(low), abs(high)):
            middle = 0.5 * (low + high)
            between = at(middle)
            if between.boundary == first.boundary:
                low, first = middle, between
            else:
                high, last = middle, between
        found |= {low: first, high: last}
    ordered = np.array(sorted(found))
    return ordered, [found[value] for value in ordered.tolist()]


def _along(name: str, basins: Sequence[Basin], window: Window) -> phase_plane.Variables:
    """Fraction of the window and kind of boundary along a sweep; along that of the force also the area."""
    dim, fraction = f"swept_{name}", [b.fraction(window) for b in basins]
    variables = {
        f"fraction_{name}": variable(dim, fraction, "1", _FRACTION),
        f"boundary_kind_{name}": flagged(dim, [b.boundary for b in basins], "what bounds the basin", Boundary),
    }
    if name == "axial_force":
        words = "area of the basin, infinite where it has no bound"
        variables["basin_area_axial_force"] = variable(dim, [b.area() for b in basins], "rad2 s-1", words)
    return variables


def _cases(drive: RigidDrive, cases: Sequence[Mapping[str, Any]], resolutions: Sequence[int]) -> phase_plane.Variables:
    """Basins to be drawn: boundary and region as sampled curves, exact fraction of their window, fractions on grids."""
    drives = [drive.replace(**case["drive"]) for case in cases]
    windows = [Window(**case["window"]) for case in cases]
    basins = [basin(d) for d in drives]
    lines = [b.line(w, _ARC) for b, w in zip(basins, windows, strict=True)]
    regions = [sampled(b.flow, b.clipped(w), _ARC) for b, w in zip(basins, windows, strict=True)]
    grid = np.array([_grid_fraction(d, w, resolutions) for d, w in zip(drives, windows, strict=True)])
    bound = [[_cut_cells(line, w, n) / n**2 for n in resolutions] for line, w in zip(lines, windows, strict=True)]
    fraction = [b.fraction(w) for b, w in zip(basins, windows, strict=True)]
    named = tuple(name for name, value in drive if len({value, *(getattr(d, name) for d in drives)}) > 1)
    own = drive_parameters(drives, along=named, printed=("Fig. 8.14", "Sect. 8.6"))
    parameters = {
        f"case_{name}": own[name] for name in own if name in named or name in ("axial_force", "support_damping")
    }
    return {
        **labels("case", drives, named),
        **parameters,
        **phase_plane.lines(drives),
        **_points("boundary", lines, "on the exact boundary"),
        **_points("region", regions, "on the curves around the basin within the window"),
        "resolution": variable("resolution", list(resolutions), "1", "starts along each edge of a grid"),
        **phase_plane.window_edges("case", ("case", "edge"), windows, " of the case"),
        "case_boundary_kind": flagged("case", [b.boundary for b in basins], "what bounds the basin", Boundary),
        "case_fraction": variable(
            "case", fraction, "1", "fraction of the case's window that steady sliding attracts, exact"
        ),
        "grid_fraction": variable(("case", "resolution"), grid, "1", "the same fraction, counted on a grid of starts"),
        "grid_bound": variable(
            ("case", "resolution"), bound, "1", "fraction of the cells of the grid that the boundary cuts at most"
        ),
    }


def _points(name: str, curves: Sequence[np.ndarray], where: str) -> phase_plane.Variables:
    """Sampled curves of each case, (case, point); shorter ones end in NaN, as do their parts."""
    table = np.full((len(curves), max(len(points) for points in curves), 2), np.nan)
    for row, points in zip(table, curves, strict=True):
        row[: len(points)] = points
    return phase_plane.curve(name, ("case", f"{name}_point"), table, where)


def _grid_fraction(drive: RigidDrive, window: Window, resolutions: Sequence[int]) -> list[float]:
    """Fraction of the middles of n × n cells from which the motion settles, for each resolution n, by the mapper."""
    found = mapper(drive)
    fractions = []
    for count in resolutions:
        grid = Grid(
            Axis.checked("u", window.left, window.right, count), Axis.checked("w", window.bottom, window.top, count)
        )
        labels = found.cells(grid, quantities=("label",))["label"]
        fractions.append(float(np.mean(labels == Attractor.STEADY_SLIDING)))
    return fractions


def _cut_cells(line: np.ndarray, window: Window, count: int) -> float:
    """A bound of the number of cells that a boundary cuts: it passes from cell to cell across one edge at a time."""
    steps = np.abs(np.diff(line, axis=0)) / [window.right - window.left, window.top - window.bottom]
    return count * float(np.nansum(steps)) + _TURNS


def _readings(
    drive: RigidDrive, masses: Sequence[float], forces: Sequence[float], window: Window
) -> phase_plane.Variables:
    """Fraction of the window for both readings of the mass and both forces of Fig. 8.14."""
    table = [[basin(drive.replace(mass=m, axial_force=r)).fraction(window) for r in forces] for m in masses]
    return {
        "reading_fraction": variable(("reading_mass", "reading_axial_force"), table, "1", _FRACTION),
        **axis("reading_mass", masses),
        **axis("reading_axial_force", forces),
    }
