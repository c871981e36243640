r"""Efficiency, self-locking and friction that depends on speed, for threads with flanks at an angle.

A flank with half angle α in an axial section has the angle α_n in the section normal to the thread, tan α_n = cos λ
tan α. It carries the normal force N / cos α_n where a square thread carries N, so that the thread behaves as a square
one with the coefficient μ / cos α_n; that is the μ of all equations of the package (Sect. 5.3).

Functions are plain arithmetic for floats, complex numbers and arrays.
"""

import numpy as np

from lsvib.models.mechanics import friction_factor


def square_coefficient(coefficient, lead_angle, half_angle):
    """Return the coefficient of the square thread that behaves alike, μ / cos α_n [1]; angles λ and α [rad]."""
    return coefficient * np.sqrt(1 + (np.cos(lead_angle) * np.tan(half_angle)) ** 2)


def flank_coefficient(coefficient, lead_angle, half_angle):
    """Return the coefficient of the flank [1] from that of the square thread, the inverse of the function above."""
    return coefficient / np.sqrt(1 + (np.cos(lead_angle) * np.tan(half_angle)) ** 2)


def lifting_efficiency(coefficient, lead_angle):
    """Return η = tan λ / tan(λ + arctan μ) = −tan λ / ξ₋ [1] of motion against the load, μ of the square thread."""
    tangent = np.tan(lead_angle)
    return -tangent / friction_factor(coefficient, tangent, -1)


def lowering_efficiency(coefficient, lead_angle):
    """Return η = tan(λ − arctan μ) / tan λ = −ξ₊ / tan λ [1] of motion with the load; negative if self-locking."""
    tangent = np.tan(lead_angle)
    return -friction_factor(coefficient, tangent, 1) / tangent


def coefficient_from_efficiency(efficiency, lead_angle):
    """Return the μ of the square thread at which the lifting efficiency is ``efficiency``, tan(arctan(t/η) − λ)."""
    tangent = np.tan(lead_angle)
    return tangent * (1 - efficiency) / (efficiency + tangent**2)


def sliding_speed(speed, pitch_radius, lead_angle):
    """Return the speed at which the threads slide, r_m Ω / cos λ [m/s]."""
    return pitch_radius * speed / np.cos(lead_angle)


def damping_by_slope(slope, force, coefficient, pitch_radius, lead_angle, law):
    """Damping that a friction coefficient adds which depends on the sliding speed v [N m s/rad].

    With μ(v) = μ + μ′ (v − v₀) the torque of the threads r_m ξ_s n, n = R̃ in steady sliding, changes with θ′ at the
    rate

        |R̃| r_m² μ′ / [cos³ λ (1 + s μ tan λ)²],

    because dξ_s/dμ = s (1 + tan² λ) / (1 + s μ tan λ)², dv/d|θ′| = r_m / cos λ and s = sgn(R̃ Ω). It is added to the
    effective damping C_s; steady sliding with Γ_s > 0 loses its stability where the sum passes zero.

    Arguments: ``slope`` μ′ of the square thread [s/m]; ``force`` |R̃| [N]; the others as in the package.
    """
    return (
        slope * force * pitch_radius**2 / (np.cos(lead_angle) ** 3 * (1 + law * coefficient * np.tan(lead_angle)) ** 2)
    )
