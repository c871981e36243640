"""Newton's laws of the models with four states under a friction law, in doubles, with equations of their own.

States are absolute: coupling deflection z = θ − Ω t [rad], θ′ [rad/s], and position and rate of the second body. The
direction of slip, 0 for rest, and the sign of the contact force are given; accelerations and N are solved for.
"""

import math

import numpy as np


def unbounded(drive, speed):
    """Return the sum of the law at a sliding speed [m/s], which may be negative."""
    fade = (speed / drive.stribeck_speed) ** drive.stribeck_exponent if drive.stribeck_rise else 0.0
    return drive.friction_coefficient + drive.stribeck_rise * math.exp(-fade) + drive.friction_slope * speed


def coefficient(drive, speed):
    """Return μ of the law at a sliding speed [m/s]."""
    return max(unbounded(drive, speed), 0.0)


class Laws:
    """A drive's laws: ``steady``, where its coordinates are zero, and the rate of a state with the contact force."""

    def __init__(self, drive):
        self.d, lead = drive, drive.lead_angle
        self.r, self.sin, self.cos = drive.pitch_radius, math.sin(lead), math.cos(lead)
        self.reach = self.r * self.sin / self.cos
        slide, bearing = getattr(drive, "slide_friction", 0.0), getattr(drive, "bearing_friction", 0.0)
        self.slide, self.bearing = slide, bearing
        turning = math.copysign(1, drive.input_speed)
        self.force = drive.axial_force - self.reach * drive.translation_damping * drive.input_speed - slide * turning
        law = math.copysign(1, self.force * turning)
        along, about = self.levers(law, coefficient(drive, self.r * abs(drive.input_speed) / self.cos))
        self.normal = self.force / along
        torque = drive.support_damping * drive.input_speed + bearing * turning + about * self.normal
        self.steady = np.array([-torque / drive.coupling_stiffness, drive.input_speed, *self.second(about)])

    def levers(self, law, mu):
        """Return what N gives along the axis, and about it on the screw."""
        return self.cos + law * mu * self.sin, self.r * (law * mu * self.cos - self.sin)

    def sliding_speed(self, x, direction):
        """Return the sliding speed in the direction of slip [m/s]."""
        return self.r * direction * self.slip(x) / self.cos

    def slip(self, x):
        """Return the speed of the screw in the nut [rad/s]."""
        return x[1]

    def friction(self, speed, law):
        """Return the levers at a speed of the threads in the direction of slip [rad/s]."""
        return self.levers(law, coefficient(self.d, self.r * speed / self.cos))


class ThreadsLaws(Laws):
    """Compliant threads: the second body is the mismatch e, e′, from no compression on."""

    def second(self, about):
        return 0.0, 0.0

    def rate(self, x, direction, force_sign):
        d, (z, turn, e, v) = self.d, x
        normal = self.cos * (d.contact_stiffness * e + d.contact_damping * v)
        if direction:
            along, about = self.friction(direction * turn, direction * force_sign)
            turned = (-d.coupling_stiffness * z - d.support_damping * turn - about * normal) / d.screw_inertia
        else:
            held = (-d.coupling_stiffness * z / self.r + normal * self.sin) / self.cos
            along, turned = self.cos + held * self.sin / normal, 0.0
        nut = (d.axial_force - d.translation_damping * (self.reach * turn + v) - along * normal) / d.mass
        return np.array([turn - d.input_speed, turned, v, nut - self.reach * turned]), normal


class SupportLaws(Laws):
    """Axial support: the second body is the screw along its axis, x_1, x_1′."""

    def second(self, about):
        return self.force / self.d.support_stiffness, 0.0

    def rate(self, x, direction, force_sign):
        d, (z, turn, x1, v1) = self.d, x
        support = d.support_stiffness * x1 + d.axial_support_damping * v1
        push = d.axial_force - d.translation_damping * (self.reach * turn + v1)
        if not direction:
            shift = (push - support) / (d.mass + d.screw_mass)
            return np.array([turn - d.input_speed, 0.0, v1, shift]), math.nan
        along, about = self.friction(direction * turn, direction * force_sign)
        matrix = [[d.screw_inertia, 0, about], [0, d.screw_mass, -along], [d.mass * self.reach, d.mass, along]]
        torque = -d.coupling_stiffness * z - d.support_damping * turn - self.bearing * direction
        turned, shift, normal = np.linalg.solve(matrix, [torque, -support, push])
        return np.array([turn - d.input_speed, turned, v1, shift]), normal


class NutLaws(Laws):
    """Rotating nut: the second body is the nut, θ_2, θ_2′."""

    def slip(self, x):
        return x[1] - x[3]

    def second(self, about):
        return about * self.normal / self.d.nut_stiffness, 0.0

    def rate(self, x, direction, force_sign):
        d, (z, turn, angle, spin) = self.d, x
        torque = -d.coupling_stiffness * z - d.support_damping * turn
        spring = -d.nut_stiffness * angle - d.nut_damping * spin
        if not direction:
            common = (torque + spring) / (d.screw_inertia + d.nut_inertia)
            return np.array([turn - d.input_speed, common, spin, common]), math.nan
        slip = self.slip(x)
        along, about = self.friction(direction * slip, direction * force_sign)
        lever = d.mass * self.reach
        matrix = [[d.screw_inertia, 0, about], [0, d.nut_inertia, -about], [lever, -lever, along]]
        push = d.axial_force - d.translation_damping * self.reach * slip - self.slide * direction
        turned, second, normal = np.linalg.solve(matrix, [torque, spring, push])
        return np.array([turn - d.input_speed, turned, spin, second]), normal


LAWS = {"threads": ThreadsLaws, "support": SupportLaws, "nut": NutLaws}
