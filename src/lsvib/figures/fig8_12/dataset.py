"""Figure 8.12: amplitude, mean deflection and mean contact force of the sprag–slip cycle against the damping."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import phase_plane, spans
from lsvib.datasets.attributes import axis, drive_parameters, flagged, start_state, variable
from lsvib.datasets.checks import Check
from lsvib.dynamics.attractor import Attractor, SteadyState, steady_state
from lsvib.dynamics.impulses import mean_load
from lsvib.errors import InputError
from lsvib.models.drive import RigidDrive
from lsvib.models.model import RULES
from lsvib.models.rigid import MotionMode, rigid_automaton
from lsvib.numbers import bisected

_QUANTITIES = {
    "amplitude": ("rad", phase_plane.AMPLITUDE, ""),
    "mean_deflection": ("rad", "mean coupling deflection", r"$\langle z \rangle$"),
    "mean_normal_force": ("N", "mean magnitude of the normal force, impulses included", r"$\langle |N| \rangle$"),
    "mean_impulsive_force": ("N", "part of the mean normal force that comes from impulses", ""),
    "mean_axial_contact_force": ("N", "mean axial contact force, impulses included", ""),
    "mean_contact_torque": ("N m", "mean contact torque on the screw, impulses included", ""),
    "mean_coupling_torque": ("N m", "mean coupling torque less the mean damping torque", ""),
}


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the cycle's amplitude and means over the damping, under both rules of resuming after a seizure.

    ``settings``: see ``Settings``. Below ``resting_support_damping`` the screw rests after a seizure under the first
    rule, so that the rules differ; there the values lie closer. Raises ``InputError``.
    """
    drive = RigidDrive.of(settings["drive"])
    start = [settings["start"]["u"], settings["start"]["w"]]
    wanted = spans.even(settings["support_damping"])
    limit = _resting_damping(drive, start, float(wanted.max()))
    damping = np.unique(np.concatenate([wanted, limit * np.linspace(0, 2, 2 * (wanted.size // 8) + 1)]))
    damping = damping[(damping >= wanted.min()) & (damping <= wanted.max())]
    table = {name: np.empty((len(RULES), damping.size)) for name in _QUANTITIES}
    labels = np.empty((len(RULES), damping.size), dtype=np.int8)
    for i, rule in enumerate(RULES):
        for j, c in enumerate(damping):
            damped = drive.replace(support_damping=float(c))
            steady = steady_state(rigid_automaton(damped, resume=rule), start)
            labels[i, j] = steady.label
            for name, value in zip(table, _values(damped, steady), strict=True):
                table[name][i, j] = value
    dims = ("rule", "support_damping")
    return xr.Dataset(
        {name: variable(dims, values, *_QUANTITIES[name]) for name, values in table.items()}
        | {"attractor": flagged(dims, labels, phase_plane.ATTRACTOR, Attractor)},
        coords={
            **axis("support_damping", damping),
            **phase_plane.rule_coordinate(),
            "resting_support_damping": variable(
                (), limit, "N m s rad-1", "damping below which the screw rests after a seizure", "$c$"
            ),
            **drive_parameters(drive, axes=("support_damping",), printed=("Sect. 8.6", "Sect. 8.6.1")),
            **start_state(settings["start"], "of the motions whose cycles are found"),
        },
        attrs={
            "title": "Figure 8.12: effect of the support damping on the steady vibration",
            "source": "lsvib, exact means over the cycle of the exact event-driven motion",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.6.1, Fig. 8.12",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the trends over the damping, and both balances of momentum over a cycle."""
    return [*_trend_checks(dataset), _rule_check(dataset), *_balance_checks(dataset)]


def _trend_checks(dataset: xr.Dataset) -> list[Check]:
    """Check that every drive vibrates, and how amplitude, mean deflection and mean normal force change."""
    limit = float(dataset.resting_support_damping)
    amplitude, force = dataset.amplitude.values, dataset.mean_normal_force.values
    deflection = np.abs(dataset.mean_deflection.values)
    slips, damped = dataset.support_damping.values >= limit, dataset.support_damping.values > 0
    sprags = dataset.attractor.values == Attractor.SPRAG_SLIP_CYCLE
    least = dataset.support_damping.values[damped][0]
    lowest = float(dataset.support_damping.values[np.argmin(force[0])])
    return [
        Check.everywhere(
            "The motion is a sprag-slip cycle for every damping, under either rule of resuming",
            "Sect. 8.6.1, Fig. 8.12",
            sprags,
        ),
        Check.holds(
            "The amplitude falls as the damping grows, over the whole range and under either rule",
            "Sect. 8.6.1, Figs 8.11, 8.12",
            f"from {amplitude[0, 0]:.5g} to {amplitude[0, -1]:.5g} rad",
            bool((np.diff(amplitude) < 0).all()),
        ),
        Check.holds(
            "The mean deflection of the coupling grows with the damping, with or without rest after a seizure",
            "Sect. 8.6.1, Fig. 8.12",
            f"|<z>| from {deflection[0, 0]:.5g} to {deflection[0, -1]:.5g} rad; by the rule at once, idle at "
            f"c = 0, from {deflection[1, damped][0]:.5g} rad at c = {least:.2g} N m s/rad",
            bool((np.diff(deflection[0]) > 0).all() and (np.diff(deflection[1, damped]) > 0).all()),
        ),
        Check.holds(
            "The mean of |N|, impulses included, grows with the damping wherever motion resumes at once",
            "Sect. 8.6.1, Fig. 8.12",
            f"from {force[0, slips][0]:.5g} N at c = {limit:.3g} N m s/rad to {force[0, -1]:.5g} N; below, "
            f"where the screw rests, it falls from {force[0, 0]:.5g} to {force[0].min():.5g} N at c = {lowest:.2g}",
            bool((np.diff(force[:, slips]) > 0).all() and slips.sum() > 1),
        ),
    ]


def _rule_check(dataset: xr.Dataset) -> Check:
    """Check that the rule of resuming makes no difference where the screw does not rest."""
    limit, amplitude = float(dataset.resting_support_damping), dataset.amplitude.values
    slips = dataset.support_damping.values >= limit
    gap = float(np.max(np.abs(amplitude[0] / amplitude[1] - 1)[slips]))
    return Check.holds(
        "Without rest both rules of resuming give the same cycle, to 1e-12",
        "Sect. 8.6, rule of resuming",
        f"largest relative difference of the amplitudes {gap:.1e} for c >= {limit:.4g} N m s/rad",
        gap < 1e-12,
    )


def _balance_checks(dataset: xr.Dataset) -> list[Check]:
    """Check the balances of axial and angular momentum over a cycle, at the damping where they are worst."""
    return [
        Check.exact(
            "Mean axial contact force over R, impulses included (worst damping)",
            "axial balance over a cycle",
            1.0,
            _worst(dataset.mean_axial_contact_force.values / float(dataset.axial_force)),
        ),
        Check.exact(
            "Mean contact torque over mean coupling torque less damping, impulses included (worst damping)",
            "balance of the screw's angular momentum over a cycle",
            1.0,
            _worst(dataset.mean_contact_torque.values / dataset.mean_coupling_torque.values),
        ),
    ]


def _values(drive: RigidDrive, steady: SteadyState) -> list[float]:
    """Values of the quantities in their order; NaN where there is no cycle."""
    if steady.orbit is None:
        return [steady.amplitude] + [np.nan] * (len(_QUANTITIES) - 1)
    load = mean_load(drive, steady.orbit)
    left = -drive.coupling_stiffness * load.deflection - drive.support_damping * drive.input_speed
    return [steady.amplitude, load.deflection, load.normal, load.impulsive, load.axial, load.torque, left]


def _worst(ratios: np.ndarray) -> float:
    """The ratio farthest from one; NaN if any is."""
    ratios = ratios.ravel()
    return float(ratios[np.argmax(np.abs(ratios - 1))]) if np.isfinite(ratios).all() else np.nan


def _resting_damping(drive: RigidDrive, start: list[float], largest: float) -> float:
    """Smallest damping [N m s/rad] up to ``largest`` whose cycle has no rest, by bisection to the last bit."""

    def rests(damping: float) -> bool:
        automaton = rigid_automaton(drive.replace(support_damping=damping))
        orbit = steady_state(automaton, start).orbit
        return orbit is None or bool((automaton.codes[orbit.arcs()[0]] == MotionMode.REST).any())

    if rests(largest):
        raise InputError(f"support_damping: the screw still rests at the stop, {largest:g}; give a larger one.")
    return bisected(lambda damping: not rests(damping), 0.0, largest) if rests(0.0) else 0.0
