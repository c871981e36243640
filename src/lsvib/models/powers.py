"""The powers of a drive as quadratic forms of (x, 1), mode by mode; a model adds to them what its bodies do.

A row is an affine function of the state: coefficients over x, then the constant. The product of two rows is a
symmetric form over (x, 1), whose integral along a motion :mod:`lsvib.dynamics.energy` knows in closed form.
"""

import math
from collections.abc import Iterator

import numpy as np

from lsvib.engine.automaton import Automaton
from lsvib.models.drive import Drive


def product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the product of two rows as a symmetric form."""
    return 0.5 * (np.outer(left, right) + np.outer(right, left))


class Powers:
    """Powers of the rigid drive, and what all models share; a model overrides what is different.

    Rows: ``screw``, θ′ [rad/s]; ``nut``, x′ [m/s]; ``slip``, the speed of the threads [rad/s].
    """

    def __init__(self, drive: Drive, automaton: Automaton) -> None:
        self.drive, self.automaton = drive, automaton
        n = len(automaton.states)
        self.one, self.unit = np.eye(n + 1)[-1], np.eye(n + 1)
        self.screw = self.unit[1] + drive.input_speed * self.one
        self.reach = drive.pitch_radius * math.tan(drive.lead_angle)
        self.slip, self.nut = self.screw, self.reach * self.screw
        self.sine, self.cosine = math.sin(drive.lead_angle), math.cos(drive.lead_angle)

    def rows(self, mode: int) -> dict[str, np.ndarray]:
        """Return the rows of the observables in a mode, by name."""
        return {name: table[mode] for name, table in self.automaton.observables.items()}

    def rests(self, mode: int) -> bool:
        """Return whether the threads do not slip in a mode."""
        return bool(self.automaton.codes[mode] in self.automaton.rest_codes)

    def motor(self, mode: int) -> np.ndarray:
        """Return the power [W] that the motor puts in."""
        return self.drive.input_speed * product(self.rows(mode)["coupling_torque"], self.one)

    def load(self) -> np.ndarray:
        """Return the power [W] that the axial force puts in."""
        return self.drive.axial_force * product(self.nut, self.one)

    def damping(self) -> np.ndarray:
        """Return the power [W] that all dampers take out."""
        total = self.drive.support_damping * product(self.screw, self.screw)
        total = total + self.drive.translation_damping * product(self.nut, self.nut)
        for damper, speed in self.dampers():
            total = total + damper * product(speed, speed)
        return total

    def dampers(self) -> Iterator[tuple[float, np.ndarray]]:
        """Yield the dampers that a model adds, each with its coefficient and the row of its speed."""
        yield from ()

    def signed_friction(self, mode: int) -> np.ndarray:
        """Return the power [W] that friction takes out and whose sign changes within a mode; none in most models."""
        return np.zeros_like(self.unit)

    def friction(self, mode: int) -> Iterator[np.ndarray]:
        """Yield powers [W] of friction that keep their sign in a mode; their size is what friction takes out."""
        if not self.rests(mode):
            lever = self.drive.friction_coefficient * self.drive.pitch_radius / self.cosine
            yield lever * product(self.rows(mode)["normal_force"], self.slip)

    def second_energy(self, x: np.ndarray) -> float:
        """Return twice the kinetic energy [J] of the second body at (x, 1); none without one."""
        return 0.0

    def kinetic(self, state: np.ndarray) -> float:
        """Return the kinetic energy [J] at a state."""
        x, d = np.append(state, 1.0), self.drive
        return float(
            0.5 * (d.screw_inertia * (self.screw @ x) ** 2 + d.mass * (self.nut @ x) ** 2) + 0.5 * self.second_energy(x)
        )
