"""Characteristic polynomials of steady sliding in exact rational numbers, for the rigid drive and all others.

Each model states its own (:mod:`lsvib.models.mechanics` has the parts that all are made of). It is
det(M s² + C s + K) of :mod:`lsvib.stability.linear` times a positive factor, g = 1 + s_0 μ tan λ or, with
compliant threads, 1 + tan² λ. The coefficients are linear in every parameter except r_m and λ, and nothing cancels in
them but what the physics subtracts.

A double is a rational number and t is transcendental for every double λ > 0 (Lindemann), so a polynomial in t with
rational coefficients vanishes only if it vanishes for every t. A sign is therefore certain if it is the same at both
ends of a narrow enclosure of t: zero at both ends means zero identically, and otherwise more digits separate them.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import mpmath

from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.models.mechanics import LinearParts, Polynomial
from lsvib.models.model import find_model

DIGITS = 100  # of tan λ at first; a condition that vanishes to some 80 digits calls for four times as many


def polynomial(kind: type[Drive], values: Mapping[str, Fraction], law: int, tan_lead: Fraction) -> Polynomial:
    """Return the coefficients of the characteristic polynomial, times :func:`scale`, highest power first (SI units).

    Arguments: class of the drive; its parameters as rationals; law s = ±1; tan λ as a rational.
    """
    return find_model(kind.model).characteristic(values, LinearParts.of(values, law, tan_lead))


def rationals(drive: Drive) -> dict[str, Fraction]:
    """Return the parameters of a drive as exact rationals."""
    return {key: Fraction(value) for key, value in drive}


def tangents(drive: Drive, digits: int) -> tuple[Fraction, Fraction]:
    """Return rationals just below and just above tan λ, a relative 10^−digits apart from it."""
    with mpmath.workdps(digits + 10):
        tangent = mpmath.tan(mpmath.mpf(drive.lead_angle))
        ends = tangent * (1 - mpmath.mpf(10) ** -digits), tangent * (1 + mpmath.mpf(10) ** -digits)
        low, high = (Fraction(int(end.man)) * Fraction(2) ** int(end.exp) for end in ends)
    return low, high


def settled(drive: Drive, law: int, judge: Callable[[Polynomial], Any]) -> tuple[Any, Polynomial]:
    """Return what ``judge`` says of the polynomial, the same at both ends of an enclosure of tan λ, and the polynomial.

    ``judge`` must depend on signs of polynomials of the coefficients alone, so that enough digits always decide. Raises
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


def scale(drive: Drive, law: int) -> Fraction:
    """Return the positive factor by which :func:`polynomial` exceeds det(M s² + C s + K)."""
    parts = LinearParts.of(rationals(drive), law, tangents(drive, DIGITS)[0])
    factor: Fraction = find_model(drive.model).excess(parts)
    return factor


def hurwitz(p: Polynomial) -> Fraction:
    """Hurwitz determinant (p_3 p_2 − p_4 p_1) p_1 − p_3² p_0 of a quartic; zero where s and −s are both roots."""
    p_4, p_3, p_2, p_1, p_0 = p
    return (p_3 * p_2 - p_4 * p_1) * p_1 - p_3**2 * p_0
