"""What the drives with a second body have in common: the screw, its coupling, and the steady sliding to start from."""

from lsvib.drives import friction
from lsvib.drives.parameters import NutParameters, SupportParameters
from lsvib.drives.second_body.mechanics import Solution, normal_force
from lsvib.engine.automaton import Row, scaled


class Screw:
    """Constants of a drive and rows over its state (u, w, and two of the second body) and 1, to 50 digits.

    In steady sliding the threads carry the force ``force`` = R − r_m tan λ c_x Ω − F_0 sgn Ω [N] with the torque
    ``twist`` = r_m ξ_s0 · force [N m] (eq. 8.15). ``reach``: r_m tan λ; ``xi``: ξ_s by law; ``turned``: ξ₊ tan λ r_m²;
    ``turning``: sgn Ω; ``speed``: row of θ′; ``deflection``: row of z.
    """

    nut_speed: Row  # of the nut against the ground [m/s]

    def __init__(self, drive: SupportParameters | NutParameters, slide: bool, bearing: bool) -> None:
        self.d = d = drive.exact()
        self.slide, self.bearing = d.slide_friction * slide, d.bearing_friction * bearing
        self.reach = d.pitch_radius * d.tan_lead
        self.xi = {s: friction.friction_factor(d.friction_coefficient, d.tan_lead, s) for s in (1, -1)}
        self.turned = self.xi[1] * self.reach * d.pitch_radius
        self.turning = 1 if d.input_speed > 0 else -1
        self.force = d.axial_force - self.reach * d.translation_damping * d.input_speed - self.slide * self.turning
        self.twist = d.pitch_radius * self.xi[-1 if self.force * self.turning < 0 else 1] * self.force
        torque = d.support_damping * d.input_speed + self.bearing * self.turning + self.twist
        self.deflection = (1, 0, 0, 0, -torque / d.coupling_stiffness)
        self.speed = (0, 1, 0, 0, d.input_speed)

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
