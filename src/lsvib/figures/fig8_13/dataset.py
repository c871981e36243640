"""Figure 8.13: with softer contacts the motion is smoother, and the coupling deflection turns positive in sprag."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import phase_plane, spans
from lsvib.datasets.attributes import axis, drive_parameters, flagged, labels, start_state, variable
from lsvib.datasets.checks import Check
from lsvib.dynamics.attractor import Attractor, SteadyState, orbit_extremes, steady_state
from lsvib.errors import InputError
from lsvib.figures.common.compliant_cycles import (
    CRITICAL_MASS_WITH_CONTACT,
    compliant_attractors,
    compliant_cycle,
    cycle_curves,
)
from lsvib.models.drive import ThreadsDrive
from lsvib.models.mechanics import coefficients
from lsvib.models.rigid import rigid_automaton
from lsvib.stability.conditions import critical_mass_of_contact

_CONTACT = ("contact_stiffness", "contact_damping")
_TURNS = 1e-10  # rad: deflection that counts as zero at the boundary
_TRIES = 40  # of regula falsi; as many halvings would narrow an interval of the grid to 1e-12 of it
_NUMBERS = {
    "attractor": ("1", phase_plane.ATTRACTOR),
    "largest_deflection": ("rad", "largest coupling deflection on the cycle", "$z$"),
    "sprag_deflection": ("rad", "largest coupling deflection during sprag", "$z$"),
    "largest_acceleration": ("rad s-2", "largest angular acceleration on the cycle", r"$|\ddot\theta|$"),
    "period": ("s", phase_plane.PERIOD, "$T$"),
    "period_residual": ("1", "relative change of the section state over a period"),
}
_ON_THE_GRID = ("attractor", "largest_deflection", "largest_acceleration")


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the cycles of a few contacts, and over a grid of contacts where the deflection turns positive."""
    drive, start = ThreadsDrive.of(settings["drive"]), settings["start"]
    stiffness, damping = (spans.logarithmic(settings[key]) for key in _CONTACT)
    contacts = [drive.replace(**contact) for contact in settings["contacts"]]
    cycles = [compliant_cycle(contact, start)[1] for contact in contacts]
    rigid = steady_state(rigid_automaton(drive), [start["u"], start["w"]])
    steady = float(coefficients(drive).deflection)
    single, critical = [_numbers(steady) for steady in cycles], [critical_mass_of_contact(c) for c in contacts]
    return xr.Dataset(
        cycle_curves(("contact",), cycles, settings["samples"])
        | cycle_curves((), [rigid], settings["samples"], "rigid_cycle")
        | {name: _table(("contact",), name, single) for name in _NUMBERS}
        | _grid(drive, start, stiffness, damping),
        coords={
            **labels("contact", contacts, _CONTACT),
            **drive_parameters(contacts, "contact", along=_CONTACT, printed=("Sect. 8.6", "Sect. 8.6.1")),
            **start_state(start, "with a seated contact: of the motions whose cycles are found"),
            "critical_mass_with_contact": variable("contact", critical, *CRITICAL_MASS_WITH_CONTACT),
            **axis("grid_contact_stiffness", stiffness),
            **axis("grid_contact_damping", damping),
            "steady_deflection": variable((), steady, "rad", "coupling deflection in steady sliding", "$z_0$"),
        },
        attrs={
            "title": "Figure 8.13: effect of the contact parameters",
            "source": "lsvib, exact event-driven motion with four states",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.6.1, Fig. 8.13",
        },
    )


def _grid(
    drive: ThreadsDrive, start: Mapping[str, float], stiffness: np.ndarray, damping: np.ndarray
) -> phase_plane.Variables:
    """Numbers of the cycles over a grid of contacts, and the damping at which the largest deflection turns positive."""

    def contact(k: float, c: float) -> ThreadsDrive:
        return drive.replace(contact_stiffness=k, contact_damping=c)

    found = compliant_attractors([contact(k, c) for k in stiffness for c in damping], start)
    rows = range(0, len(found), damping.size)
    grid = [[_numbers(steady) for steady in found[row : row + damping.size]] for row in rows]
    limits = [
        _boundary(lambda c, k=k: _numbers(compliant_cycle(contact(k, c), start)[1])["largest_deflection"], damping, row)
        for k, row in zip(stiffness, grid, strict=True)
    ]
    dims = ("grid_contact_stiffness", "grid_contact_damping")
    words = "contact damping below which the deflection turns positive"
    return {
        **{f"grid_{name}": _table(dims, name, grid) for name in _ON_THE_GRID},
        "boundary_contact_damping": variable(dims[0], [limit[0] for limit in limits], "N s m-1", words, "$c_c$"),
        "boundary_deflection": variable(
            dims[0], [limit[1] for limit in limits], "rad", "largest coupling deflection at that damping", "$z$"
        ),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that softer contacts give smoother cycles, and where the deflection turns positive."""
    deflection, sprag = dataset.largest_deflection.values, dataset.sprag_deflection.values
    fastest = dataset.largest_acceleration.values
    critical = dataset.critical_mass_with_contact.values
    times = ", ".join(f"{1e6 * float(dataset.input_speed) / x:.3g}" for x in fastest)
    labels, residual = dataset.attractor.values, float(dataset.period_residual.max())
    limit, edge = dataset.boundary_contact_damping.values, np.abs(dataset.boundary_deflection.values)
    above = dataset.grid_contact_damping.values > limit[:, None]
    grid, cycles = dataset.grid_largest_deflection.values, dataset.grid_attractor.values == Attractor.SPRAG_SLIP_CYCLE
    softest, stiffest = dataset.grid_contact_stiffness.values[[0, -1]]
    next_below = grid[np.arange(len(limit)), above.argmax(axis=1) - 1]
    return [
        Check.holds(
            "Each of the contacts drawn ends on a sprag-slip cycle, which repeats to 1e-9",
            "Sect. 8.6.1, Fig. 8.13",
            f"{int((labels == Attractor.SPRAG_SLIP_CYCLE).sum())} of {labels.size}, residual {residual:.1e}",
            bool((labels == Attractor.SPRAG_SLIP_CYCLE).all()) and residual <= 1e-9,
        ),
        Check.holds(
            "The drives stand at different distances beyond their thresholds: each contact has a critical mass of its "
            "own below the mass drawn, the smaller the softer it is",
            "Sect. 8.6.1, Fig. 8.13",
            f"m = {float(dataset.mass):g} kg, m_cr = {', '.join(f'{x:.3g}' for x in critical)} kg",
            bool((critical < float(dataset.mass)).all() and (np.diff(critical) < 0).all()),
        ),
        Check.holds(
            "Softer contacts make the trajectory smoother: the shortest time Ω / max|θ″| grows from each to the next",
            "Sect. 8.6.1, Fig. 8.13",
            f"{times} µs from the stiffest to the softest contact",
            bool((np.diff(fastest) < 0).all()),
        ),
        Check.holds(
            "The coupling deflection becomes positive with the softest contact and with none that is stiffer",
            "Sect. 8.6.1, Fig. 8.13",
            f"largest z {', '.join(f'{x:.4g}' for x in deflection)} rad",
            bool(deflection[-1] > 0 > deflection[:-1].max()),
        ),
        Check.holds(
            "It is during sprag that the deflection becomes positive: its largest value lies there, to 1e-12 rad",
            "Sect. 8.6.1, Fig. 8.13",
            f"with the softest contact {sprag[-1]:.6g} rad during sprag, {deflection[-1]:.6g} rad on the cycle",
            bool(sprag[-1] > 0) and bool(abs(sprag[-1] - deflection[-1]) <= 1e-12),
        ),
        Check.holds(
            "For each contact stiffness one contact damping bounds the positive deflections, and there max z = 0",
            "sweep over the contact parameters",
            f"c_c from {limit.min():.5g} to {limit.max():.5g} N s/m for k_c from {softest:.0e} to {stiffest:.0e} "
            f"N/m; |max z| up to {edge.max():.1e} rad on it; negative for "
            f"{int((grid[above] < 0).sum())} of {int(above.sum())} contacts above, positive for "
            f"{int((next_below > 0).sum())} of {next_below.size} next below",
            bool((edge <= _TURNS).all() and (grid[above] < 0).all() and (next_below > 0).all()),
        ),
        Check.everywhere(
            "Every contact of the sweep ends on a sprag-slip cycle", "sweep over the contact parameters", cycles
        ),
    ]


def _numbers(steady: SteadyState) -> dict[str, float]:
    """Numbers of ``_NUMBERS`` of one attractor; without a cycle all but the attractor are nan."""
    if steady.orbit is None:
        return dict.fromkeys(_NUMBERS, np.nan) | {"attractor": steady.label}
    automaton = steady.orbit.automaton
    deflection = automaton.observables["coupling_deflection"]
    sprags = np.isin(automaton.codes, automaton.sprag_codes)
    return {
        "attractor": steady.label,
        "largest_deflection": steady.extremes(deflection)[1],
        "sprag_deflection": orbit_extremes(steady.orbit, deflection, sprags)[1],
        "largest_acceleration": max(map(abs, steady.extremes(automaton.tables.flow.field[:, 1]))),
        "period": steady.period,
        "period_residual": steady.residual,
    }


def _table(dims: tuple[str, ...], name: str, values) -> tuple:
    table = np.array([[x[name] for x in row] if isinstance(row, list) else row[name] for row in values], dtype=float)
    if name == "attractor":  # also on the grid
        return flagged(dims, table, _NUMBERS[name][1], Attractor)
    return variable(dims, table, *_NUMBERS[name])


def _boundary(deflection: Callable[[float], float], damping: np.ndarray, row: list[dict]) -> tuple[float, float]:
    """Largest contact damping at which the deflection turns positive, and the deflection there; regula falsi in log c.

    ``row`` holds the numbers at the dampings of the grid. Raises ``InputError`` if the grid has no turn.
    """
    values = np.array([numbers["largest_deflection"] for numbers in row])
    turns = np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0))
    if turns.size == 0:
        raise InputError("contact_damping: the largest deflection does not change its sign over the grid; widen it.")
    low, high = np.log(damping[turns[-1] : turns[-1] + 2])
    above, below = values[turns[-1]], values[turns[-1] + 1]
    side, middle, value = 0, low, above
    for _ in range(_TRIES):
        middle = (low * below - high * above) / (below - above)
        value = deflection(float(np.exp(middle)))
        if abs(value) <= _TURNS:
            break
        if value > 0:  # Illinois: halve the weight of an end that stays
            low, above, below, side = middle, value, below / (2 if side == 1 else 1), 1
        else:
            high, below, above, side = middle, value, above / (2 if side == -1 else 1), -1
    return float(np.exp(middle)), float(value)
