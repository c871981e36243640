"""Figure 8.9: trajectories (a) below and (b) above the critical mass, and the effect of the axial force on (b)."""

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import phase_plane, spans
from lsvib.answers.analysis import analyse, value
from lsvib.answers.attributes import CRITICAL_MASS, named, variable, varied
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, each, every, near
from lsvib.chapter.common import about, spread
from lsvib.chapter.settings import DriveChanges, PhasePlane, PositiveSpan, Values, several
from lsvib.drives.drive import Drive
from lsvib.pictures import drawing, style

CAPTION = """\
Trajectories of the rigid drive (a) below and (b) above the critical mass; triangles on the lines point forward in time.
Below it, the motion decays to steady sliding; above it, the screw alternately seizes (sprag) and slips for ever. A
start beyond the line N = 0 of (b), where there is no solution, seizes at once.
"""

_SWEEP = "of the last case with another axial force, from the first start"

_PRINTED = ("Sect. 8.6", "Sect. 8.6.1")


class Settings(PhasePlane):
    unused = ("mass",)

    cases: list[DriveChanges] = several(2, 2, "Changes to `drive`, one a panel, below the critical mass first.")
    axial_force: PositiveSpan = Field(description="R [N] over which a check follows the cycle.")


def _drives(settings: Values) -> list[Drive]:
    return [Drive.of(settings["drive"]).replace(**changes) for changes in settings["cases"]]


def analysis(settings: Values) -> xr.Dataset:
    """Analyse both drives: on which side of the critical mass they are."""
    return analyse(_drives(settings), [("kinematic_constraint", "mass")], ("mass",), _PRINTED)


def build(settings: Values, analysis: xr.Dataset) -> xr.Dataset:
    """Compute both phase planes, the critical mass and the sensitivity of case (b) to R, which the text leaves out."""
    from lsvib.drives.many import ManyDrives
    from lsvib.dynamics.impulses import seizure_impulse
    from lsvib.dynamics.sweep import all_endings

    drives, critical = _drives(settings), value(analysis.kinematic_constraint_mass)
    forces = np.unique([*spans.even(settings["axial_force"]), drives[-1].axial_force])
    planes = phase_plane.portraits(settings, drives, ("mass",), _PRINTED)
    planes = planes.assign_coords(varied(swept_axial_force=forces) | {"critical_mass": ((), critical, CRITICAL_MASS)})
    swept = all_endings(ManyDrives({**dict(drives[-1]), "axial_force": forces}), settings["starts"][0])
    speed, dim = swept.peak_normal_impulse / seizure_impulse(drives[-1], 1.0), "swept_axial_force"
    speed[speed == 0], words = np.nan, "screw speed before a seizure"
    return planes.assign(
        {
            "swept_attractor": phase_plane.attractors(dim, swept.attractor, comment=_SWEEP),
            "swept_amplitude": variable(dim, swept.amplitude, "rad", phase_plane.AMPLITUDE, comment=_SWEEP),
            "impact_speed": variable(dim, speed, "rad s-1", words, r"$\dot\theta$", comment=_SWEEP),
        }
    ).assign_attrs(about(__doc__, "exact event-driven motion and its return map", "Sect. 8.6.1, Fig. 8.9"))


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the signs of Γ₊, where the motions end, and that the choice of R does not decide it."""
    gamma, mass, critical = dataset.effective_inertia_plus.values, dataset.mass.values, float(dataset.critical_mass)
    sprags, amplitude = named(dataset.attractor, "sprag slip cycle")[1], dataset.amplitude.values[1].ravel()
    forces, swept = dataset.swept_axial_force, dataset.swept_amplitude
    speed = dataset.impact_speed.values / float(-dataset.stop_velocity[1])
    own, seized = forces.values == float(dataset.axial_force), np.nan
    if "cycle_w" in dataset:
        seized = np.where(np.diff(dataset.cycle_time[1]) == 0, -np.diff(dataset.cycle_w[1]), 0.0).max()
    return [
        *newton.portrait_checks(dataset, "Fig. 8.9"),
        Check.that("fig8_09.fold", light=each(mass[0], "<", critical), heavy=each(mass[1], ">", critical),
                   inertias=every(np.sign(gamma) == [1, -1]),
                   closed_form=near(dataset.critical_mass, printed_laws.critical_mass(dataset), 1e-12),
                   gamma=gamma, mass=mass, critical=critical),
        Check.that("fig8_09.decays", motions=every(named(dataset.attractor, "steady sliding")[0])),
        *printed_laws.steady_checks(dataset.isel(case=0)),  # c_x = 0
        printed_laws.stationary_check(dataset.isel(case=0)),
        Check.that("fig8_09.sprag_slip", motions=every(sprags), spread=each(spread(amplitude), "<", 1e-12),
                   amplitude=amplitude),
        Check.that("fig8_09.any_force", cycles=every(named(dataset.swept_attractor, "sprag slip cycle")),
                   swing=each(np.ptp(speed) / (speed.max() + speed.min()), "<", 0.02),
                   amplitude_here=near(swept[own], amplitude[0], 1e-9),
                   speed_here=near(dataset.impact_speed[own], seized, 1e-9),
                   forces=forces, speed=speed, swept=swept),
    ]  # fmt: skip


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw (a) and (b) as phase planes."""
    figure = style.new_figure(style.DOUBLE, 3.7)
    planes = figure.subplots(1, 2)
    for index, axes in enumerate(planes):
        case = dataset.isel(case=index)
        relation = "<" if float(case.mass) < float(dataset.critical_mass) else ">"
        drawing.phase_plane(axes, case)
        axes.set_xlim(right=axes.get_xlim()[1] + 0.3 * np.ptp(axes.get_xlim()))  # room for words beyond the line
        drawing.draw_lines(axes, case)
        title = f"({'ab'[index]}) $m$ = {style.number(case.mass)} kg ${relation} m_\\mathrm{{cr}}$"
        drawing.label_axes(axes, dataset, title)
        axes.locator_params(axis="x", nbins=3)
    return drawing.guide(style.legend(figure, planes, 4), planes, [dataset.isel(case=k) for k in range(2)])
