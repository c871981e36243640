r"""The energy balance of a motion: what input and axial force supply, and where it goes.

With θ′ the speed of the screw, x′ of the nut, z = θ − Ω t, and the mechanical energy

    E = I θ′²/2 + m x′²/2 + k z²/2     [+ k_c δ²/2]     [+ m_1 x_1′²/2 + k_1 x_1²/2]     [+ I_2 θ_2′²/2 + k_2 θ_2²/2],

Newton's laws (Sect. 5.3, eqs 8.1, 8.13; 8.6; Sect. 5.6, eq. 8.23; Sect. 5.8, eq. 8.33), each times its speed, give

    E′ = −k z Ω + R x′ − c θ′² − c_x x′² − c_c δ′² − c_1 x_1′² − c_2 θ_2′² − F_0 |x′| − T_0 |θ′| − D.

The coupling torque −k z turns the input at Ω. With rigid threads, which slip at the speed ω (θ′, or θ′ − θ_2′), D = μ
|N| r_m |ω| / cos λ. With compliant threads, δ = e cos λ and e′ = x′ − r_m tan λ θ′, friction acts on the screw in the
direction of θ′, so that D = μ |N| sgn θ′ (r_m θ′ / cos λ + e′ sin λ), and at rest D = F e′ sin λ with the friction
F = (−k z / r_m + N sin λ) / cos λ that holds the screw. A seizure stops ω by an impulse and takes M ω²/2,

    M = I + m r_m² tan² λ,      I + m̃ r_m² tan² λ  (support),      I_eff + m r_m² tan² λ  (nut).

Speeds, z and N are the engine's observables, all else is formed here from the parameters. |N| and |θ′| are absolute
values, not products with the signs that the mode stands for.

What the balance sees: wrong coefficients of a field, a wrong law or mode, a wrong reset, a wrong flow. What it does
not: an event that is late by a little, or one after which the same laws go on; and nothing below ``rounding``.

Work along an arc is integrated by Gauss–Legendre quadrature of the engine's own closed form. Panels grow from both ends
of the arc, the first as wide as the fastest rate of the mode asks for, and are cut where a vibration that has not died
away would turn too far in them. Twelve nodes integrate exp of up to ±4 within a panel to 1e-16. Time is counted from
the start of each arc: the clock of the whole motion would not resolve a fast transient.
"""

import math
from typing import NamedTuple

import numpy as np

from benchmarks.sweeps.paths import fields
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import friction_factor
from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels import event_loop
from lsvib.systems.kernels.flow_planar import ROUNDING
from lsvib.systems.kernels.layout import Begin
from lsvib.systems.motion import Motion, new_events

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)  # the error falls with the 24th power of a panel's width
_FIRST = 1.5  # width of the first panel, in units of the fastest time
_GROWTH = 1.7  # of the next ones
_TURN = 3.5  # [rad] of a vibration in a panel
_GONE = 40.0  # e-foldings after which a vibration has died away
_MOST_PANELS = 20_000  # of half an arc; with more, because its rates lie too far apart, a motion has no balance
_EPS = float(np.finfo(float).eps)


class Balance(NamedTuple):
    """Change of energy less work supplied plus losses, of the largest of these, and what rounding may make of it [1].

    ``rounding``: last places of the terms that speeds and forces are summed from, times the work they do, and of the
    clock, times power; both are nan if the motion would need too many nodes.
    """

    residual: float
    rounding: float


class Terms(NamedTuple):
    """Energy and power of a motion as products of affine functions of the state x, each a row over x and 1.

    Energy Σ (energy·x)²; power Σ (left·x)(right·x) − Σ |pressing·x| sgn(direction·x) (sliding·x) + (holding·x)
    (approach·x); a seizure takes (seized·x)². Shapes (terms, n + 1), but ``pressing`` (terms, modes, n + 1),
    ``holding`` (modes, n + 1), ``approach`` and ``seized`` (n + 1).
    """

    energy: np.ndarray
    left: np.ndarray
    right: np.ndarray
    pressing: np.ndarray
    direction: np.ndarray
    sliding: np.ndarray
    holding: np.ndarray
    approach: np.ndarray
    seized: np.ndarray


def balance(motion: Motion, drive: Drive, physics: tuple[str, ...] = ()) -> Balance:
    """Balance the energy of a motion over its whole duration; ``physics`` has the words of frictions that are there."""
    return residual(motion, terms(motion.automaton, drive, physics))


def residual(motion: Motion, terms: Terms) -> Balance:
    """Residual of the balance and what rounding may make of it, both relative to the largest energy or work in it."""
    modes, starts, ends, durations = motion.arcs()
    rates = [np.linalg.eigvals(field[:, :-1]) for field in fields(motion.automaton)]
    stored, sizes = zip(*(_energy(terms, x) for x in (starts[0], *ends)), strict=True)
    work, rounding = np.zeros(len(terms.left) + len(terms.sliding) + 1), sizes[0] + sizes[-1]
    clock = np.append(motion.time, motion.end_time)
    for mode, start, duration, end in zip(modes, starts, durations, clock, strict=True):
        times, weights = _nodes(rates[mode], duration)
        if times is None:
            return Balance(math.nan, math.nan)
        powers, size = _powers(terms, mode, _states(motion.automaton, mode, start, times))
        work += weights @ powers[1:]
        # The clock holds the end of the arc to its last place; so long the largest power may act too much.
        rounding += weights @ size[1:] + np.abs(powers.sum(axis=1)).max() * abs(end)
    seized = motion.automaton.marked(motion.kind, "impact")
    lost = sum(_value(terms.seized, x)[0] ** 2 for x in ends[:-1][seized])
    largest = max(*stored, lost, *np.abs(work))
    if not largest > 0.0:
        return Balance(0.0, 0.0)
    return Balance(float(abs(stored[-1] - stored[0] - work.sum() + lost) / largest), float(_EPS * rounding / largest))


def _value(rows: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Affine functions (..., n + 1) of states (k, n) or (n), and the sums of the sizes of their terms."""
    x = np.concatenate([states, np.ones((*states.shape[:-1], 1))], axis=-1)
    return x @ rows.T, np.abs(x) @ np.abs(rows).T


def _energy(terms: Terms, state: np.ndarray) -> tuple[float, float]:
    """Energy, and the sum of the sizes that it is rounded by."""
    value, size = _value(terms.energy, state)
    return float(value @ value), float(2.0 * np.abs(value) @ size)


def _powers(terms: Terms, mode: int, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each power at some states of an arc, and the sums of the sizes that they are rounded by.

    The first state is in the middle of the arc: its signs are those of all. Where a body has just begun to slip, the
    sign is lost when the state is rounded.
    """
    (left, left_size), (right, right_size) = _value(terms.left, states), _value(terms.right, states)
    force, force_size = _value(terms.pressing[:, mode], states)
    speed, speed_size = _value(terms.sliding, states)
    way, way_size = _value(terms.direction, states)
    ways = np.where(np.abs(way) <= ROUNDING * way_size, 0.0, np.sign(way))
    ways = np.where(ways == 0.0, ways[0], ways)
    held, held_size = _value(terms.holding[mode], states)
    near, near_size = _value(terms.approach, states)
    powers = np.column_stack([left * right, -np.abs(force) * ways * speed, held * near])
    size = (np.abs(left) * right_size + left_size * np.abs(right)).sum(axis=1)
    size += (np.abs(force) * speed_size + force_size * np.abs(speed)).sum(axis=1)
    return powers, size + np.abs(held) * near_size + held_size * np.abs(near)


def _states(automaton: Automaton, mode: int, start: np.ndarray, times: np.ndarray) -> np.ndarray:
    """States (k, n) at times [s] (k) after the start of an arc."""
    states, modes = np.empty((times.size, start.size)), np.empty(times.size, dtype=np.int64)
    events = new_events(0, start.size)
    event_loop.states_at(automaton.tables, Begin(0.0, mode, start), events, times, states, modes)
    return states


def _nodes(rates: np.ndarray, duration: float) -> tuple[np.ndarray | None, np.ndarray]:
    """The middle of an arc, and the nodes in all panels of it [s], with their weights; None where they are too many."""
    half, passed, edges = 0.5 * duration, 0.0, [0.0]
    fastest = np.abs(rates).max(initial=0.0)
    turns = [(abs(rate.imag), abs(rate.real)) for rate in rates if rate.imag != 0.0]
    while passed < half:
        width = max(_FIRST / fastest if fastest > 0.0 else half, (_GROWTH - 1.0) * passed)
        width = min([width, *(_TURN / turn for turn, decay in turns if decay * passed < _GONE)])
        if len(edges) > _MOST_PANELS or not width > 0.0:
            return None, np.empty(0)
        passed = passed + width if width < half - passed else half
        edges.append(passed)
    left, widths = np.array(edges[:-1]), np.diff(edges)
    begins, widths = np.concatenate([left, duration - left - widths]), np.concatenate([widths, widths])
    times = begins[:, None] + 0.5 * widths[:, None] * (1.0 + _NODES)
    return np.append(half, times), np.outer(0.5 * widths, _WEIGHTS).ravel()


def terms(automaton: Automaton, drive: Drive, physics: tuple[str, ...] = ()) -> Terms:
    """Energy and powers of a drive as products of affine functions of the state (see the module's docstring)."""
    seen, n = automaton.observables, len(automaton.states)
    unit, d = np.eye(n + 1), drive
    tan, cos, sin = math.tan(d.lead_angle), math.cos(d.lead_angle), math.sin(d.lead_angle)
    reach, rubbing = d.pitch_radius * tan, d.friction_coefficient * d.pitch_radius / cos
    speed, spring, normal = seen["screw_speed"][0], seen["coupling_deflection"][0], seen["normal_force"]
    one = unit[n]
    nut, slip = reach * speed, speed
    inertia, moved = d.screw_inertia, d.mass
    stored, lost, rubbed = [], [], []
    holding = np.zeros((len(automaton.codes), n + 1))
    sliding = rubbing * speed
    if d.parts == ("threads",):
        nut = reach * speed + unit[3]
        stored.append((0.5 * d.contact_stiffness, cos * unit[2]))
        lost.append((d.contact_damping, cos * unit[3]))
        sliding = rubbing * speed + d.friction_coefficient * sin * unit[3]
        rest = automaton.marked(automaton.codes, "rest")
        friction = (-d.coupling_stiffness / d.pitch_radius * spring + sin * normal) / cos
        holding[rest] = friction[rest]
    elif d.parts == ("support",):
        nut, moved = reach * speed + unit[3], d.mass * d.screw_mass / (d.mass + d.screw_mass)
        force, _ = _steady(d, physics, reach)
        stored += [(0.5 * d.screw_mass, unit[3])]
        stored += [(0.5 * d.support_stiffness, unit[2] + force / d.support_stiffness * one)]
        lost.append((d.axial_support_damping, unit[3]))
    elif d.parts == ("nut",):
        slip = speed - unit[3]
        nut, sliding, inertia = reach * slip, rubbing * slip, inertia * d.nut_inertia / (inertia + d.nut_inertia)
        force, law = _steady(d, physics, reach)
        twist = d.pitch_radius * friction_factor(d.friction_coefficient, tan, law) * force
        stored += [(0.5 * d.nut_inertia, unit[3]), (0.5 * d.nut_stiffness, unit[2] + twist / d.nut_stiffness * one)]
        lost.append((d.nut_damping, unit[3]))
    stored += [(0.5 * d.screw_inertia, speed), (0.5 * d.mass, nut), (0.5 * d.coupling_stiffness, spring)]
    lost += [(d.support_damping, speed), (d.translation_damping, nut)]
    rubbed.append((normal, slip, sliding))
    for word, what in (("slide_friction", nut), ("bearing_friction", speed)):
        if word in physics:
            rubbed.append((np.broadcast_to(getattr(d, word) * one, normal.shape), what, what))
    supplied = [(-d.coupling_stiffness * d.input_speed, spring, one), (d.axial_force, nut, one)]
    return Terms(
        energy=np.array([np.sqrt(factor) * row for factor, row in stored]),
        left=np.array([*(factor * row for factor, row, _ in supplied), *(-factor * row for factor, row in lost)]),
        right=np.array([*(row for *_, row in supplied), *(row for _, row in lost)]),
        pressing=np.array([row for row, *_ in rubbed]),
        direction=np.array([row for _, row, _ in rubbed]),
        sliding=np.array([row for *_, row in rubbed]),
        holding=holding,
        approach=-sin * unit[3] if n == 4 else np.zeros(n + 1),
        seized=np.sqrt(0.5 * (inertia + moved * reach**2)) * slip,
    )


def _steady(drive: Drive, physics: tuple[str, ...], reach: float) -> tuple[float, int]:
    """Axial force [N] that the threads carry in steady sliding, and its law."""
    turning = 1 if drive.input_speed > 0 else -1
    force = drive.axial_force - reach * drive.translation_damping * drive.input_speed
    force -= drive.slide_friction * turning * ("slide_friction" in physics)
    return force, -1 if force * turning < 0 else 1
