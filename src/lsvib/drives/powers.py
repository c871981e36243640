"""The powers of a drive as quadratic forms of (x, 1), mode by mode."""

import math
from collections.abc import Iterator

import numpy as np

from lsvib.drives.drive import PARTS, Drive
from lsvib.drives.friction import depends_on_speed
from lsvib.drives.names import BODIES, COORDINATES
from lsvib.systems.automaton import Automaton, product


class Powers:
    """The powers of a drive as quadratic forms of (x, 1), mode by mode.

    A row is an affine function of the state: coefficients over x, then the constant. The product of two rows is a
    symmetric form over (x, 1), whose integral along a motion :mod:`lsvib.dynamics.impulses` knows in closed form. Rows:
    ``screw``, θ′ [rad/s]; ``nut``, x′ [m/s]; ``slip``, the speed of the threads [rad/s]; ``rates``, those of the parts
    that are there, by the names of the coordinates; ``rows``, those of observables by name and mode. Under a friction
    law, ``by_speed``, what friction takes out is a pair of forms, the second of which counts η times.
    """

    def __init__(self, drive: Drive, automaton: Automaton) -> None:
        self.drive, self.automaton, self.rows = drive, automaton, automaton.observables
        self.rests = automaton.marked(automaton.codes, "rest")
        unit = np.eye(len(automaton.states) + 1)
        self.one = unit[-1]
        self.rates = dict(zip(automaton.states, unit[:-1], strict=True))
        self.screw = unit[1] + drive.input_speed * self.one
        self.slip = self.screw - self.rates.get("nut_rate", 0)
        self.parting = self.rates.get("mismatch_rate", 0 * self.one)
        reach = drive.pitch_radius * math.tan(drive.lead_angle)
        self.nut = reach * self.slip + self.rates.get("shift_rate", 0) + self.parting
        self.by_speed = depends_on_speed(drive)
        self.sine, self.cosine = math.sin(drive.lead_angle), math.cos(drive.lead_angle)

    def bodies(self) -> Iterator[tuple[str, np.ndarray, str, np.ndarray]]:
        """Yield the inertias of bodies with the rows of their speeds, and their dampers with the speeds of these."""
        yield "screw_inertia", self.screw, "support_damping", self.screw
        yield "mass", self.nut, "translation_damping", self.nut
        for part, body in BODIES.items():
            if part in self.drive.parts:
                (inertia, _, damper), speed = PARTS[part], self.rates[COORDINATES[part][1]]
                faster = speed - self.rates["w"] if body.on == "screw" else speed
                yield inertia, speed + self.drive.input_speed * self.one if body.on else speed, damper, faster

    def motor(self, mode: int) -> np.ndarray:
        """Return the power [W] that the motor puts in."""
        torque = self.rows["coupling_torque"][mode]
        if "motor" in self.drive.parts:
            torque = torque[-1] * self.one  # that of steady sliding
            torque = torque - self.drive.integral_gain * self.rates["motor_angle"]
            torque = torque - self.drive.speed_gain * self.rates["motor_rate"]
        return self.drive.input_speed * product(torque, self.one)

    def load(self) -> np.ndarray:
        """Return the power [W] that the axial force puts in."""
        return self.drive.axial_force * product(self.nut, self.one)

    def damping(self) -> np.ndarray:
        """Return the power [W] that all dampers take out; e′ cos λ compresses that of the contact."""
        dampers = [(getattr(self.drive, damper), speed) for _, _, damper, speed in self.bodies()]
        if self.drive.coupling_damping:
            dampers.append((self.drive.coupling_damping, self.rates["w"] - self.rates["motor_rate"]))
        if self.parting.any():
            dampers.append((self.drive.contact_damping * self.cosine**2, self.parting))
        return np.asarray(sum(damping * product(speed, speed) for damping, speed in dampers))

    def signed_friction(self, mode: int) -> np.ndarray:
        """Return the power [W] that friction takes out and whose sign changes within a mode.

        That is the friction of compliant threads, which acts on the parting of nut and screw as well; at rest static
        friction F = (n − N cos λ) / sin λ moves with the nut.
        """
        if not self.parting.any():
            return 0 * product(self.one, self.one)
        normal = self.rows["normal_force"][mode]
        if self.rests[mode]:
            return product(self.rows["axial_contact_force"][mode] - self.cosine * normal, self.parting)
        sliding = self.drive.pitch_radius / self.cosine * self.slip + self.sine * self.parting
        law = 1 if self.automaton.codes[mode] % 6 in (0, 3) else -1  # forward, n > 0, or backward, n < 0: see codes_of
        return self.rubbed(law * product(normal, sliding))

    def friction(self, mode: int) -> Iterator[np.ndarray]:
        """Yield powers [W] of friction that keep their sign in a mode; their size is what friction takes out."""
        if not (self.parting.any() or self.rests[mode]):
            form = product(self.rows["normal_force"][mode], self.slip)
            yield self.rubbed(self.drive.pitch_radius / self.cosine * form)
        if collar := self.drive.collar_friction * self.drive.collar_radius:
            form = product(self.rows["axial_contact_force"][mode], self.screw)
            if self.by_speed:
                more = product(self.automaton.parts["axial_contact_force"][mode], self.screw)
                form = np.stack([form, more])
            yield collar * form
        for name, speed in (("slide_friction", self.nut), ("bearing_friction", self.screw)):
            if limit := getattr(self.drive, name):
                yield limit * product(speed, self.one)

    def rubbed(self, form: np.ndarray) -> np.ndarray:
        """Return the power of sliding friction from that of the contact force, under a law of that without friction."""
        return np.stack([0 * form, form]) if self.by_speed else self.drive.friction_coefficient * form

    def kinetic(self, state: np.ndarray) -> float:
        """Return the kinetic energy [J] at a state."""
        x = np.append(state, 1.0)
        return float(0.5 * sum(getattr(self.drive, inertia) * (speed @ x) ** 2 for inertia, speed, *_ in self.bodies()))
