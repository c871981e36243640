"""How far the rounding of Table 8.1 explains the distances between printed and computed thresholds."""

import math
from enum import IntEnum
from typing import ClassVar

import numpy as np
import xarray as xr

from lsvib.datasets import newton, printed
from lsvib.datasets.attributes import Variables, drive_parameters, flagged, origin_of, parameter, variable, yes_no
from lsvib.datasets.checks import Check
from lsvib.figures import style
from lsvib.figures.common import about, flag_names
from lsvib.figures.settings import DriveChanges, FigureSettings, Values
from lsvib.models import chapter
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.numbers import bisected
from lsvib.stability import force_thresholds
from lsvib.stability.threshold import solve_threshold

CAPTION = """\
What the rounding of Table 8.1 explains of the distance between printed thresholds and computed ones (in brackets): half
a unit of the last digit of each value, as a part of the threshold, (a) of the values with three digits and (b) of those
with one or two, on top of the threshold's own print. A mark within the bar of (a) is explained; 34.5 N and 46.5 N are
not. See docs/physics.md.
"""

# Of each printed threshold half a unit of its last digit, its name among those that are solved, and for what.
_PRINTED = {
    "critical_mass": (0.005, "kinematic_constraint", "mass"),
    "critical_friction": (0.0005, "kinematic_constraint", "friction_coefficient"),
    "onset_force": (0.5, "onset", "axial_force"),
    "stick_force": (0.05, "stick", "axial_force"),
    "detach_force": (0.05, "detach", "axial_force"),
}
_WORDS = {name: name.replace("_", " ") for name in _PRINTED} | {"critical_friction": "critical friction coefficient"}
_PLACES = ("Sect. 8.5.1", "Fig. 8.15", "Sect. 8.6")  # that state what the drives of the thresholds have
_VARIED = ("mass", "translation_damping")  # in which they differ; the thresholds of R do not depend on it
# Half a unit of the last digit of each value as Table 8.1 prints it: 5.18 mm, 5.57 degree, 3.12e-6, 1, 2e-4, 0.218, 40.
HALF_UNITS = {
    "pitch_radius": 0.005e-3,
    "lead_angle_deg": 0.005,
    "screw_inertia": 0.005e-6,
    "coupling_stiffness": 0.5,
    "support_damping": 0.5e-4,
    "friction_coefficient": 0.0005,
    "input_speed": 0.5,
}
ROUND = ("coupling_stiffness", "support_damping", "input_speed")
"""Values with no digit but the leading one, 1, 2e-4 and 40: they look chosen, and half a unit is up to half of them."""
PrintedThreshold = IntEnum("PrintedThreshold", list(_PRINTED), start=0)
Parameter = IntEnum("Parameter", list(HALF_UNITS), start=0)
_SYMBOLS = {
    "pitch radius": ("$r_m$", style.BLUE),
    "lead angle deg": ("$\\lambda$", style.SKY),
    "screw inertia": ("$I$", style.BLACK),
    "friction coefficient": ("$\\mu$", style.PURPLE),
    "coupling stiffness": ("$k$", style.YELLOW),
    "support damping": ("$c$", style.ORANGE),
    "input speed": ("$\\Omega$", style.WINE),
}


class Settings(FigureSettings):
    unused: ClassVar = ("mass", "translation_damping", "axial_force")

    drive: DriveChanges


def build(settings: Values) -> xr.Dataset:
    """Compute the thresholds, their distance from print, and what half a unit of each parameter changes, relative."""
    base, own = Drive.of(settings["drive"]), {name: dict(chapter.THRESHOLDS[name].drive) for name in _PRINTED}
    screw_mass = own["critical_friction"].pop("screw_mass")
    drives = {name: base.replace(**changes) for name, changes in own.items()}
    asked = drives | {
        "critical_friction": drives["critical_friction"].replace(
            **chapter.PARTS["support"] | {"screw_mass": screw_mass}
        )
    }
    solved = [solve_threshold(drive, *_PRINTED[name][1:]) for name, drive in asked.items()]
    computed = np.array([found.solutions[0].value for found in solved])
    steps = {name: half for name, half in HALF_UNITS.items() if name != "lead_angle_deg"}
    steps["lead_angle"] = math.radians(HALF_UNITS["lead_angle_deg"])
    changes = np.zeros((len(solved), len(HALF_UNITS)))
    for row, found in zip(changes, solved, strict=True):  # ∂f/∂p · h; its own parameter changes nothing
        change = found.solutions[0].change({name: step for name, step in steps.items() if name != found.unknown})
        row[:] = [change.get(name.removesuffix("_deg"), 0.0) for name in HALF_UNITS]
    return xr.Dataset(
        _table(computed, changes) | _matching(drives["stick_force"]),
        coords={
            **drive_parameters(
                list(drives.values()), "threshold", along=_VARIED, printed=_PLACES, no_effect=("axial_force",)
            ),
            "threshold": flagged("threshold", PrintedThreshold, "threshold", PrintedThreshold),
            "parameter": flagged("parameter", Parameter, "parameter of Table 8.1", Parameter),
            **{f"printed_{n}": printed.variable(chapter.THRESHOLDS[n], words) for n, words in _WORDS.items()},
            **{
                f"computed_{n}": variable((), value, chapter.THRESHOLDS[n].unit, f"{n.replace('_', ' ')}, computed")
                for n, value in zip(_PRINTED, computed, strict=True)
            },
            "screw_mass": ((), screw_mass, parameter("screw_mass", origin_of("screw_mass", screw_mass, _PLACES))),
        },
        attrs=about(
            __doc__,
            "thresholds in closed form and by the return map, with exact derivatives",
            "Table 8.1, Sects 8.5.1, 8.6.1, Fig. 8.15",
        ),
    )


def _table(computed: np.ndarray, changes: np.ndarray) -> Variables:
    """Distances from print, half a unit of the last printed digit, and changes, relative to the thresholds."""
    in_print = np.array([chapter.THRESHOLDS[name].value for name in _PRINTED])
    half_units = np.array([half for half, *_ in _PRINTED.values()]) / computed
    half, few = "half a unit of the last printed digit of the threshold, relative", [n in ROUND for n in HALF_UNITS]
    words, change = "change of the threshold by half a unit of the parameter's last printed digit", changes.T / computed
    return {
        "print_residual": variable("threshold", in_print / computed - 1, "1", "printed less computed, relative"),
        "print_half_unit": variable("threshold", half_units, "1", half),
        "relative_change": variable(("threshold", "parameter"), change.T, "1", words),
        "one_digit": yes_no("parameter", few, "printed without a digit but the leading one"),
    }


def _matching(drive: Drive) -> Variables:
    """The damping with which the printed stick force is the computed one, and what else it would change."""
    half, printed_force = HALF_UNITS["support_damping"], chapter.THRESHOLDS["stick_force"].value

    def smaller(damping: float) -> bool:
        return force_thresholds.stick_force(drive.replace(support_damping=damping)) < printed_force

    low, high = drive.support_damping - half, drive.support_damping + half  # within half a unit of the printed one
    damping = bisected(lambda c: smaller(c) == smaller(high), low, high)
    other, unit = drive.replace(support_damping=damping), "N m s rad-1"
    force, plus = force_thresholds.detach_force(other), float(coefficients(other).damping[1])
    words, that = "support damping at which the stick force is the printed one", "with that damping"
    return {
        "matching_support_damping": variable((), damping, unit, words, "$c$"),
        "matching_detach_force": variable((), force, "N", f"detach force {that}", "$R$"),
        "matching_effective_damping_plus": variable((), plus, unit, f"effective damping of law + {that}", "$C_+$"),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check which residuals the rounding explains, and which it does not."""
    residual, precise = np.abs(dataset.print_residual.values), dataset.one_digit.values == 0
    # The most that the values with three digits and the threshold's own print explain.
    allowed = np.abs(dataset.relative_change.values[:, precise]).sum(axis=1) + dataset.print_half_unit.values
    mass, friction, onset, stick, detach = PrintedThreshold
    damping, half = float(dataset.matching_support_damping), HALF_UNITS["support_damping"]
    force, claim = float(dataset.matching_detach_force), chapter.EFFECTIVE_DAMPING[1]
    distance = abs(force - chapter.THRESHOLDS["detach_force"].value)
    plus = float(dataset.matching_effective_damping_plus)
    words = [f"{one.name}: {residual[one]:.2e} against {allowed[one]:.2e}" for one in PrintedThreshold]
    return [
        Check.holds(
            "10.10 kg and 0.285 lie as far from the computed values as the rounding of the table's values with three "
            "digits explains",
            "Table 8.1, Sect. 8.6.1, Fig. 8.15",
            f"{words[mass]}; {words[friction]}",
            (residual <= allowed)[[mass, friction]].all(),
        ),
        Check.holds(
            "20 N lies as far from the computed value as its own two digits explain",
            "Sect. 8.5.1, Fig. 8.6",
            words[onset],
            residual[onset] <= allowed[onset],
        ),
        Check.holds(
            "34.5 N and 46.5 N lie farther from the computed values than the rounding of the values with three digits "
            "and their own explains: they agree to 2 % and 1 % only, as read from an axis",
            "Table 8.1, Sect. 8.5.1, Fig. 8.6",
            f"{words[stick]}; {words[detach]}",
            (residual > allowed)[[stick, detach]].all() and residual[stick] < 0.02 and residual[detach] < 0.01,
        ),
        newton.touching_check(dataset.isel(threshold=detach), 1, dataset.computed_detach_force, "Detach force"),
        Check.holds(
            "One support damping that rounds to the printed one would give both 34.5 N and 46.5 N to their last digit",
            "Table 8.1, Sect. 8.5.1, Fig. 8.6",
            f"c = {damping:.4g} N m s/rad gives 34.5 N and {force:.5g} N",
            abs(damping - float(dataset.support_damping)) <= half and distance <= _PRINTED["detach_force"][0],
        ),
        Check.holds(
            "but not the printed effective damping C₊, so it is not the damping of the chapter",
            "Sect. 8.5.1",
            f"C₊ = {plus:.4g} N m s/rad, printed {claim.value:g}",
            abs(plus / claim.value - 1) > claim.tolerance,
        ),
    ]


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the distance from print of each threshold over stacked bars of what half a unit of each value changes."""
    figure = style.new_figure(style.DOUBLE, 3.4)
    panels = figure.subplots(1, 2, sharey=True)
    names = list(flag_names(dataset.threshold).values())
    parameters = {name: value for value, name in flag_names(dataset.parameter).items()}
    place = np.arange(len(names))[::-1]
    titles = ("(a) rounding of the values with three digits", "(b) of those with one or two")
    edge = {"edgecolor": style.BLACK, "linewidth": 0.5}
    for axes, digits, words in zip(panels, (0, 1), titles, strict=True):
        width = 100 * dataset.print_half_unit.values
        axes.barh(place, width, color="#FFFFFF", hatch="....", label="half a unit of the threshold itself", **edge)
        for name, (symbol, colour) in _SYMBOLS.items():
            column = dataset.sel(parameter=parameters[name])
            if int(column.one_digit) != digits:
                continue
            change = 100 * np.abs(column.relative_change.values)
            axes.barh(place, change, left=width, color=colour, label=f"of {symbol}", **edge)
            width = width + change
        residual = 100 * np.abs(dataset.print_residual.values)
        axes.plot(residual, place, "D", color=style.VERMILION, markersize=5, markeredgecolor="#FFFFFF",
                  markeredgewidth=0.6, label="size of printed less computed", clip_on=False, zorder=3)  # fmt: skip
        axes.set(title=words, xlabel="Part of the threshold [%]", xlim=(0, 1.08 * max(residual.max(), width.max())))
        axes.tick_params(axis="y", length=0)
    panels[0].set_yticks(place, [_words(dataset.isel(threshold=k), name) for k, name in enumerate(names)])
    style.legend(figure, list(panels), 5)
    return figure


def _words(part: xr.Dataset, name: str) -> str:
    """Name of a threshold with its printed value, by half a unit of its last digit, and its computed value."""
    printed, computed = (part[f"{kind}_{name.replace(' ', '_')}"] for kind in ("printed", "computed"))
    unit = style.unit(computed.attrs["units"]).strip("[]")
    decimals = max(0, round(-np.log10(2 * float(part.print_half_unit * computed))))
    return f"{name}\n{float(printed):.{decimals}f} {unit} ({float(computed):.5g})"
