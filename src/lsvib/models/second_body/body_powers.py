"""The powers of the drives with a second body: its damper, its kinetic energy, and friction of slide and bearing."""

from collections.abc import Iterator

import numpy as np

from lsvib.models.model import Powers, product


class TwoBodyPowers(Powers):
    """Powers of a drive whose second body moves at the fourth coordinate of the state, the row ``second``.

    ``inertia`` names the parameter that is the mass or the moment of inertia of the second body.
    """

    inertia: str

    @property
    def second(self) -> np.ndarray:
        """Speed of the second body, x_1′ [m/s] or θ_2′ [rad/s]."""
        return self.unit[3]

    def dampers(self) -> Iterator[tuple[float, np.ndarray]]:
        """Yield the damper of the second body."""
        yield getattr(self.drive, self.drive.own_damping), self.second

    def friction(self, mode: int) -> Iterator[np.ndarray]:
        """Yield the powers [W] of the friction of threads, slide (F_0) and bearing (T_0)."""
        yield from super().friction(mode)
        yield self.drive.slide_friction * product(self.nut, self.one)
        yield self.drive.bearing_friction * product(self.screw, self.one)

    def second_energy(self, x: np.ndarray) -> float:
        """Return twice the kinetic energy [J] of the second body at (x, 1)."""
        return float(getattr(self.drive, self.inertia) * (self.second @ x) ** 2)
