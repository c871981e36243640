"""Stick–slip of the rigid drive under a static friction above that of sliding, against its closed form.

With y = z − z_e, the deviation from steady sliding in the one law s that the slip follows,

    slip    Γ_s y″ + C_s y′ + k y = 0 from y_0, y′ = −Ω (θ′ = 0, the torque −k z at the end of the static band)
            to y_1, where y′ = −Ω again,
    rest    y falls from y_1 to y_0 at the rate Ω,

so that the period is t_1 + (y_1 − y_0) / Ω. The two ends of the swing are where y′ = 0. All numbers by mpmath, from the
parameters.
"""

import numpy as np
import pytest
from mpmath import mp, mpf

import lsvib
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.models.names import Event
from lsvib.models.rigid import rigid_automaton

DRIVES = 20


class ClosedForm:
    """Period [s] and amplitude [rad] of the stick–slip of a drive whose contact force keeps its sign."""

    def __init__(self, drive):
        q = {name: mpf(value) for name, value in drive.model_dump().items() if value is not None}
        r, tan, m = q["pitch_radius"], mp.tan(q["lead_angle"]), q["mass"]
        self.Omega, R, k = q["input_speed"], q["axial_force"], q["coupling_stiffness"]
        s = mp.sign(self.Omega * R)

        def xi(law, mu):
            return (law * mu - tan) / (1 + law * mu * tan)

        slide = xi(s, q["friction_coefficient"])
        Gamma = q["screw_inertia"] - slide * tan * m * r**2
        C = q["support_damping"] - slide * tan * q["translation_damping"] * r**2
        # The torque that sets the screw going is that of static friction against the slip, which goes with Ω.
        self.y_0 = (C * self.Omega + r * slide * R - r * xi(s, q["static_friction_coefficient"]) * R) / k
        self.alpha = C / (2 * Gamma)
        self.beta = mp.sqrt(k / Gamma - self.alpha**2)
        self.B = (-self.Omega + self.alpha * self.y_0) / self.beta

    def y(self, t):
        phase = self.beta * t
        return mp.exp(-self.alpha * t) * (self.y_0 * mp.cos(phase) + self.B * mp.sin(phase))

    def rate(self, t):
        phase, a, b = self.beta * t, self.alpha, self.beta
        return mp.exp(-a * t) * (
            (b * self.B - a * self.y_0) * mp.cos(phase) - (b * self.y_0 + a * self.B) * mp.sin(phase)
        )

    def solve(self):
        """Return period and amplitude, None if the slip does not come back to rest within a turn."""
        turn = 2 * mp.pi / self.beta
        grid = [turn * j / 400 for j in range(1, 401)]
        above = [(self.rate(t) + self.Omega) * mp.sign(self.Omega) > 0 for t in grid]  # the screw turns with Ω
        if all(above) or not above[0]:
            return None
        last = above.index(False)
        t_1 = mp.findroot(lambda t: self.rate(t) + self.Omega, (grid[last - 1], grid[last]), solver="anderson")
        turning = mp.atan2(self.beta * self.B - self.alpha * self.y_0, self.beta * self.y_0 + self.alpha * self.B)
        ends = [
            self.y((turning + j * mp.pi) / self.beta) for j in range(-2, 5) if 0 < turning + j * mp.pi < self.beta * t_1
        ]
        period = t_1 + (self.y(t_1) - self.y_0) / self.Omega
        return period, (max(ends) - min(ends)) / 2


def drives():
    """Random drives that the closed form says to stick and slip, turning and loaded either way."""
    rng = np.random.default_rng(20261126)
    while True:
        friction = rng.uniform(0.1, 0.25) if rng.random() < 0.7 else 0.218
        yield lsvib.Drive.of(
            friction_coefficient=friction,
            static_friction_coefficient=friction * rng.uniform(1.1, 2.0),
            mass=rng.uniform(0.3, 4.0),
            support_damping=10 ** rng.uniform(-5.0, -3.7),
            translation_damping=rng.choice([0.0, rng.uniform(1.0, 50.0)]),
            axial_force=rng.choice([-1, 1]) * rng.uniform(20.0, 150.0),
            input_speed=rng.choice([-1, 1]) * rng.uniform(2.0, 30.0),
        )


def test_period_and_amplitude():
    signs, one_sign = set(), 0
    with mp.workdps(40):
        for drive in drives():
            expected = ClosedForm(drive).solve()
            if expected is None:
                continue
            found = steady_state(rigid_automaton(drive), [0.2, 0.0])
            kinds = {Event(kind).name for kind in found.orbit.kind} if found.orbit else set()
            if kinds - {"STICK", "RELEASE", "GRAZE"}:
                continue  # the contact force changes its sign, and with it the law
            assert found.label == Attractor.STICK_SLIP_CYCLE, drive
            period, amplitude = expected
            assert abs(found.period - period) <= 1e-12 * period, drive
            assert abs(found.amplitude - amplitude) <= 1e-12 * amplitude, drive
            assert found.multiplier == pytest.approx(0.0, abs=1e-9)
            signs.add((drive.input_speed > 0, drive.axial_force > 0))
            one_sign += 1
            if one_sign == DRIVES:
                break
    assert len(signs) == 4
