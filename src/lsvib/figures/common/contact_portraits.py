"""Phase portraits of the contact force (Sect. 8.2) as datasets: what figures 8.1 and 8.2 share.

The abscissa is the chapter's χ = N b_s / W (8.8). The ordinate is its rate, scaled by the time and force scale of law −
on both sides, so that it is continuous at χ = 0; see :mod:`lsvib.contact.contact_force`.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from lsvib.contact import contact_force
from lsvib.contact.contact_force import ForceArc, ForceFlow, ForceOutcome, Paradox
from lsvib.datasets import spans
from lsvib.datasets.attributes import Variables, attributes, drive_parameters, flagged, labels, named_index, variable
from lsvib.errors import InputError
from lsvib.models.drive import ThreadsDrive
from lsvib.models.mechanics import coefficients

_LAWS = (1, -1)  # sgn(θ′) sgn(N), in the order of the dimension
# The contact force in its own scale and time depends on inertias, geometry, friction and contact alone.
_NO_EFFECT = ("coupling_stiffness", "support_damping", "input_speed", "translation_damping", "axial_force")
_UNIT = "kg-1 m-2"
_SIGN_OF_FORCE = {
    Paradox.INDETERMINATE: "theta' > 0 and W < 0, so that N has the sign opposite to chi",
    Paradox.INCONSISTENT: "theta' > 0 and W > 0, so that N has the sign of chi",
}
_OF_RATE = (
    "derivative of N b_- / W by the scaled time omega_- t, omega_-^2 = k_c cos(lambda) b_- Gamma_- / (m I), "
    "b_s = cos(lambda) + s mu sin(lambda); see (8.8), (8.9)"
)
# Each begins at the saddle; on the side of law + where the saddle lies, or across zero force to the side of law -.
_MANIFOLDS = (
    "unstable_away_from_zero_force", "unstable_across_zero_force",
    "stable_away_from_zero_force", "stable_across_zero_force",
)  # fmt: skip
_VIEWS = 30.0  # a motion is followed until it is so many times the half width of the map away
_SETTLING = 8.0  # times the decay time for which a motion that ends in the focus is followed


def portrait(settings: Mapping[str, Any], paradox: Paradox) -> xr.Dataset:
    """Compute motions of the contact force, their outcomes on a grid, and the manifolds of the saddle, θ′ > 0.

    ``settings``: see :class:`lsvib.figures.settings.ContactPortrait`; Γ₊ < 0, and a panel for each contact
    damping. Raises ``InputError``.
    """
    base = ThreadsDrive.of({"contact_stiffness": settings["contact_stiffness"], **settings["drive"]})
    drives = [base.replace(contact_damping=damping) for damping in settings["contact_dampings"]]
    cases = [contact_force.contact_flows(drive, paradox) for drive in drives]
    force, rate = spans.even(settings["force"]), spans.even(settings["rate"])
    limit = _VIEWS * max(np.ptp(force), np.ptp(rate)) / 2
    scale, side, count = contact_force.force_scale(base), int(paradox), settings["samples"]
    starts = [(_unscaled(s["force"], scale, side), float(s["rate"])) for s in settings["starts"]]
    grid = [(_unscaled(x, scale, side), y) for x in force for y in rate]
    outcomes = [[contact_force.follow(flows, start)[1] for start in grid] for flows in cases]
    outcomes = np.reshape(outcomes, (len(cases), force.size, rate.size))
    plane = ("case", "grid_contact_force", "grid_contact_force_rate")
    becomes = "what becomes of the contact force from each state of the grid"
    ratios = [flows[-1].damping for flows in cases]
    return xr.Dataset(
        _motions(cases, starts, count, limit, scale, side)
        | {"grid_outcome": flagged(plane, outcomes, becomes, ForceOutcome)}
        | _equilibria(cases, scale)
        | _by_newton(drives)
        | (_manifolds(cases, count, limit, scale) if paradox is Paradox.INDETERMINATE else {}),
        coords={
            "grid_contact_force": ("grid_contact_force", force, _force("contact force of the grid")),
            "grid_contact_force_rate": ("grid_contact_force_rate", rate, _rate("rate of the grid")),
            **_laws(base, cases[0]),
            **labels("case", drives, ("contact_damping",)),
            "eigenvalue": variable("eigenvalue", np.array([1, 2]), "1", "index of the eigenvalue", "$i$"),
            **drive_parameters(drives, along=("contact_damping",), no_effect=_NO_EFFECT),
            "contact_damping_ratio": variable(
                "case", ratios, "1", "contact damping times frequency over stiffness", r"$\zeta$"
            ),
            "force_scale": variable((), scale, "1", "factor between the force scales of the laws", "$b_+/b_-$"),
        },
    )


def _motions(
    cases: Sequence[dict[int, ForceFlow]],
    starts: Sequence[tuple[float, float]],
    count: int,
    limit: float,
    scale: float,
    side: int,
) -> Variables:
    """The motions of each case from each start, in ``count`` samples, and what becomes of them."""
    followed = [[contact_force.follow(flows, start) for start in starts] for flows in cases]
    motions = np.array([[sample(arcs, count, limit) for arcs, _ in case] for case in followed])
    outcomes = [[outcome for _, outcome in case] for case in followed]
    motion = ("case", "start", "sample")
    return {
        "contact_force": (motion, _scaled(motions[..., 0], scale, side), _force("contact force")),
        "contact_force_rate": (motion, motions[..., 1], _rate("rate of the contact force")),
        "start_outcome": flagged(motion[:2], outcomes, "what becomes of the contact force of a motion", ForceOutcome),
    }


def _equilibria(cases: Sequence[dict[int, ForceFlow]], scale: float) -> Variables:
    """The equilibrium of each law, which contact damping does not move, and the eigenvalues of each case and law."""
    eigenvalues = np.array([[flows[law].rates() for law in _LAWS] for flows in cases])
    equilibria = np.array([cases[0][1].equilibrium * scale, cases[0][-1].equilibrium])
    words = "equilibrium of the law, zero of the right-hand side of (8.7)"
    dims, part = ("case", "law", "eigenvalue"), "part of an eigenvalue of the law in scaled time"
    return {
        "equilibrium_contact_force": ("law", equilibria, _force(words)),
        "scaled_eigenvalue_real_part": variable(dims, eigenvalues.real, "1", f"real {part}", r"Re $\varepsilon$"),
        "scaled_eigenvalue_imaginary_part": variable(
            dims, eigenvalues.imag, "1", f"imaginary {part}", r"Im $\varepsilon$"
        ),
    }


def _laws(drive: ThreadsDrive, flows: dict[int, ForceFlow]) -> Variables:
    """The friction laws: on which side of N = 0 each of them holds, and its effective inertia."""
    gamma, sides = coefficients(drive).gamma, [flow.side for flow in flows.values()]
    words = "sign of the contact force chi where the law holds"
    sign = _SIGN_OF_FORCE[Paradox(flows[1].side)]  # law + holds where χ has this sign
    return {
        "law": variable("law", np.array(_LAWS), "1", "friction law", "$s$"),
        "law_side": variable("law", sides, "1", words, comment=sign),
        "effective_inertia_of_law": variable(
            "law", [float(gamma[law]) for law in _LAWS], "kg m2", "effective inertia of the law", r"$\Gamma_s$"
        ),
    }


def sample(arcs: Sequence[ForceArc], count: int, limit: float) -> np.ndarray:
    """Sample a motion at ``count`` times, shape (count, 2) of (x, x′); the last arc ends beyond |x − x*| = ``limit``.

    Each arc gets samples by its duration, at least two, its ends among them. A last arc without end in a centre lasts
    one turn, in a focus a fixed number of decay times; :func:`lsvib.datasets.phase_plane.sample` is for motions that
    have an end. Raises ``InputError`` if the samples are too few for the arcs.
    """
    if count < 2 * len(arcs):
        raise InputError(f"samples = {count} is outside the allowed range samples >= {2 * len(arcs)} of this motion.")
    durations = [arc.duration if math.isfinite(arc.duration) else _shown(arc, limit) for arc in arcs]
    ends = np.concatenate([[0.0], np.cumsum(durations)])
    shares = np.maximum(2, np.floor(np.array(durations) / ends[-1] * (count - 2 * len(arcs))).astype(int) + 2)
    shares[-1] += count - shares.sum()
    return np.array(
        [
            arc.flow.at(arc.start, time)
            for arc, duration, share in zip(arcs, durations, shares, strict=True)
            for time in np.linspace(0, duration, share)
        ]
    )


def _shown(arc: ForceArc, limit: float) -> float:
    """Scaled time for which an arc without end is shown."""
    first, _ = arc.flow.rates()
    growing = abs(arc.flow.amplitudes(arc.start)[0])
    if first.real > 0 and growing > 0:
        return max(math.log(limit / growing), 0.0) / first.real
    return 2 * math.pi / abs(first.imag) if first.real == 0 else _SETTLING / abs(first.real)


def _manifolds(cases: Sequence[dict[int, ForceFlow]], count: int, limit: float, scale: float) -> Variables:
    """Unstable and stable manifold of the saddle: each a ray that stays on the side of law +, and one that leaves it.

    All are followed away from the saddle, the stable ones backwards in time.
    """
    lines = [
        sample(_there_and_back(laws, outwards), count, limit) * [1, direction]
        for flows in cases
        for direction, laws in ((1, flows), (-1, contact_force.reversed_in_time(flows)))
        for outwards in (laws[1].side, -laws[1].side)
    ]
    lines = np.array(lines).reshape(len(cases), 4, count, 2)
    manifold = ("case", "manifold", "sample")
    return {
        "manifold_force": (
            manifold,
            _scaled(lines[..., 0], scale, int(Paradox.INDETERMINATE)),
            _force("contact force on a manifold of the saddle"),
        ),
        "manifold_force_rate": (manifold, lines[..., 1], _rate("rate on a manifold of the saddle")),
        "manifold": named_index(
            "manifold",
            "branch of the manifolds of the saddle",
            _MANIFOLDS,
            comment="samples begin at the saddle; along a stable branch time runs against them",
        ),
    }


def _there_and_back(laws: dict[int, ForceFlow], outwards: int) -> list[ForceArc]:
    """Arcs of an unstable manifold, from so close to the saddle that a picture cannot tell, until it is back at law +.

    Without damping it returns to the saddle, by symmetry in the time that it took to leave.
    """
    saddle = laws[1]
    near = 1e-6 * abs(saddle.equilibrium) * outwards  # on the manifold itself, a straight line here
    arcs, _ = contact_force.follow(laws, (saddle.equilibrium + near, saddle.rates()[0].real * near))
    if len(arcs) > 2 and saddle.damping == 0:
        return [*arcs[:2], ForceArc(saddle, arcs[2].start, arcs[0].duration)]
    return arcs[:3]


def _scaled(x: np.ndarray, scale: float, side: int) -> np.ndarray:
    """χ from x: equal on the side of law −, scaled on that of law +."""
    return np.where(x * side > 0, x * scale, x)


def _unscaled(force: float, scale: float, side: int) -> float:
    """Turn χ into x."""
    return float(force) / (scale if force * side > 0 else 1.0)


def _by_newton(drives: Sequence[ThreadsDrive]) -> Variables:
    """Zero and Jacobian of N″ from the two equations of motion alone (module text of ``contact_force``), θ′ > 0.

    I θ″ = T − r_m N (s μ cos λ − sin λ) and m x″ = P − N (cos λ + s μ sin λ) give e″ = x″ − r_m tan λ θ″, affine in N;
    with constant T and P then N″ = cos λ (k_c e″ + c_c ∂e″/∂N N′). Time in units of law − without contact damping.
    """
    base = drives[0]
    r, tan, cos, sin = base.pitch_radius, *(f(base.lead_angle) for f in (math.tan, math.cos, math.sin))
    push, torque = 1.0, -0.01  # P [N] and T [N m]; χ does not depend on them
    drift = base.screw_inertia * push - base.mass * r * tan * torque  # W

    def slip(force: float, law: int) -> float:
        """Return e″ [m/s²]."""
        friction = law * base.friction_coefficient
        turning = (torque - r * force * (friction * cos - sin)) / base.screw_inertia
        return (push - force * (cos + friction * sin)) / base.mass - r * tan * turning

    offset = {law: slip(0.0, law) for law in _LAWS}
    slope = {law: slip(1.0, law) - offset[law] for law in _LAWS}
    lever = {law: cos + law * base.friction_coefficient * sin for law in _LAWS}
    unit = math.sqrt(-base.contact_stiffness * cos * slope[-1])  # 1/s
    jacobian = np.array(
        [
            [
                (d.contact_damping * cos * slope[law] / unit, -d.contact_stiffness * cos * slope[law] / unit**2)
                for law in _LAWS
            ]
            for d in drives
        ]
    )
    return {
        "equilibrium_contact_force_by_newton": (
            "law",
            [-offset[law] / slope[law] * lever[law] / drift for law in _LAWS],
            _force("zero of N'' by the equations of motion"),
        ),
        "jacobian_trace": variable(("case", "law"), jacobian[..., 0], "1", "trace of the Jacobian of N''"),
        "jacobian_determinant": variable(("case", "law"), jacobian[..., 1], "1", "determinant of the Jacobian of N''"),
    }


def _force(long_name: str) -> dict[str, Any]:
    return attributes(_UNIT, long_name, r"$\chi$", comment="chi = N b_s / W, (8.8)")


def _rate(long_name: str) -> dict[str, Any]:
    return attributes(_UNIT, f"{long_name}, scaled by law - on both sides", r"$\chi'$", comment=_OF_RATE)
