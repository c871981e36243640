"""What becomes of the chapter's thresholds and cycles when friction rises towards slow sliding and rest."""

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.datasets import phase_plane, spans
from lsvib.datasets.analysis import analyse, least_onset_force
from lsvib.datasets.attributes import ASSUMED, drive_parameters, named_index, parameter, variable
from lsvib.datasets.checks import Check
from lsvib.figures import settings as of
from lsvib.figures import style
from lsvib.figures.common import BALANCE, about, balance_check, named, printed
from lsvib.models import chapter
from lsvib.models.drive import Drive
from lsvib.numbers import bisected
from lsvib.stability.threshold import solve_threshold

CAPTION = """\
Friction that rises by a part of its kinetic value towards slow sliding, over the Stribeck speed: (a) critical mass and
critical friction with the coefficient of slow sliding, where a drive comes to the Painlevé region first, and critical
mass with that of steady sliding; (b) the three forces of Fig. 8.6. Static friction above the kinetic one, without a
rise: (c) amplitude and (d) period of the stick–slip cycle of a slow drive and of the sprag–slip cycle of Fig. 8.9.
"""

_FORCES = ("onset_force", "stick_force", "detach_force")
_PRINTED = ("critical_mass", *_FORCES)
CYCLES = ("stick_slip", "sprag_slip")


class Settings(of.DriveFigure):
    unused = ("axial_force",)
    flows = ("taylor",)

    rise: of.Span = Field(description="Rise of friction over its kinetic value [1].")
    static: of.PositiveSpan = Field(description="Static over kinetic friction [1].")
    heavy_mass: of.parameter("mass")
    stick_slip: of.DriveChanges
    sprag_slip: of.DriveChanges


def _risen(drive: Drive, share: float) -> Drive:
    return drive.replace(stribeck_rise=share * drive.friction_coefficient)


def _slow(drive: Drive, share: float) -> Drive:
    """The drive with the constant coefficient that it has in slow sliding."""
    return Drive.of({**dict(drive), "stribeck_speed": 0}).replace(
        friction_coefficient=(1 + share) * drive.friction_coefficient
    )


def analysis(settings: of.Values) -> xr.Dataset:
    """Analyse the drive with each rise: its critical mass with the friction of steady sliding."""
    drive = Drive.of(settings["drive"])
    drives = [_risen(drive, share) for share in spans.even(settings["rise"]).tolist()]
    return analyse(drives, [("kinematic_constraint", "mass")], along=("stribeck_rise",))


def build(settings: of.Values, analysis: xr.Dataset) -> xr.Dataset:
    """Compute thresholds over the rise, and both cycles, from far away, over the static friction."""
    from lsvib.dynamics.energy import balance

    drive, rise = Drive.of(settings["drive"]), spans.even(settings["rise"])
    heavy = drive.replace(mass=settings["heavy_mass"])
    slow = [solve_threshold(_slow(drive, share), "kinematic_constraint", "mass").value for share in rise.tolist()]
    least = solve_threshold(_slow(heavy, 0.0), "kinematic_constraint", "friction_coefficient").value
    forces = zip(_FORCES, np.transpose([_forces(_risen(drive, share)) for share in rise.tolist()]), strict=True)
    steady, critical = analysis.kinematic_constraint_mass.values, "kinetic friction that is critical in slow sliding"
    static, rows = spans.even(settings["static"]), []
    for name in CYCLES:
        own = Drive.of(settings[name])
        for held in (own.replace(static_friction_coefficient=x * own.friction_coefficient) for x in static.tolist()):
            far = phase_plane.reached(held, {"u": 0.06, "w": -held.input_speed})
            rows.append((far.label, far.amplitude, far.period, balance(held, far.orbit)))
    label, amplitude, period, works = np.reshape(np.transpose(rows), (4, len(CYCLES), static.size))
    other = ("cycle", "static_share")
    return xr.Dataset(
        {
            "slow_critical_mass": variable("rise_share", slow, "kg", "critical mass in slow sliding", "$m$"),
            "steady_critical_mass": variable("rise_share", steady, "kg", "critical mass in steady sliding", "$m$"),
            "slow_critical_friction": variable("rise_share", least / (1 + rise), "1", critical, r"$\mu$"),
            **{name: variable("rise_share", x, "N", name.replace("_", " "), "$R$") for name, x in forces},
            "attractor": phase_plane.attractors(other, label),
            "amplitude": variable(other, amplitude, "rad", phase_plane.AMPLITUDE, r"$\hat u$"),
            "energy_balance": variable(other, works, *BALANCE),
            "period": variable(other, period, "s", phase_plane.PERIOD, "$T$"),
        },
        coords={
            **drive_parameters(drive, printed=("Sect. 8.5.1",), no_effect=("axial_force",)),
            "rise_share": variable("rise_share", rise, "1", "rise of friction over its kinetic value"),
            "static_share": variable("static_share", static, "1", "static over kinetic friction"),
            "cycle": named_index("cycle", "which cycle", CYCLES),
            "case_mass": ((), settings["heavy_mass"], parameter("case_mass", ASSUMED)),
            **{f"printed_{n}": printed(chapter.THRESHOLDS[n], n.replace("_", " ")) for n in _PRINTED},
        },
        attrs=about(__doc__, "closed form, motions and their return maps", "Figs 8.6, 8.8, 8.9"),
    )


def _forces(drive: Drive) -> tuple[float, float, float]:
    """Onset force [N] of a drive, and by bisection, from its motions, stick and detach force."""
    from lsvib.dynamics.sweep import REVERSES, STICKS, ending_of
    from lsvib.models.rigid import rigid_automaton

    def happens(force: float) -> int:
        """What happens on the cycle at a force."""
        here = drive.replace(axial_force=force)
        return int(ending_of(here, rigid_automaton(here), np.array([0.05, 0.0])).happens)

    onset = least_onset_force(drive)
    stick = bisected(lambda force: bool(happens(force) & STICKS), 1.2 * onset, 4 * onset, 1e-4)
    return onset, stick, bisected(lambda force: not happens(force) & REVERSES, stick, 4 * onset, 1e-4)


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the values without a rise against the chapter, and what the rise and static friction do."""
    first, exact = dataset.isel(rise_share=0), float(dataset.slow_critical_mass[0])
    limit = exact * (1 - 0.5 * float(dataset.rise_share[-1]))
    slips, sprags = (
        named(dataset.attractor, f"{name} cycle")[k] for k, name in enumerate(("stick slip", "sprag slip"))
    )
    size, period = dataset.amplitude.values, dataset.period.values[0]
    slow, steady = dataset.slow_critical_mass.values, dataset.steady_critical_mass.values
    onset, stick = dataset.onset_force.values, dataset.stick_force.values
    falls = (np.diff(slow) < 0).all() and slow[-1] < limit + 0.5 * exact and np.ptp(steady) < 1e-3 * exact
    lowers = np.ptp(onset) < 1e-2 * onset[0] and (np.diff(stick) < 0).all()
    rests = not slips[0] and slips[1:].all() and (np.diff([size[0][1:], period[1:]]) > 0).all()
    grows = sprags.all() and (np.diff(size[1]) >= -1e-12).all() and size[1][-1] > size[1][0]
    return [
        Check.of(chapter.THRESHOLDS["critical_mass"], exact, note="without a rise"),
        *(Check.of(chapter.THRESHOLDS[name], first[name], note="without a rise") for name in _FORCES),
        Check.that("stribeck_rise.critical_mass", falls, slow=slow, steady=steady),
        Check.that("stribeck_rise.forces", lowers, stick=stick),
        Check.that("stribeck_rise.slow_drive", rests, amplitude=size[0], period=period[slips]),
        balance_check("each cycle", dataset),
        Check.that("stribeck_rise.sprag_slip", grows, amplitude=size[1]),
    ]


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw critical mass and friction and the three forces over the rise, and both cycles over the static friction."""
    figure = style.new_figure(style.DOUBLE, 4.8)
    (critical, force), (amplitude, period) = figure.subplots(2, 2)
    percent, dashed = 100 * dataset.rise_share, (0, (4, 2))
    over_rise = {"x": "Rise of friction [%]", "xlim": (0, percent[-1])}
    critical.plot(percent, dataset.slow_critical_mass, color=style.BLUE, label="critical mass, slow sliding")
    critical.plot(percent, dataset.steady_critical_mass, color=style.SKY, linestyle=dashed,
                  label="critical mass, steady sliding")  # fmt: skip
    style.frame(critical, "(a) Painlevé region", y="Critical mass [kg]", **over_rise)
    other = critical.twinx()
    other.plot(percent, dataset.slow_critical_friction, color=style.VERMILION, linestyle=":", label="critical friction")
    other.set(ylabel=f"Critical friction at {float(dataset.case_mass):g} kg")
    looks = ((style.BLACK, "-"), (style.BLUE, dashed), (style.VERMILION, ":"))
    for name, (colour, dashes) in zip(_FORCES, looks, strict=True):
        force.plot(percent, dataset[name], color=colour, linestyle=dashes, label=name.replace("_", " "))
    style.frame(force, "(b) forces of Fig. 8.6", y="Axial force $R$ [N]", **over_rise)
    looks = {"stick–slip, constant kinetic friction": (style.BLUE, "-"),
             "sprag–slip of Fig. 8.9": (style.VERMILION, dashed)}  # fmt: skip
    for axes, name, letter in ((amplitude, "amplitude", "c"), (period, "period", "d")):
        for row, (words, (colour, dashes)) in zip(dataset[name], looks.items(), strict=True):
            axes.plot(dataset.static_share, row, color=colour, linestyle=dashes, marker=".", markersize=3, label=words)
        label = style.label(dataset[name], name)
        style.frame(axes, f"({letter}) {name}", "Static over kinetic friction", label, ylim=(0, None))
    return style.legend(figure, [critical, other, force, amplitude], 4)
