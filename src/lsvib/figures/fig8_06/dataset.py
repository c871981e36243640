"""Figure 8.6: amplitude against the axial force under negative damping, with three phase portraits."""

from collections.abc import Mapping
from enum import IntEnum
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import phase_plane, printed, spans
from lsvib.datasets.attributes import axis, drive_parameters, flagged, labels, start_state, variable
from lsvib.datasets.checks import Check
from lsvib.dynamics.attractor import Attractor, SteadyState, steady_state
from lsvib.figures.common import mass_readings
from lsvib.models import chapter
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients
from lsvib.models.rigid import EventKind, rigid_automaton
from lsvib.stability import force_thresholds

_ASIDE = 1e-9  # relative distance from a threshold at which the regime is also computed, on either side
_FORCES = ("onset_force", "stick_force", "detach_force")


class Regime(IntEnum):
    """Kind of the steady state."""

    STEADY_SLIDING = 0
    SLIP_CYCLE = 1
    STICK_SLIP_WITH_CONTACT_REVERSAL = 2
    STICK_SLIP_IN_CONTACT = 3
    OTHER = 4


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the amplitude curve, its thresholds, the inset portraits, and the coefficients for both masses."""
    drive = RigidDrive.of(settings["drive"])
    values = {name: getattr(force_thresholds, name)(drive) for name in _FORCES}
    beside = [value * (1 + sign * _ASIDE) for value in values.values() for sign in (-1, 1)]
    forces = np.unique(np.concatenate([spans.even(settings["axial_force"]), list(values.values()), beside]))
    start, tangent = np.array([settings["start"]["u"], settings["start"]["w"]]), float(drive.exact().tan_lead)
    drives = [drive.replace(axial_force=float(force)) for force in forces]
    steady = [steady_state(rigid_automaton(d), start) for d in drives]
    insets = [drive.replace(axial_force=float(force)) for force in settings["insets"]]
    return xr.Dataset(
        _curve(drives, steady)
        | mass_readings.variables([drive.replace(mass=float(m)) for m in settings["mass_readings"]])
        | phase_plane.portraits(insets, settings["starts"], settings["duration"], settings["samples"]),
        coords={
            **axis("swept_axial_force", forces),
            **axis("reading_mass", settings["mass_readings"]),
            **drive_parameters(insets, along=("axial_force",), printed=("Sect. 8.5.1", "Fig. 8.6")),
            **start_state(settings["start"], "of the motions whose steady vibration swept_amplitude describes"),
            "lead_tangent": variable((), tangent, "1", "tangent of the lead angle", r"$\tan\lambda$"),
            **labels("case", insets, ("axial_force",)),
            **phase_plane.rule_coordinate(),
            **{n: variable((), value, "N", n.replace("_", " "), "$R$") for n, value in values.items()},
            **{f"printed_{n}": printed.variable(chapter.THRESHOLDS[n], n.replace("_", " ")) for n in _FORCES},
        },
        attrs={
            "title": "Figure 8.6: amplitude of the steady vibration against the axial force under negative damping",
            "source": "lsvib, exact event-driven motion and its return map",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.5.1, Fig. 8.6",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the thresholds, the shape of the curve, where its regime changes, the insets and the coefficients."""
    return [
        *_self_locking_checks(dataset),
        *_threshold_checks(dataset),
        *_curve_checks(dataset),
        *_inset_checks(dataset),
        *mass_readings.checks(dataset),
    ]


def _curve(drives: list[RigidDrive], steady: list[SteadyState]) -> phase_plane.Variables:
    slowest = [s.extremes(np.array([0, 1.0, 0]))[0] for s in steady]
    net, words = [float(coefficients(d).net_force) for d in drives], "axial force less the drag of the translation"
    return {
        "swept_amplitude": variable("swept_axial_force", [s.amplitude for s in steady], "rad", phase_plane.AMPLITUDE),
        "smallest_velocity": variable(
            "swept_axial_force", slowest, "rad s-1", "smallest rate of the deviation", r"$\dot u$"
        ),
        "regime": flagged("swept_axial_force", [_regime(s) for s in steady], "kind of motion", Regime),
        "net_force": variable("swept_axial_force", net, "N", words, r"$\tilde R$"),
    }


def _regime(steady: SteadyState) -> Regime:
    reverses = steady.orbit is not None and bool((steady.orbit.kind == EventKind.CONTACT_REVERSAL).any())
    kinds = {
        (Attractor.STEADY_SLIDING, False): Regime.STEADY_SLIDING,
        (Attractor.OTHER_CYCLE, True): Regime.SLIP_CYCLE,
        (Attractor.STICK_SLIP_CYCLE, True): Regime.STICK_SLIP_WITH_CONTACT_REVERSAL,
        (Attractor.STICK_SLIP_CYCLE, False): Regime.STICK_SLIP_IN_CONTACT,
    }
    return kinds.get((steady.label, reverses), Regime.OTHER)


def _self_locking_checks(dataset: xr.Dataset) -> list[Check]:
    friction, tangent = float(dataset.friction_coefficient), float(dataset.lead_tangent)
    return [
        printed.check("Tangent of the lead angle", chapter.TAN_LEAD, tangent),
        Check.holds(
            "The thread is self-locking, μ > tan λ",
            "Sect. 8.5.1",
            f"μ = {friction:g}, tan λ = {tangent:.6g}",
            friction > tangent,
        ),
    ]


def _threshold_checks(dataset: xr.Dataset) -> list[Check]:
    words = {
        "onset_force": "Axial force at which vibration sets in",
        "stick_force": "Axial force at which the cycle first touches rest",
        "detach_force": "Axial force beyond which the cycle no longer reaches N = 0",
    }
    return [printed.check(words[name], chapter.THRESHOLDS[name], dataset[name]) for name in _FORCES]


def _curve_checks(dataset: xr.Dataset) -> list[Check]:
    onset, stick, detach = (float(dataset[name]) for name in _FORCES)
    stops = dataset.smallest_velocity.values <= dataset.stop_velocity.values[0]
    force, amplitude, regime = (dataset[name].values for name in ("swept_axial_force", "swept_amplitude", "regime"))
    below = amplitude[force < onset]
    slip, last = (force > onset) & (force < stick), force > detach
    slope = amplitude[slip] / dataset.net_force.values[slip]
    bend, spread = _spread(slope), _spread(amplitude[last])
    # At a threshold itself both neighbours' names are right: the cycle touches there.
    expected = np.select([force < onset, force < stick, force < detach], [0, 1, 2], 3)
    judged = ~np.isin(force, [onset, stick, detach])
    wrong = int(np.sum(judged & (regime != expected)))
    return [
        Check.holds(
            "Below the onset force the amplitude is zero",
            "Sect. 8.5.1, Fig. 8.6",
            f"largest amplitude {below.max(initial=0.0):.1e} rad at {below.size} forces",
            bool(below.size) and bool((below == 0).all()),
        ),
        Check.holds(
            "From onset to stick the amplitude grows along a straight line through the onset, to 1e-9 of its slope",
            "Sect. 8.5.1, Fig. 8.6",
            f"slope from {slope.min(initial=np.inf):.6g} rad/N, relative spread {bend:.1e} over {slope.size} forces",
            bool((slope > 0).all()) and bend < 1e-9,
        ),
        Check.holds(
            "Beyond the detach force the amplitude is constant, to 1e-12",
            "Sect. 8.5.1, Fig. 8.6",
            f"from {amplitude[last].min(initial=np.inf):.9f} rad, relative spread {spread:.1e} over "
            f"{int(last.sum())} forces",
            bool((amplitude[last] > 0).all()) and spread < 1e-12,
        ),
        Check.without_exception(
            "The steady state changes kind at the three thresholds and nowhere else, also 1e-9 R beside them",
            "Sect. 8.5.1, Fig. 8.6",
            wrong,
            judged.sum(),
            "forces",
        ),
        Check.holds(
            "Only from the stick force on does the cycle reach the line of rest",
            "Sect. 8.5.1, Fig. 8.6",
            f"smallest rate {dataset.smallest_velocity.values.min():.9g} rad/s",
            bool((stops == (force > stick))[judged].all()),
        ),
    ]


def _spread(values: np.ndarray) -> float:
    """Range over mean of values (n) [1]; nan, which no check passes, of none."""
    return float(np.ptp(values) / values.mean()) if values.size else np.nan


def _inset_checks(dataset: xr.Dataset) -> list[Check]:
    expected = (
        (Attractor.STEADY_SLIDING, "the origin is stable"),
        (Attractor.OTHER_CYCLE, "a pure-slip limit cycle attracts"),
        (Attractor.STICK_SLIP_CYCLE, "a stick-slip cycle attracts"),
    )
    limits = [float(dataset[name]) for name in ("onset_force", "stick_force")]
    result = []
    for index, force in enumerate(dataset.axial_force.values):
        kind, words = expected[np.searchsorted(limits, force)]
        found = dataset.attractor.values[index].ravel()
        names = ", ".join(sorted({Attractor(f).name.lower() for f in found}))
        result.append(
            Check.holds(
                f"At R = {force:g} N {words}",
                "Sect. 8.5.1, Fig. 8.6, inset",
                f"{names} from {dataset.sizes['start']} starts",
                bool((found == kind).all()),
            )
        )
    return result
