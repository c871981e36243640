"""Stability tables and boundaries of random drives of every model, held against Newton's laws in 250 digits."""

import math

import mpmath
import numpy as np
import pytest
from flint import fmpq
from references.newton import DIGITS, eigenvalues, is_stable, steady_law
from references.wide_drives import wide_drive

from lsvib.errors import InputError
from lsvib.models.drive import PARTS, Drive, zero_if_close
from lsvib.stability.boundaries import stable_set
from lsvib.stability.conditions import stability
from lsvib.stability.threshold import all_thresholds

MODELS = ("rigid", "threads", "support", "nut")
NEUTRAL = ("neutral", "centre")
VANISHES = mpmath.mpf(10) ** -60  # a real part below this share of its eigenvalue is zero: doubles come within 1e-40


def judge_stability(model: str, drive: Drive, law: int, tally: dict) -> None:
    """Hold the whole report of the stability of a drive against eigenvalues in 250 digits."""
    report = stability(drive)
    exact = eigenvalues(model, drive, law)
    assert report.steady_law == law
    zero = [abs(mpmath.re(z)) < VANISHES * abs(z) for z in exact]
    growing = [z for z, neutral in zip(exact, zero, strict=True) if not neutral and mpmath.re(z) > 0]
    assert report.stable == (not growing and not any(zero))
    for ours, theirs in zip(report.eigenvalues, _sorted(exact, zero), strict=True):
        assert math.isclose(ours.real, theirs.real, rel_tol=1e-15), (ours, theirs)
        assert math.isclose(ours.imag, theirs.imag, rel_tol=1e-15), (ours, theirs)
        assert (ours.real > 0) - (ours.real < 0) == (theirs.real > 0) - (theirs.real < 0)
    unstable = any(condition.hold for condition in report.conditions.values())
    assert unstable == bool(growing), report
    assert (report.kind in NEUTRAL) == (not growing and any(zero))
    if model != "rigid":
        fastest = max(growing, key=mpmath.re, default=None)
        if report.kind in ("divergence", "flutter"):
            assert (report.kind == "divergence") == (abs(mpmath.im(fastest)) < VANISHES * abs(fastest))
        assert (report.kind == "kinematic_constraint") == (report.characteristic_polynomial[0] < 0)
    tally[report.kind] = tally.get(report.kind, 0) + 1


def _sorted(exact: list, zero: list[bool]) -> list[complex]:
    found = []
    for z, neutral in zip(exact, zero, strict=True):
        real = 0.0 if neutral else float(mpmath.re(z))
        found.append(complex(real, 0.0 if abs(mpmath.im(z)) < VANISHES * abs(z) else float(mpmath.im(z))))
    return sorted(found, key=lambda z: (z.real, z.imag))


def judge_thresholds(model: str, drive: Drive, law: int, random: np.random.Generator, tally: dict) -> None:
    """Hold every boundary against Routh's array on both sides, and the set between them at random places."""
    for key in ("mass", "friction_coefficient", PARTS[drive.parts[0]][-1]):
        found, stable = all_thresholds(drive, key)["onset"], stable_set(drive, key)
        ends = [end for interval in stable.intervals for end in interval if 0 < end < stable.limit]
        assert found.solutions or found.reason.endswith(".")
        values = [float(end) for end in ends if zero_if_close(key, float(end)) == float(end)]
        assert {solution.value for solution in found.solutions} <= set(values)
        lowest, highest = (-6.0, 9.0) if key == "mass" else (-8.0, 12.0)
        places = list(10 ** random.uniform(lowest, highest, 3))
        if key == "friction_coefficient":
            places = [0.0, *random.uniform(0, float(stable.limit), 3)]
        for end in ends:
            for distance in (1e-12, 10 ** random.uniform(-12, -3)):
                places += [float(end) * (1 + distance), float(end) * (1 - distance)]
        for place in places:
            if not (0 if key != "mass" else 1e-18) <= place < float(stable.limit):
                continue
            if zero_if_close(key, place) != place:
                continue
            exact = fmpq(*place.as_integer_ratio())
            inside = stable.from_zero if place == 0 else any(low < exact < high for low, high in stable.intervals)
            at = drive.replace(**{key: place})
            expected = no_growth(model, at, law) if stable.neutral else is_stable(model, at, law)
            assert inside == expected, (key, place, stable, dict(drive))
            tally["places"] = tally.get("places", 0) + 1
        if ends:  # the boundary itself, to rounding
            end = float(ends[random.integers(len(ends))])
            place = [end, math.nextafter(end, 0), math.nextafter(end, math.inf)][random.integers(3)]
            if zero_if_close(key, place) == place:
                judge_stability(model, drive.replace(**{key: place}), law, tally)
        tally[f"{key} {len(ends)}"] = tally.get(f"{key} {len(ends)}", 0) + 1


def no_growth(model: str, drive: Drive, law: int) -> bool:
    return all(abs(mpmath.re(z)) < VANISHES * abs(z) for z in eigenvalues(model, drive, law))


@pytest.mark.parametrize("model", MODELS)
def test_random_drives(model):
    """Twenty drives over the full ranges of their parameters."""
    tally, random = {}, np.random.default_rng(11)
    with mpmath.workdps(DIGITS):
        for index in range(20):
            drive = wide_drive(model, 11, index, 1).drive
            law = steady_law(drive)
            if law == 0:
                with pytest.raises(InputError, match="contact carries no force"):
                    stability(drive)
                continue
            judge_stability(model, drive, law, tally)
            if model != "rigid":
                judge_thresholds(model, drive, law, random, tally)
    print(model, tally)
    assert sum(tally.values()) >= 12
