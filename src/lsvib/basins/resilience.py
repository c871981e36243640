r"""How large a perturbation steady sliding tolerates, and how much of a window settles: from the boundary of the basin.

A perturbation moves the drive from steady sliding to a deviation (u, w) at once. It is tolerated if that lies in the
basin; the smallest that is not ends on the boundary, and every smaller one is tolerated. Along u = 0 and along w = 0
that is the nearest crossing, a root along an arc.
By its energy

    E = k u² / 2 + J w² / 2,        J = I + m r_m² tan² λ

(of the coupling, and of screw and mass, relative to steady sliding) it is the nearest point: on an arc of the flow
w′ = b − a₀ u − a₁ w energy is stationary where E′ = w [(k − J a₀) u − J a₁ w + J b] = 0, so again at roots of affine
functions, and on a segment where a quadratic function is smallest.
"""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.basins.boundary import AttractsNothing, Basin, Boundary, basin
from lsvib.basins.curves import Arc, Piece, Segment, Window, sign_changes, state_on
from lsvib.engine.kernels import layout
from lsvib.models.drive import RigidDrive
from lsvib.models.rigid import rigid_automaton


@dataclass(frozen=True)
class Resilience:
    """The perturbations that steady sliding of a rigid drive tolerates; infinite where it tolerates all, zero if none.

    ``boundary`` of its basin in words, or ``neutral`` or ``unstable`` where there is no basin; largest tolerated
    perturbation of the deflection ``angle`` [rad] alone, of the ``speed`` [rad/s] alone, and by ``energy`` [J], which
    is reached first at ``state`` (u [rad], w [rad/s]), nan if there is none; ``fraction`` [1] of the ``window`` that
    settles, nan without a window.
    """

    boundary: str
    angle: float
    speed: float
    energy: float
    state: tuple[float, float]
    fraction: float
    window: Window | None = None

    def to_json(self) -> dict[str, Any]:
        """Return plain numbers and names; None stands for what is infinite or not a number."""
        found = asdict(self)
        found["window"] = None if self.window is None else self.window._asdict()
        found["state"] = [_plain(x) for x in self.state]
        return {name: _plain(value) for name, value in found.items()}


def _plain(value: Any) -> Any:
    """The same, or None for a number that is not finite."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def resilience(drive: RigidDrive, window: Window | None = None) -> Resilience:
    """Return the perturbations that the steady sliding of a rigid drive tolerates.

    Arguments: drive; a ``window`` of the phase plane. Raises ``InputError`` and ``EngineError`` where the basin is not
    covered (:func:`lsvib.basins.boundary.basin`).
    """
    if rigid_automaton(drive).contracts and drive.support_damping > 0:
        return _all(Boundary.NONE, window)  # every motion settles, however slowly: no boundary is looked for
    try:
        region = basin(drive)
    except AttractsNothing as nothing:
        share = math.nan if window is None else 0.0
        return Resilience("neutral" if nothing.neutral else "unstable", 0.0, 0.0, 0.0, (0.0, 0.0), share, window)
    if not region.curves:
        return _all(region.boundary, window)
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


def _all(boundary: Boundary, window: Window | None) -> Resilience:
    """Return the resilience of a drive whose steady sliding is globally stable."""
    share = math.nan if window is None else 1.0
    return Resilience(boundary.name.lower(), math.inf, math.inf, math.inf, (math.nan, math.nan), share, window)


def largest_tolerated(region: Basin, coordinate: int) -> float:
    """Return the largest tolerated perturbation of one coordinate (0: u [rad], 1: w [rad/s]) as a size, or infinity.

    It is the crossing of the boundary that lies nearest to the origin, where the other coordinate is zero.
    """
    return min((abs(value) for value in _crossings(region, coordinate)), default=math.inf)


def _crossings(region: Basin, coordinate: int) -> Iterator[float]:
    """Where the boundary meets the axis of a coordinate, on which the other one is zero."""
    other = 1 - coordinate
    row = np.eye(3)[other]
    for piece in _pieces(region):
        if piece.start[other] == 0:
            yield float(piece.start[coordinate])
        if isinstance(piece, Arc):
            for time in sign_changes(region.flow, piece, row):
                yield float(state_on(region.flow, piece, time)[coordinate])
            continue
        first, last = piece.start[other], piece.end[other]
        if min(first, last) < 0 < max(first, last):
            if piece.start[coordinate] == piece.end[coordinate]:  # it may begin or end at infinity
                yield float(piece.start[coordinate])
            else:
                share = first / (first - last)
                yield float(piece.start[coordinate] + share * (piece.end[coordinate] - piece.start[coordinate]))


def least_energy(region: Basin) -> tuple[float, tuple[float, float]]:
    """Return the energy [J] up to which all perturbations are tolerated, and where (u [rad], w [rad/s]) one is not."""
    drive = region.drive
    lever = drive.pitch_radius * math.tan(drive.lead_angle)
    stiffness, inertia = drive.coupling_stiffness, drive.screw_inertia + drive.mass * lever**2
    best = math.inf, (math.nan, math.nan)
    for piece in _pieces(region):
        for u, w in _candidates(region.flow, piece, stiffness, inertia):
            best = min(best, (0.5 * stiffness * u * u + 0.5 * inertia * w * w, (float(u), float(w))))
    return float(best[0]), best[1]


def _candidates(
    flow: NDArray[np.float64], piece: Piece, stiffness: float, inertia: float
) -> Iterator[tuple[float, float]]:
    """States on a piece among which the energy is smallest."""
    if isinstance(piece, Segment):
        yield _nearest(piece, stiffness, inertia)
        return
    a0, a1, b = (float(flow[piece.mode, k]) for k in (layout.A0, layout.A1, layout.B))
    rows = np.array([[0.0, 1.0, 0.0], [stiffness - inertia * a0, -inertia * a1, inertia * b]])
    yield piece.start[0], piece.start[1]
    yield piece.end[0], piece.end[1]
    for row in rows:
        for time in sign_changes(flow, piece, row):
            u, w = state_on(flow, piece, time)
            yield float(u), float(w)


def _nearest(piece: Segment, stiffness: float, inertia: float) -> tuple[float, float]:
    """The state on a segment with the least energy."""
    (u, w), (u_end, w_end) = piece.start, piece.end
    if u == u_end:  # it may begin or end at infinity
        return float(u), float(min(max(0.0, min(w, w_end)), max(w, w_end)))
    du, dw = u_end - u, w_end - w
    share = -(stiffness * u * du + inertia * w * dw) / (stiffness * du * du + inertia * dw * dw)
    share = min(max(share, 0.0), 1.0)
    return float(u + share * du), float(w + share * dw)


def _pieces(region: Basin) -> Iterator[Piece]:
    for curve in region.curves:
        yield from curve
