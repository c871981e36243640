"""Mirror symmetry, and the balances of energy and of axial momentum along every arc of random motions.

Energy is E = ½ (I + m p²) θ′² + ½ k z² with p = r_m tan λ. The motor feeds it through the coupling (torque −k z at the
speed Ω), the axial force R works on the nut, and the dampings and the friction of the threads consume it:

    dE/dt = −k z Ω + R x′ − c θ′² − c_x x′² − μ |N| |v|,      v = r_m θ′ / cos λ the speed of sliding.

Works are Gauss–Legendre sums over pieces of an arc in which no exponent moves by more than 1, with 20 nodes: exact to
rounding. N is formed here from the balance of forces on the nut, not taken from the model.

Tolerance 1e-11 of the energies (forces) involved. N is a quotient by Γ_s, whose rounding is amplified by I/Γ_s, up to
1e3 here, and energy is a difference of terms some 1e2 times larger than what is balanced: 1e5 eps. The errors seen stay
below 1e-13.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references.drives import RULES, drives, starts

from lsvib.dynamics.impulses import seizure_impulses
from lsvib.engine.kernels import flow_planar, layout
from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.names import Event
from lsvib.models.rigid import MotionMode, rigid_automaton

TOLERANCE = 1e-11
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)
LAWS = {
    MotionMode.SLIP_FORWARD_POSITIVE: 1,
    MotionMode.SLIP_BACKWARD_NEGATIVE: 1,
    MotionMode.SLIP_FORWARD_NEGATIVE: -1,
    MotionMode.SLIP_BACKWARD_POSITIVE: -1,
    MotionMode.REST: 0,
}


class Mechanics:
    """The drive as a mechanical system, from its parameters alone (double precision, Newton's laws as in Sect. 2)."""

    def __init__(self, drive: Drive) -> None:
        self.drive, self.tan = drive, math.tan(drive.lead_angle)
        self.p = drive.pitch_radius * self.tan
        net = drive.axial_force - self.p * drive.translation_damping * drive.input_speed
        steady = math.copysign(1, net * drive.input_speed)
        damping = drive.support_damping - self.xi(steady) * drive.pitch_radius * self.p * drive.translation_damping
        torque = damping * drive.input_speed + drive.pitch_radius * self.xi(steady) * drive.axial_force
        self.z0 = -torque / drive.coupling_stiffness

    def xi(self, law: float) -> float:
        return (law * self.drive.friction_coefficient - self.tan) / (
            1 + law * self.drive.friction_coefficient * self.tan
        )

    def energy(self, u, w):
        inertia = self.drive.screw_inertia + self.drive.mass * self.p**2
        speed = self.drive.input_speed + w
        return 0.5 * inertia * speed**2 + 0.5 * self.drive.coupling_stiffness * (self.z0 + u) ** 2

    def axial_contact_force(self, u, w, law):
        """N (cos λ + μ_s sin λ), from the nut's balance; in rest the axial force R."""
        d, speed = self.drive, self.drive.input_speed + w
        push = d.axial_force - d.translation_damping * self.p * speed
        if law == 0:
            return push
        inertia = d.screw_inertia - self.xi(law) * d.pitch_radius * self.p * d.mass
        torque = -d.coupling_stiffness * (self.z0 + u) - d.support_damping * speed
        acceleration = (torque - self.xi(law) * d.pitch_radius * push) / inertia
        return push - d.mass * self.p * acceleration

    def normal_force(self, u, w, law):
        friction = law * self.drive.friction_coefficient
        lead = self.drive.lead_angle
        return self.axial_contact_force(u, w, law) / (math.cos(lead) + friction * math.sin(lead))

    def powers(self, u, w, law):
        """Powers [W] of motor, axial force, dampings and friction; shape (4, ...)."""
        d, speed = self.drive, self.drive.input_speed + w
        motor = -d.coupling_stiffness * (self.z0 + u) * d.input_speed
        load = d.axial_force * self.p * speed
        damping = -(d.support_damping + d.translation_damping * self.p**2) * speed**2
        if law == 0:
            return np.stack([motor, load, damping, 0 * motor])
        sliding = d.pitch_radius * np.abs(speed) / math.cos(d.lead_angle)
        return np.stack(
            [motor, load, damping, -d.friction_coefficient * np.abs(self.normal_force(u, w, law)) * sliding]
        )


def integrals(motion, function):
    """∫ function(u, w, law) dt over every arc, shape (arcs, ...)."""
    flow = motion.automaton.tables.flow
    sums = []
    for mode, start, _, duration in zip(*motion.arcs(), strict=True):
        row = flow[mode]
        rate = abs(row[layout.ALPHA]) + row[layout.BETA] + row[layout.DELTA]
        pieces = max(1, math.ceil(rate * duration))
        times = (np.arange(pieces)[:, None] + 0.5 * (NODES + 1)) / pieces * duration
        states = np.empty((times.size, 2))
        for time, state in zip(times.ravel(), states, strict=True):
            flow_planar.advance(flow, mode, start, time, state)
        values = function(states[:, 0], states[:, 1], LAWS[MotionMode(int(motion.automaton.codes[mode]))])
        sums.append(values @ np.tile(0.5 * WEIGHTS, pieces) / pieces * duration)
    return np.array(sums)


@settings(max_examples=300)
@given(drives(), starts(), st.sampled_from(RULES), st.floats(1e-3, 0.1))
def test_mirror_symmetry_is_exact(drive, start, rule, t_end):
    """(u, w, R, Ω) → −(u, w, R, Ω): the same bits with the other sign, for every operation is odd or even."""
    motion = follow(rigid_automaton(drive, resume=rule), start, t_end, max_events=500)
    mirrored = drive.replace(axial_force=-drive.axial_force, input_speed=-drive.input_speed)
    image = follow(rigid_automaton(mirrored, resume=rule), (-start[0], -start[1]), t_end, max_events=500)
    for name in ("time", "kind"):
        np.testing.assert_array_equal(getattr(image, name), getattr(motion, name))
    for name in ("sign", "before", "after", "end_state"):
        np.testing.assert_array_equal(getattr(image, name), -getattr(motion, name))
    names = [[MotionMode(int(m.automaton.codes[i])).name for i in m.mode] for m in (motion, image)]
    opposite = {"FORWARD": "BACKWARD", "BACKWARD": "FORWARD", "POSITIVE": "NEGATIVE", "NEGATIVE": "POSITIVE"}
    assert names[1] == ["_".join(opposite.get(word, word) for word in name.split("_")) for name in names[0]]


@settings(max_examples=200)
@given(drives(), starts(), st.sampled_from(RULES), st.floats(1e-3, 0.05))
def test_energy_balance_on_every_arc(drive, start, rule, t_end):
    mechanics = Mechanics(drive)
    motion = follow(rigid_automaton(drive, resume=rule), start, t_end, max_events=100)
    modes, starts_, ends, durations = motion.arcs()
    works = integrals(motion, mechanics.powers)
    for k in range(len(modes)):
        before, after = mechanics.energy(*starts_[k]), mechanics.energy(*ends[k])
        size = before + after + np.abs(works[k]).sum() + 0.5 * drive.coupling_stiffness * mechanics.z0**2
        # The duration is a difference of event times, rounded to eps of the clock: it moves the work by 1e-16 s times
        # the power, which is below the rounding of the energies.
        assert abs(after - before - works[k].sum()) <= TOLERANCE * size, (k, durations[k])
    # Between two arcs energy is lost in seizures only.
    lost = np.array(
        [mechanics.energy(*b) - mechanics.energy(*a) for b, a in zip(motion.before, motion.after, strict=True)]
    )
    seized = motion.kind == Event.SEIZURE
    assert (np.abs(lost[~seized]) <= 1e-14 * mechanics.energy(*motion.before[~seized].T)).all()
    assert (lost[seized] >= 0).all()


@settings(max_examples=100)
@given(drives(), starts(), st.floats(1e-3, 0.05))
def test_seizure_loses_what_the_impact_consumes(drive, start, t_end):
    """½ (I + m p²) v² = ½ J_F v_s: the tangential impulse times the mean speed of sliding, with

    m p v = J_N cos λ + J_F sin λ and I v = r_m (J_F cos λ − J_N sin λ), the momenta that nut and screw lose.
    """
    mechanics = Mechanics(drive)
    motion = follow(rigid_automaton(drive), start, t_end, max_events=100)
    sine, cosine = math.sin(drive.lead_angle), math.cos(drive.lead_angle)
    for k in np.flatnonzero(motion.kind == Event.SEIZURE):
        v = drive.input_speed + motion.before[k, 1]
        matrix = np.array([[cosine, sine], [-drive.pitch_radius * sine, drive.pitch_radius * cosine]])
        normal, tangential = np.linalg.solve(matrix, [drive.mass * mechanics.p * v, drive.screw_inertia * v])
        lost = mechanics.energy(*motion.before[k]) - mechanics.energy(*motion.after[k])
        consumed = 0.5 * tangential * drive.pitch_radius * v / cosine
        # Rounding of the energies, of which the loss may be a small part.
        assert lost == pytest.approx(consumed, rel=1e-12, abs=1e-14 * mechanics.energy(*motion.before[k]))
        assert normal == pytest.approx(float(seizure_impulses(drive, v).normal), rel=1e-12)
        assert np.sign(normal) == motion.sign[k] == np.sign(v)


@settings(max_examples=100)
@given(drives(), starts(), st.sampled_from(RULES), st.floats(1e-3, 0.05))
def test_axial_momentum_balance(drive, start, rule, t_end):
    """∫ N (cos λ + μ_s sin λ) dt + impulses of seizures = ∫ (R − c_x x′) dt − m Δx′."""
    mechanics = Mechanics(drive)
    motion = follow(rigid_automaton(drive, resume=rule), start, t_end, max_events=100)
    automaton = motion.automaton
    carried = integrals(motion, mechanics.axial_contact_force).sum()
    speeds = drive.input_speed + motion.before[motion.kind == Event.SEIZURE, 1]
    impulses = float(np.sum(seizure_impulses(drive, speeds).axial))
    _, starts_, ends, durations = motion.arcs()
    turned = float(np.sum(ends[:, 0] - starts_[:, 0])) + drive.input_speed * float(durations.sum())
    pushed = drive.axial_force * float(durations.sum()) - drive.translation_damping * mechanics.p * turned
    gained = drive.mass * mechanics.p * float(ends[-1, 1] - starts_[0, 1])
    size = np.abs(integrals(motion, lambda *x: np.abs(mechanics.axial_contact_force(*x)))).sum()
    size += abs(impulses) + abs(drive.axial_force) * motion.end_time + abs(gained)
    assert abs(carried + impulses - (pushed - gained)) <= TOLERANCE * size
    # The same force from the model's own contact force N.
    samples, modes = motion.at(np.linspace(0, motion.end_time, 50))
    forces = automaton.observe("normal_force", samples, modes)
    for state, mode, force in zip(samples, modes, forces, strict=True):
        law = LAWS[MotionMode(int(automaton.codes[mode]))]
        if law:
            expected = mechanics.normal_force(*state, law)
            assert force == pytest.approx(expected, rel=TOLERANCE, abs=TOLERANCE * abs(drive.axial_force))
