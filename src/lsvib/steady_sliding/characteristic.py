"""Characteristic polynomials of steady sliding in exact rational numbers, one form for the rigid drive and all others.

With t = tan λ, g = 1 + s_0 μ t, h = r_m² t (s_0 μ − t), the screw A = I s² + c s + k and the translating mass
B = m s² + c_x s, the polynomial of the rigid drive (8.13) is D = g A − h B = g (Γ_0 s² + C_0 s + k). The others are

    threads   (1 + t²) A B + (k_c + c_c s) D
    support   g A B + (m_1 s² + c_1 s + k_1) D
    nut      −h A B + (I_2 s² + c_2 s + k_2) D

Each is det(M s² + C s + K) of :mod:`lsvib.steady_sliding.linearised` times a positive factor, g or 1 + t². The
coefficients are linear in every parameter except r_m and λ, and nothing cancels in them but what the physics subtracts.

A double is a rational number and t is transcendental for every double λ > 0 (Lindemann), so a polynomial in t with
rational coefficients vanishes only if it vanishes for every t. A sign is therefore certain if it is the same at both
ends of a narrow enclosure of t: zero at both ends means zero identically, and otherwise more digits separate them.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import mpmath

from lsvib.drives.parameters import NutParameters, RigidParameters, SupportParameters, ThreadsParameters
from lsvib.errors import InputError

Polynomial = tuple[Fraction, ...]  # highest power first

DIGITS = 100  # of tan λ at first: enough unless a condition vanishes to some 80 digits, which calls for four times more


def polynomial(kind: type[RigidParameters], values: Mapping[str, Fraction], law: int, tan_lead: Fraction) -> Polynomial:
    """Return the coefficients of the characteristic polynomial, times g or 1 + t², highest power first (SI units).

    Arguments: class of the drive; its parameters as rationals; law s = ±1; tan λ as a rational.
    """
    p, t = values, tan_lead
    friction = law * p["friction_coefficient"]
    g, h = 1 + friction * t, p["pitch_radius"] ** 2 * t * (friction - t)
    screw = (p["screw_inertia"], p["support_damping"], p["coupling_stiffness"])
    slide = (p["mass"], p["translation_damping"], Fraction(0))
    rigid = tuple(g * a - h * b for a, b in zip(screw, slide, strict=True))
    if kind is RigidParameters:
        return rigid
    if kind is ThreadsParameters:
        factor, other = 1 + t**2, (Fraction(0), p["contact_damping"], p["contact_stiffness"])
    elif kind is SupportParameters:
        factor, other = g, (p["screw_mass"], p["axial_support_damping"], p["support_stiffness"])
    elif kind is NutParameters:
        factor, other = -h, (p["nut_inertia"], p["nut_damping"], p["nut_stiffness"])
    else:
        raise TypeError(f"{kind.__name__} has no characteristic polynomial.")
    free, tied = multiplied(screw, slide), multiplied(other, rigid)
    return tuple(factor * a + b for a, b in zip(free, tied, strict=True))


def rationals(drive: RigidParameters) -> dict[str, Fraction]:
    """Return the parameters of a drive as exact rationals."""
    return {key: Fraction(value) for key, value in drive}


def tangents(drive: RigidParameters, digits: int) -> tuple[Fraction, Fraction]:
    """Return rationals just below and just above tan λ, a relative 10^−digits apart from it."""
    with mpmath.workdps(digits + 10):
        tangent = mpmath.tan(mpmath.mpf(drive.lead_angle))
        ends = tangent * (1 - mpmath.mpf(10) ** -digits), tangent * (1 + mpmath.mpf(10) ** -digits)
        low, high = (Fraction(int(end.man)) * Fraction(2) ** int(end.exp) for end in ends)
    return low, high


def settled(drive: RigidParameters, law: int, judge: Callable[[Polynomial], Any]) -> tuple[Any, Polynomial]:
    """Return what ``judge`` says of the polynomial, the same at both ends of an enclosure of tan λ, and the polynomial.

    ``judge`` must depend on signs of polynomials of the coefficients alone, so that digits enough always decide. Raises
    ``InputError`` where μ is below cot λ only by the rounding of cot λ to a double.
    """
    values, digits = rationals(drive), DIGITS
    if values["friction_coefficient"] * tangents(drive, digits)[1] >= 1:
        raise InputError(f"friction_coefficient = {drive.friction_coefficient!r} is not below cot(lead_angle).")
    while True:
        low, high = (polynomial(type(drive), values, law, t) for t in tangents(drive, digits))
        if (verdict := judge(low)) == judge(high):
            return verdict, low
        digits *= 4


def scale(drive: RigidParameters, law: int) -> Fraction:
    """Return the positive factor, g or 1 + t², by which :func:`polynomial` exceeds det(M s² + C s + K)."""
    t = tangents(drive, DIGITS)[0]
    return 1 + t**2 if isinstance(drive, ThreadsParameters) else 1 + law * Fraction(drive.friction_coefficient) * t


def multiplied(a: Polynomial, b: Polynomial) -> Polynomial:
    """Product of two polynomials."""
    product = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            product[i + j] += x * y
    return tuple(product)


def hurwitz(p: Polynomial) -> Fraction:
    """Hurwitz determinant (p_3 p_2 − p_4 p_1) p_1 − p_3² p_0 of a quartic; zero where s and −s are both roots."""
    p_4, p_3, p_2, p_1, p_0 = p
    return (p_3 * p_2 - p_4 * p_1) * p_1 - p_3**2 * p_0
