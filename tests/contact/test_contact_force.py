"""Arcs of the contact force in closed form, against mpmath and Newton's laws, and the outcomes of its motions."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references.parts import threads_drive

from lsvib.contact import contact_force
from lsvib.contact.contact_force import ForceOutcome, Paradox

FLOWS = {
    (damping, paradox): contact_force.contact_flows(
        threads_drive(mass=30.0, contact_stiffness=1e8, contact_damping=damping), paradox
    )
    for damping in (0.0, 5e3, 5e4)  # elastic, underdamped, overdamped
    for paradox in Paradox
}


def exact_path(flow: contact_force.ForceFlow, start) -> tuple:
    """x(τ) of a flow in 40 digits, and its rate, as functions."""
    with mpmath.workdps(40):
        p, q, centre = (mpmath.mpf(v) for v in (flow.damping, flow.stiffness, flow.equilibrium))
        root = mpmath.sqrt(p * p / 4 - q)
        first, second = -p / 2 + root, -p / 2 - root
        u, v = start[0] - centre, mpmath.mpf(start[1])
        a, b = (v - second * u) / (first - second), (first * u - v) / (first - second)
        return (
            lambda t: mpmath.re(centre + a * mpmath.exp(first * t) + b * mpmath.exp(second * t)),
            lambda t: mpmath.re(a * first * mpmath.exp(first * t) + b * second * mpmath.exp(second * t)),
        )


@pytest.mark.parametrize("case", FLOWS, ids=lambda case: f"{case[0]:g}-{case[1].name.lower()}")
def test_crossings_are_the_first_zeros_in_40_digits(case):
    random = np.random.default_rng(1)
    flows, found = FLOWS[case], 0
    unit = abs(flows[-1].equilibrium)
    for _ in range(10):
        for flow in flows.values():
            start = flow.side * unit * random.exponential(3.0), unit * random.normal(0, 3.0)
            time = flow.crossing(start)
            with mpmath.workdps(40):
                place, rate = exact_path(flow, start)
                dense = np.linspace(0, 12.0 if time is None else time * (1 - 1e-9), 100)
                assert all(flow.side * place(mpmath.mpf(t)) > 0 for t in dense)
                if time is None:
                    continue
                found += 1
                # Newton's step from the root found: its error
                step = place(mpmath.mpf(time)) / rate(mpmath.mpf(time))
                size = max(abs(start[0] - flow.equilibrium), abs(start[1])) / abs(float(rate(mpmath.mpf(time))))
                assert abs(step) < 1e-13 * max(time, size)
                after = flow.at(start, time)
                assert abs(after[1] - float(rate(mpmath.mpf(time)))) < 1e-12 * unit * (1 + abs(after[1]) / unit)
    assert found > 3


def test_crossing_times_without_damping_have_a_closed_form():
    """Law −: a circle about 1/Γ₋; law +: the logarithm of the ratio of both amplitudes."""
    flows = FLOWS[0.0, Paradox.INDETERMINATE]
    centre, saddle = flows[-1], flows[1]
    for rate in (1e3, 4e4, 3e5):
        turn = 2 * (math.pi - math.atan(rate / centre.equilibrium))
        assert centre.crossing((0.0, rate)) == pytest.approx(turn, rel=1e-14)
    rho = math.sqrt(-saddle.stiffness)
    for rate in (1e3, 4e4):
        ratio = (-rho * saddle.equilibrium + rate) / (-rho * saddle.equilibrium - rate)
        assert saddle.crossing((0.0, -rate)) == pytest.approx(math.log(ratio) / rho, rel=1e-12)
    assert saddle.crossing((0.0, 1.001 * rho * saddle.equilibrium)) is None


@settings(max_examples=300)
@given(st.floats(-3e5, 3e5), st.floats(-3e5, 3e5))
def test_inconsistent_contact_forces_grow_whatever_the_start(x, rate):
    for damping in (0.0, 5e3, 5e4):
        arcs, outcome = contact_force.follow(FLOWS[damping, Paradox.INCONSISTENT], (x, rate))
        assert outcome is ForceOutcome.PLUS_INFINITY
        assert len(arcs) <= 3
        last = arcs[-1]
        late = last.flow.at(last.start, 30.0 / last.flow.rates()[0].real)
        assert min(late) > 0


@settings(max_examples=150)
@given(st.floats(-3e5, 3e5), st.floats(-3e5, 3e5))
def test_both_outcomes_of_the_indeterminate_case(x, rate):
    """Elastic: the energy decides. Damped: bounded means settling on 1/Γ₋, else |χ| grows on the side of law +."""
    flows = FLOWS[0.0, Paradox.INDETERMINATE]
    saddle, centre = flows[1], flows[-1]
    well = x**2 / 2 if x > 0 else saddle.stiffness * x**2 / 2
    energy = well - x * centre.equilibrium + rate**2 / 2
    top = -saddle.stiffness * saddle.equilibrium**2 / 2
    _, outcome = contact_force.follow(flows, (x, rate))
    if abs(energy - top) > 1e-9 * top:
        assert outcome is (
            ForceOutcome.BOUNDED if energy < top and x > saddle.equilibrium else ForceOutcome.MINUS_INFINITY
        )
    for damping in (5e3, 5e4):
        arcs, outcome = contact_force.follow(FLOWS[damping, Paradox.INDETERMINATE], (x, rate))
        last = arcs[-1]
        late = last.flow.at(last.start, 30.0 / abs(last.flow.rates()[0].real))
        if outcome is ForceOutcome.BOUNDED:
            assert late[0] == pytest.approx(centre.equilibrium, rel=1e-6)
        else:
            assert late[0] < 10 * saddle.equilibrium


def test_contact_flow_is_that_of_newtons_laws():
    """x″ from N″ = cos λ/(m I) [k_c (W − b Γ N) − c_c b Γ N′] with N and N′ in newtons, W of either sign."""
    drive = threads_drive(mass=30.0, contact_stiffness=1e8, contact_damping=5e3)
    sine, cosine = math.sin(drive.lead_angle), math.cos(drive.lead_angle)
    tangent = sine / cosine
    omega = contact_force.contact_frequency(drive)
    for paradox in Paradox:
        w = 2e-3 * paradox
        for law, flow in contact_force.contact_flows(drive, paradox).items():
            b, minus = (cosine + s * drive.friction_coefficient * sine for s in (law, -1))
            factor = (law * drive.friction_coefficient - tangent) / (1 + law * drive.friction_coefficient * tangent)
            gamma = drive.screw_inertia - factor * tangent * drive.mass * drive.pitch_radius**2
            x, rate = flow.side * 4e4, 1.3e4
            force, slope = x * w / minus, rate * omega * w / minus
            assert np.sign(force) == law  # θ′ > 0: law + where N > 0, law − where N < 0
            push = drive.contact_stiffness * (w - b * gamma * force) - drive.contact_damping * b * gamma * slope
            acceleration = cosine / (drive.mass * drive.screw_inertia) * push * minus / (w * omega**2)
            ours = -flow.damping * rate - flow.stiffness * (x - flow.equilibrium)
            assert ours == pytest.approx(acceleration, rel=1e-9)
