"""Stability tables and boundaries of random drives of every model, held against Newton's laws in 250 digits.

The table of docs/lemmas.md, boundaries to the last digit, and what contradicted itself.
"""

import math
import re
from pathlib import Path

import mpmath
import numpy as np
import pytest
from flint import fmpq, fmpq_poly
from hypothesis import given, settings
from hypothesis import strategies as st
from references.drives import DRIVES, MODELS, support_drive, threads_drive, wide_drive
from references.newton import DIGITS, eigenvalues, is_stable, steady_law
from references.threshold_digits import Named

from lsvib import Drive
from lsvib.drives.drive import PARTS, zero_if_close
from lsvib.errors import InputError
from lsvib.stability import spectrum
from lsvib.stability.boundaries import stable_set
from lsvib.stability.conditions import stability
from lsvib.stability.threshold import all_thresholds

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
        ends = [end for interval in stable.intervals for end in interval if 0 < end < stable.limits[-1]]
        assert found.solutions or found.reason.endswith(".")
        values = [float(end) for end in ends if zero_if_close(key, float(end)) == float(end)]
        assert {solution.value for solution in found.solutions} <= set(values)
        lowest, highest = (-6.0, 9.0) if key == "mass" else (-8.0, 12.0)
        places = list(10 ** random.uniform(lowest, highest, 3))
        if key == "friction_coefficient":
            places = [0.0, *random.uniform(0, float(stable.limits[-1]), 3)]
        for end in ends:
            for distance in (1e-12, 10 ** random.uniform(-12, -3)):
                places += [float(end) * (1 + distance), float(end) * (1 - distance)]
        for place in places:
            if not (0 if key != "mass" else 1e-18) <= place < float(stable.limits[-1]):
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


LEMMAS = (Path(__file__).parents[2] / "docs" / "lemmas.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (1e\d+) \| ([\d.]+) \|$", LEMMAS, re.MULTILINE)


def report_of(changes, model="rigid"):
    return stability(DRIVES[model].of(changes))


def onset(model: str, changes, key: str):
    """The onset of a drive in one parameter, which may have no solution."""
    return all_thresholds(DRIVES[model].of(changes), key)["onset"]


@pytest.mark.parametrize(("stiffness", "printed"), ROWS)
def test_table_of_the_least_contact_damping(stiffness, printed):
    changes = {"mass": 9.0, "contact_stiffness": float(stiffness)}
    found = onset("threads", changes, "contact_damping")
    assert f"{found.value:.6g}" == printed
    assert found.stable_intervals == ((found.value, None),)
    low, high = found.enclosure
    assert low <= found.value <= high <= math.nextafter(low, math.inf)
    with mpmath.workdps(60):
        away = mpmath.mpf(10) ** -25  # as a boundary may be a double
        drive = dict(threads_drive(changes))
        ends = [Named({**drive, "contact_damping": end}) for end in (low * (1 - away), high * (1 + away))]
        assert [is_stable("threads", end, 1) for end in ends] == [False, True]


def test_a_set_of_several_intervals_is_reported_in_full():
    """A soft support, undamped: small and large friction are stable, mode coupling lies between."""
    changes = {"mass": 15.0, "support_damping": 0.0, "support_stiffness": 1e7, "friction_coefficient": 0.1}
    found = onset("support", changes, "friction_coefficient")
    ends = [end for interval in found.stable_intervals for end in interval]
    assert found.stability == "neutral"
    assert [solution.value for solution in found.solutions] == [end for end in ends if end]
    middle = [(low + high) / 2 for low, high in found.stable_intervals]
    gaps = [(a + b) / 2 for a, b in zip(ends[1::2], ends[2::2], strict=False)]
    kinds = [report_of({**changes, "friction_coefficient": x}, "support").kind for x in middle + gaps]
    assert kinds == ["neutral"] * len(middle) + ["flutter"] * len(gaps)


def test_a_mode_that_no_damping_reaches_is_neutral():
    """A nut like the screw, damped by the slide alone: both turn together, and nothing slides."""
    changes = {"support_damping": 0.0, "nut_damping": 0.0, "translation_damping": 3.0, "friction_coefficient": 0.05}
    report = report_of(changes, "nut")
    assert (report.stable, report.kind) == (False, "neutral")
    rate = math.sqrt(1.0 / 3.12e-6)
    assert [value.real for value in report.eigenvalues][-2:] == [0.0, 0.0]
    assert report.eigenvalues[-1].imag == pytest.approx(rate, rel=1e-14)
    never = onset("nut", changes, "mass")
    assert (never.value, never.stable_intervals) == (None, ())
    assert never.reason == "steady sliding is not asymptotically stable for any mass, with all other parameters fixed."
    assert report_of({**changes, "friction_coefficient": 0.5}, "nut").kind == "flutter"
    least = onset("nut", changes, "nut_damping")
    assert least.value is None
    assert least.reason.endswith("stable for every nut damping above zero, but not at zero.")


KNOWN = [
    ("rigid", {"support_damping": 0.0}, "centre"),
    ("rigid", {"support_damping": 0.0, "friction_coefficient": math.tan(math.radians(5.57))}, "centre"),
    ("rigid", {"support_damping": 0.0, "mass": 11.0}, "saddle"),
    ("threads", {"mass": 9.0}, "stable"),
    ("threads", {"mass": 11.0}, "divergence"),
    ("threads", {"mass": 9.0, "contact_damping": 0.0}, "flutter"),
    ("threads", {"mass": 9.0, "contact_stiffness": 1e8, "contact_damping": 5e4}, "flutter"),
    ("support", {"mass": 15.0, "support_damping": 0.0}, "neutral"),
    ("support", {"mass": 15.0, "support_damping": 0.0, "support_stiffness": 1e7}, "flutter"),
    ("support", {"mass": 15.0, "support_damping": 0.0, "support_stiffness": 1e9, "friction_coefficient": 0.25},
     "divergence"),
    ("support", {"mass": 15.0, "friction_coefficient": 0.3}, "kinematic_constraint"),
    ("nut", {"mass": 5.0}, "stable"),
    ("nut", {"mass": 5.1}, "kinematic_constraint"),
]  # fmt: skip


@pytest.mark.parametrize(("model", "changes", "kind"), KNOWN)
def test_classes_of_known_drives(model, changes, kind):
    drive, tally = DRIVES[model].of(changes), {}
    with mpmath.workdps(DIGITS):
        judge_stability(model, drive, steady_law(drive), tally)
    assert tally == {kind: 1}


@settings(max_examples=200)
@given(st.lists(st.integers(-400, 400), min_size=1, max_size=4), st.integers(-20, 20))
def test_positive_roots_of_known_polynomials(halves, power):
    """Roots n/2 · 10^power, repeated ones and zero among them."""
    size = fmpq(10) ** power
    polynomial = fmpq_poly([3])
    for half in halves:
        polynomial *= fmpq_poly([-fmpq(half, 2) * size, 1])
    found = spectrum.positive_roots(polynomial, 1000 * size)
    assert [float(x) for x in found] == [float(fmpq(half, 2) * size) for half in sorted({h for h in halves if h > 0})]


@pytest.mark.parametrize(
    ("support", "threads", "friction"),
    [(3e5, {}, 0.285), (3e5, (1e8, 1e4), 0.235), (3e5, (1e7, 1e3), 0.154), (1e9, {}, 0.109), (1e9, (1e8, 1e4), 0.144)],
)
def test_what_compliant_threads_change_in_a_drive_with_axial_support(support, threads, friction):
    """The numbers of docs/physics.md, with the damping of docs/figures/combination.py."""
    drive = support_drive(mass=15, support_stiffness=support, axial_support_damping=200)
    if threads:
        drive = drive.replace(contact_stiffness=threads[0], contact_damping=threads[1])
    (found,) = all_thresholds(drive, "friction_coefficient")["onset"].solutions
    assert round(found.value, 3) == friction
