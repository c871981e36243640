"""A drive with a second body: what its screw, coupling and threads have in common, and what each model adds."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from enum import IntEnum

from flint import arb

from lsvib.engine.automaton import Row, scaled
from lsvib.engine.exact.arithmetic import sign
from lsvib.engine.exact.field import SWINGS
from lsvib.models import mechanics
from lsvib.models.drive import NutDrive, SupportDrive
from lsvib.models.two_bodies import Solution, normal_force


class TwoBodies(ABC):
    """Constants of a drive and rows over its state (u, w, and two of the second body) and 1, as balls.

    In steady sliding the threads carry the force ``force`` = R − r_m tan λ c_x Ω − F_0 sgn Ω [N] with the torque
    ``twist`` = r_m ξ_s0 · force [N m] (eq. 8.15). ``reach``: r_m tan λ; ``xi``: ξ_s by law; ``turned``: ξ₊ tan λ r_m²;
    ``turning``: sgn Ω; ``horizon`` [s]: that of :func:`lsvib.engine.exact.field.reached`; ``movable``: the
    parameter to change where rates coincide; ``speed``: row of θ′; ``deflection``: row of z.

    A model names its ``states``, ``modes``, ``events``, and the ``second`` body with the coordinates ``snaps`` that are
    moved to put the speeds ``slip`` and ``sliding`` on zero. It sets the attributes that are only declared here: the
    typical ``sizes`` of the state, the rows of ``slip``, ``sliding`` and ``nut_speed`` (of the nut against the ground
    [m/s]), the rows of the reset of a seizure, ``impact``, whether the second body has friction, ``limited``, and its
    size, ``limit``, whether Γ₊ ≤ 0, ``paradox``, and whether n may pass zero at rest, ``turns_over``.
    """

    states: tuple[str, ...]
    modes: type[IntEnum]
    events: type[IntEnum]
    second: str
    snaps: tuple[int, int]
    sizes: tuple[float, ...]
    slip: Row
    sliding: Row
    nut_speed: Row
    impact: tuple[Row, ...]
    limited: bool
    limit: arb
    paradox: bool
    turns_over: bool

    def __init__(self, drive: SupportDrive | NutDrive, slide: bool, bearing: bool) -> None:
        self.d, self.movable = drive.exact(), drive.own_damping
        d = self.d
        self.slide, self.bearing = d.slide_friction * slide, d.bearing_friction * bearing
        self.slides, self.bears = slide and drive.slide_friction > 0, bearing and drive.bearing_friction > 0
        self.reach = d.pitch_radius * d.tan_lead
        self.xi = {s: mechanics.friction_factor(d.friction_coefficient, d.tan_lead, s) for s in (1, -1)}
        self.turned = self.xi[1] * self.reach * d.pitch_radius
        self.turning = sign(d.input_speed)
        self.force = d.axial_force - self.reach * d.translation_damping * d.input_speed - self.slide * self.turning
        self.twist = (
            d.pitch_radius * self.xi[-1 if sign(self.force * self.turning, "axial_force") < 0 else 1] * self.force
        )
        torque = d.support_damping * d.input_speed + self.bearing * self.turning + self.twist
        self.horizon = SWINGS * math.sqrt(float(d.screw_inertia / d.coupling_stiffness))
        self.deflection = (1, 0, 0, 0, -torque / d.coupling_stiffness)
        self.speed = (0, 1, 0, 0, d.input_speed)

    @abstractmethod
    def solve(self, direction: int, law: int, way: int) -> Solution:
        """Solve Newton's laws for slip in a direction (0: rest) under a law, the second body moving one ``way``."""

    @abstractmethod
    def holds(self, way: int) -> Mapping[int, Mapping[int, Row]]:
        """Return the rows that are positive while static friction keeps the threads from slipping in a direction.

        By the side of rest, a sign of n or 0 alone if that does not matter, and by direction.
        """

    @abstractmethod
    def released(self, direction: int, side: int) -> int:
        """Return the sign of n with which slip begins at the end of static mechanics."""

    @abstractmethod
    def tied(self, slip: bool, second: bool) -> tuple[Row, ...]:
        """Return the rows of the reset that sets the named speeds to exactly zero."""

    def observables(self, solution: Solution) -> dict[str, tuple]:
        """Rows of the observables in one mode: forces [N], torque [N m], angle [rad], speeds [rad/s] and [m/s]."""
        return {
            "normal_force": normal_force(self.d, solution),
            "axial_contact_force": solution.contact,
            "coupling_torque": scaled(self.deflection, -self.d.coupling_stiffness),
            "coupling_deflection": self.deflection,
            "screw_speed": self.speed,
            "nut_speed": self.nut_speed,
        }
