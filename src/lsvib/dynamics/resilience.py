r"""How large a perturbation steady sliding tolerates, and how much of a window settles: from the boundary of the basin.

It moves the drive from steady sliding to a deviation (u, w) at once, and is tolerated if that lies in the basin
(docs/basin.md); energy is E = k u² / 2 + J w² / 2, J = I + m r_m² tan² λ.
"""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive
from lsvib.dynamics.boundary import AttractsNothing, Basin, basin
from lsvib.dynamics.curves import Arc, Part, Piece, Window, passes, sign_changes, state_on, states_on
from lsvib.numbers import bisected
from lsvib.systems.flow import Flow
from lsvib.words import plain

_SAMPLES = 400  # of an arc under a friction law, between which the energy is taken to have no two extrema


@dataclass(frozen=True)
class Resilience:
    """The largest perturbations that steady sliding tolerates: infinite if it tolerates all, zero if none.

    Perturbations of the deflection alone, ``angle`` [rad]; of the ``speed`` alone [rad/s]; and by ``energy``
    E = k u² / 2 + (I + m r_m² tan² λ) w² / 2 [J], first reached at ``state`` (u [rad], w [rad/s]), NaN if there is
    none. ``boundary`` of the basin in words, or neutral or unstable where there is no basin; ``fraction`` [1] of the
    ``window`` that settles, NaN without one. If friction depends on speed, infinite means up to 10⁵ Ω (docs/basin.md).

    >>> found = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10).resilience()
    >>> found.boundary, [float(f"{value:.6g}") for value in (found.angle, found.speed, found.energy, *found.state)]
    ('touching_motion', [0.0223138, 7.46627, 0.000154064, 0.00618009, 6.7485])
    """

    boundary: str
    angle: float
    speed: float
    energy: float
    state: tuple[float, float]
    fraction: float
    window: Window | None = None

    def to_json(self) -> dict[str, Any]:
        """Return plain numbers and names; None stands for infinity and NaN."""
        found = asdict(self) | {"window": None if self.window is None else self.window._asdict()}
        found = {name: None if isinstance(x, float) and not math.isfinite(x) else x for name, x in found.items()}
        return found | {"state": [x if math.isfinite(x) else None for x in self.state]}

    def text(self) -> Iterator[str]:
        """Yield it in lines of text."""

        def size(value: float, unit: str) -> str:
            return f"{value:.12g} {unit}" if math.isfinite(value) else "unlimited"

        yield f"boundary of the region of attraction: {plain(self.boundary)}"
        yield f"largest tolerated perturbation of the deflection: {size(self.angle, 'rad')}"
        yield f"largest tolerated perturbation of the speed: {size(self.speed, 'rad/s')}"
        u, w = self.state
        state = f", at u = {u:.12g} rad, w = {w:.12g} rad/s" if math.isfinite(self.energy) else ""
        yield f"largest tolerated perturbation by energy: {size(self.energy, 'J')}{state}"
        if self.window is not None:
            yield f"share of the window that settles: {self.fraction:.12g}"


def resilience(drive: Drive, window: Part | None = None) -> Resilience:
    """Return the perturbations that steady sliding tolerates, as :meth:`lsvib.Drive.resilience`."""
    window = None if window is None else Window.of(window)
    share = math.nan if window is None else 1.0
    if drive.rigid and automaton_of(drive).contracts and drive.support_damping > 0:
        # every motion settles, however slowly: no boundary is looked for
        return Resilience("none", math.inf, math.inf, math.inf, (math.nan, math.nan), share, window)
    try:
        region = basin(drive)
    except AttractsNothing as nothing:
        return Resilience("neutral" if nothing.neutral else "unstable", 0.0, 0.0, 0.0, (0.0, 0.0), 0.0 * share, window)
    energy, state = least_energy(region)
    return Resilience(
        boundary=region.boundary.name.lower(),
        angle=largest_tolerated(region, 0),
        speed=largest_tolerated(region, 1),
        energy=energy,
        state=state,
        fraction=math.nan if window is None else region.fraction(window),
        window=window,
    )


def largest_tolerated(region: Basin, coordinate: int) -> float:
    """Return the largest tolerated perturbation of one coordinate (0: u [rad], 1: w [rad/s]) as a size, or infinity.

    It is the crossing of the boundary that lies nearest to the origin, where the other coordinate is zero.
    """
    pieces = [piece for curve in region.curves for piece in curve]
    found = (abs(place) for piece in pieces for _, place in passes(region.flow, piece, 1 - coordinate, 0.0))
    return min(found, default=math.inf)


def least_energy(region: Basin) -> tuple[float, tuple[float, float]]:
    """Return the energy [J] up to which all perturbations are tolerated, and where (u [rad], w [rad/s]) one is not."""
    drive = region.drive
    lever = drive.pitch_radius * math.tan(drive.lead_angle)
    stiffness, inertia = drive.coupling_stiffness, drive.screw_inertia + drive.mass * lever**2
    best = math.inf, (math.nan, math.nan)
    for piece in (piece for curve in region.curves for piece in curve):
        for u, w in _candidates(region.flow, piece, stiffness, inertia):
            best = min(best, (0.5 * stiffness * u * u + 0.5 * inertia * w * w, (float(u), float(w))))
    return float(best[0]), best[1]


def _candidates(flow: Flow, piece: Piece, stiffness: float, inertia: float) -> Iterator[np.ndarray]:
    """States on a piece among which the energy is smallest."""
    if isinstance(piece, Arc):
        yield from (piece.start, piece.end)
        times = sign_changes(flow, piece, np.array([0.0, 1.0, 0.0])) + _stationary(flow, piece, stiffness, inertia)
        yield from (state_on(flow, piece, time) for time in times)
    elif piece.start[0] == piece.end[0]:  # it may begin or end at infinity
        low, high = sorted((piece.start[1], piece.end[1]))
        yield np.array([piece.start[0], min(max(0.0, low), high)])
    else:
        way, metric = piece.end - piece.start, np.array([stiffness, inertia])
        share = -float((metric * piece.start) @ way) / float((metric * way) @ way)
        yield piece.start + min(max(share, 0.0), 1.0) * way


def _stationary(flow: Flow, arc: Arc, stiffness: float, inertia: float) -> list[float]:
    """Times [s] on an arc at which k u + J w′ = E′ / w changes its sign; of a friction law as seen by samples."""
    way = flow.field[arc.mode, 0, 1]  # of time: u′ = ±w
    if not flow.by_speed:
        return sign_changes(flow, arc, np.array([stiffness, 0, 0]) + way * inertia * flow.field[arc.mode, 1])

    def rate(times: Any) -> np.ndarray:
        states = states_on(flow, arc, times)
        whole = np.column_stack([states, np.ones(len(states))])
        force = flow.share(states, np.full(len(states), arc.mode)) * (whole @ flow.tables.contact[arc.mode])
        pushed = whole @ flow.field[arc.mode, 1] + flow.tables.push[arc.mode, 1] * force
        return np.asarray(stiffness * states[:, 0] + way * inertia * pushed)

    times = np.linspace(0.0, arc.duration, _SAMPLES)
    sides = rate(times) > 0
    turns = np.flatnonzero(sides[1:] != sides[:-1])
    return [bisected(lambda t, k=k: (rate([t])[0] > 0) != sides[k], *times[k : k + 2]) for k in turns]  # type: ignore
