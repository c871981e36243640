r"""Work per cycle: what motor and load put in, what friction, damping and impacts take out. Of every model.

Each power is a quadratic form of (x, 1) in a mode. With Y the affine flow e^{Mt} of the mode in its inner coordinates,

    ∫₀ᵀ Yᵀ Q Y dt = W(T),      W(2h) = W(h) + Y(h)ᵀ W(h) Y(h),

starts from a step so short that Gauss' rule with eight nodes is exact to rounding, and doubles: nothing is sampled, and
neither equal rates nor rates decades apart are special. The terms are summed from different laws – input and load from
the ends of the drive, friction from N and the speed of sliding, impacts from the kinetic energy – so that their balance
is a check of the cycle.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from lsvib.engine.automaton import Automaton
from lsvib.engine.exact.taylor_form import eta
from lsvib.engine.kernels import flow_planar, flow_taylor, layout
from lsvib.engine.motion import Motion
from lsvib.models.drive import Drive
from lsvib.models.powers import Powers, product


@dataclass(frozen=True)
class Work:
    """Work over one period [J]: ``motor`` and ``load`` put in (negative if they take), the others take out.

    ``motor``: Ω ∫ T dt, with the torque T of the coupling or, behind a motor with a controller, that of the controller,
    T = K_p (Ω − θ_m′) + K_i ∫ (Ω − θ_m′) dt. Such a speed loop is then a spring and a damper to the commanded motion:
    its K_p ∫ (Ω − θ_m′)² dt is part of ``damping``, and the rotor receives so much less, ∫ T θ_m′ dt. ``friction`` of
    the threads, of slide, bearing and collar; ``damping``, all dampers; ``impacts``, kinetic energy that seizures
    destroy.
    """

    motor: float
    load: float
    friction: float
    damping: float
    impacts: float

    @property
    def balance(self) -> float:
        """What is put in less what is taken out, relative to the largest term [1]; zero but for rounding."""
        gained = self.motor + self.load - self.friction - self.damping - self.impacts
        largest = max(abs(getattr(self, term.name)) for term in fields(self))
        return gained / largest if largest else 0.0

    @property
    def efficiency(self) -> float:
        """Work that motor or load receives over what the other puts in [1]; 0 if both put in."""
        put_in = max(self.motor, self.load)
        return max(-min(self.motor, self.load), 0.0) / put_in if put_in > 0 else math.nan


def quadratic_integrals(
    automaton: Automaton, mode: int, state: np.ndarray, time: float, forms: np.ndarray
) -> np.ndarray:
    """Return ∫ (x, 1)ᵀ Q (x, 1) dt (k) over a time [s] from a state (n) in a mode, of forms Q (k, n + 1, n + 1).

    Under a friction law there may be two for each (k, 2, n + 1, n + 1), the second of which counts η times.
    """
    if time == 0.0:
        return np.zeros(len(forms))
    if isinstance(automaton.tables.flow, layout.TaylorFlow):
        return _summed(automaton, mode, state, time, forms)
    into, out = _inner_coordinates(automaton, mode)
    inner = out.T @ forms @ out
    # phase of the first step at the fastest rate: the rule is then wrong by less than 1e-20
    doublings = max(0, math.ceil(math.log2(max(_fastest(automaton, mode) * time / 0.5, 1e-300))))
    step = time * 0.5**doublings
    total = np.zeros_like(inner)
    for node, weight in zip(*np.polynomial.legendre.leggauss(8), strict=True):  # exact up to the 15th power of time
        moved = _propagator(automaton, mode, 0.5 * step * (1.0 + node))
        total += 0.5 * step * weight * (moved.T @ inner @ moved)
    for k in range(doublings):
        moved = _propagator(automaton, mode, step * 2.0**k)
        total = total + moved.T @ total @ moved
    start = into @ np.append(state, 1.0)
    integrals: np.ndarray = np.einsum("i,kij,j->k", start, total, start)
    return integrals


def _summed(automaton: Automaton, mode: int, state: np.ndarray, time: float, forms: np.ndarray) -> np.ndarray:
    """Return the integrals under a friction law by Gauss' rule on each step of the series: exact to rounding."""
    flow: Any = automaton.tables.flow
    room = 64
    places, weights = np.polynomial.legendre.leggauss(12)
    while True:
        states, steps = np.empty((room * 12, state.size)), np.empty(room)
        count = flow_taylor.nodes(flow, mode, state, time, 0.5 * (1.0 + places), states, steps)
        if count <= room:
            break
        room = count
    states, weights = states[: count * 12], (0.5 * steps[:count, None] * weights).ravel()
    whole = np.column_stack([states, np.ones(len(states))])
    shares = np.stack([np.ones(len(states)), eta(flow, states, np.full(len(states), mode))])
    pairs = forms if forms.ndim == 4 else np.stack([forms, 0 * forms], axis=1)
    values = np.einsum("ji,kpil,jl->kpj", whole, pairs, whole)
    return np.asarray(np.einsum("kpj,pj,j->k", values, shares, weights))


def _inner_coordinates(automaton: Automaton, mode: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrices (q + 1, n + 1) into and (n + 1, q + 1) out of the coordinates that the flow is held in."""
    flow, n = automaton.tables.flow, len(automaton.states)
    if isinstance(flow, np.ndarray):
        return np.eye(n + 1), np.eye(n + 1)
    q = int(2 * flow.pairs[mode] + flow.singles[mode])
    unit = np.eye(max(n, q) + 1)
    out = np.concatenate([flow.from_modal[mode][:, :q], flow.from_modal[mode][:, -1:]], axis=1)
    return np.vstack([flow.to_modal[mode, :q], unit[n, : n + 1]]), np.vstack([out, unit[q, : q + 1]])


def _propagator(automaton: Automaton, mode: int, time: float) -> np.ndarray:
    """Return the affine flow of a mode over a time [s] in its inner coordinates with a one, (q + 1, q + 1)."""
    flow = automaton.tables.flow
    if isinstance(flow, np.ndarray):
        row = flow[mode]
        c, s, s_rate = flow_planar.responses(row, time)
        moved = flow_planar.integrated_response(row, time)
        a0, b = row[layout.A0], row[layout.B]
        pushed = b * moved if b else 0.0  # in a rest so long that t² is beyond all numbers as well
        return np.array([[c, s, pushed], [-a0 * s, s_rate, b * s], [0.0, 0.0, 1.0]])
    pairs, singles = int(flow.pairs[mode]), int(flow.singles[mode])
    found = np.eye(2 * pairs + singles + 1)
    for pair in range(pairs):
        row = flow.oscillators[mode, pair]
        c, s, s_rate = flow_planar.responses(row, time)
        found[2 * pair : 2 * pair + 2, 2 * pair : 2 * pair + 2] = [[c, s], [-row[layout.A0] * s, s_rate]]
    for single in range(singles):
        k, rate, push = 2 * pairs + single, float(flow.rates[mode, single]), float(flow.pushes[mode, single])
        more = math.expm1(min(rate * time, flow_planar.OVERFLOW))
        found[k, k], found[k, -1] = 1.0 + more, push * (more / rate if rate else time)
    return found


def _fastest(automaton: Automaton, mode: int) -> float:
    """Size of the fastest rate [1/s] of a mode."""
    flow = automaton.tables.flow
    if isinstance(flow, np.ndarray):
        rows, singles = flow[mode][None], np.zeros(0)
    else:
        rows, singles = flow.oscillators[mode, : flow.pairs[mode]], flow.rates[mode, : flow.singles[mode]]
    pairs = np.hypot(rows[:, layout.ALPHA], rows[:, layout.BETA]) + rows[:, layout.DELTA]
    return float(np.max(np.concatenate([np.abs(pairs), np.abs(singles)]), initial=0.0))


def observable_integrals(orbit: Motion, names: Sequence[str]) -> np.ndarray:
    """Return the integrals over time [s] (arcs, k) of observables by name, over each arc of a motion."""
    automaton, one, found = orbit.automaton, np.eye(orbit.start_state.size + 1)[-1], []
    for mode, start, _, duration in zip(*orbit.arcs(), strict=True):
        forms = np.array([product(automaton.observables[name][mode], one) for name in names])
        if automaton.parts:
            none = np.zeros_like(one)
            more = [product(automaton.parts[name][mode] if name in automaton.parts else none, one) for name in names]
            forms = np.stack([forms, more], axis=1)
        found.append(quadratic_integrals(automaton, mode, start, float(duration), forms))
    return np.array(found)


def rubbing_integrals(drive: Drive, orbit: Motion) -> np.ndarray:
    """Return ∫ μ N dt [N s] (arcs) over each arc of a motion; at rest it has no meaning."""
    automaton, one = orbit.automaton, np.eye(orbit.start_state.size + 1)[-1]
    powers, found = Powers(drive, automaton), list[float]()
    for mode, start, _, duration in zip(*orbit.arcs(), strict=True):
        form = powers.rubbed(product(automaton.observables["normal_force"][mode], one))
        found.extend(quadratic_integrals(automaton, mode, start, float(duration), form[None]))
    return np.array(found)


def means(orbit: Motion) -> dict[str, float]:
    """Return the exact means over one period of all observables, without the impulses of seizures."""
    names = list(orbit.automaton.observables)
    totals = observable_integrals(orbit, names).sum(axis=0)
    return dict(zip(names, (float(x) for x in totals / orbit.end_time), strict=True))


def work(drive: Drive, orbit: Motion) -> Work:
    """Return the work of each kind over one period of a cycle of a drive."""
    automaton = orbit.automaton
    powers, totals = Powers(drive, automaton), np.zeros(4)
    for mode, start, _, duration in zip(*orbit.arcs(), strict=True):
        code = int(mode)
        forms = [powers.motor(code), powers.load(), powers.signed_friction(code), powers.damping()]
        forms += powers.friction(code)
        if powers.by_speed:
            forms = [form if form.ndim == 3 else np.stack([form, 0 * form]) for form in forms]
        found = quadratic_integrals(automaton, mode, start, float(duration), np.array(forms))
        totals += found[:4]
        totals[2] += np.abs(found[4:]).sum()
    lost = np.array([powers.kinetic(x) - powers.kinetic(y) for x, y in zip(orbit.before, orbit.after, strict=True)])
    seized = np.isin(orbit.kind, automaton.sprag_kinds)
    return Work(*map(float, [*totals, lost[seized].sum()]))
