"""Probabilities of the mechanisms against drives that are drawn and judged by Newton's laws alone, one by one."""

import math

import numpy as np
import pytest

pytest.importorskip("pint")
pytest.importorskip("scipy")

from references.small_swings import causes, measured_growth, steady_contact

from lsvib.assess.sheet import Sheet
from lsvib.assess.uncertainty import study

CHAPTER = {
    "thread": {"lead_angle": "5.57 deg", "pitch_diameter": "10.36 mm"},
    "screw": {"inertia": "3.12e-6 kg*m^2", "mass": "11.6 kg"},
    "coupling": {"stiffness": "1 N*m/rad"},
    "load": {"mass": "1 kg", "force": ["-50 N", "10 N"]},
    "operation": {"speed": ["20 rad/s", "40 rad/s"], "direction": "both"},
    "friction": {"coefficient": 0.218},
    "damping": {"rotational": "2e-4 N*m*s/rad"},
}
"""The drive of Table 8.1 in a window of forces and speeds, both ways."""
_KEYS = {
    "coupling.stiffness": "k", "load.mass": "m", "friction.coefficient": "mu", "friction.slope": "slope",
    "damping.rotational": "c", "damping.translational": "c_x", "support.stiffness": "k_1", "support.damping": "c_1",
    "contact.stiffness": "k_c", "contact.damping": "c_c",
}  # fmt: skip
_UNITS = {
    "load.mass": "kg", "coupling.stiffness": "N*m/rad", "damping.rotational": "N*m*s/rad", "friction.slope": "s/m",
    "damping.translational": "N*s/m", "support.stiffness": "N/m", "support.damping": "N*s/m",
    "contact.stiffness": "N/m", "contact.damping": "N*s/m",
}  # fmt: skip

_BRINK = 1e-5  # of the size of a motion after some swings: what the solver and the curvature of the laws leave

# What is uncertain of the chapter's drive, in SI units; and what shall occur neither never nor always.
CASES = {
    "negative damping": (
        {"damping.rotational": ("lognormal", 2e-4, 1.5), "damping.translational": ("lognormal", 600, 1.4)},
        {"negative_damping"},
    ),
    "kinematic constraint": (
        {"load.mass": ("triangular", 6, 9, 16), "friction.coefficient": ("normal", 0.218, 0.015)},
        {"kinematic_constraint"},
    ),
    "mode coupling": (
        {
            "load.mass": ("uniform", 12, 18),
            "friction.coefficient": ("normal", 0.26, 0.02),
            "support.stiffness": ("lognormal", 5e6, 1.8),
            "support.damping": ("lognormal", 100.0, 2.0),
            "damping.translational": ("uniform", 0.0, 30.0),
        },
        {"mode_coupling", "kinematic_constraint"},
    ),
    "falling friction": (
        {
            "friction.coefficient": ("triangular", 0.1, 0.16, 0.3),
            "friction.slope": ("uniform", -0.3, 0.05),
            "damping.rotational": ("lognormal", 2e-4, 1.8),
            "damping.translational": ("lognormal", 100, 2.0),
        },
        {"falling_friction", "negative_damping"},
    ),
    "falling friction with a support": (
        {
            "load.mass": ("triangular", 2, 6, 12),
            "friction.slope": ("normal", -0.1, 0.03),
            "damping.rotational": ("lognormal", 4e-4, 1.8),
            "support.stiffness": ("lognormal", 2e5, 2.0),
            "support.damping": ("lognormal", 20.0, 2.0),
        },
        {"falling_friction"},
    ),
    "springy threads": (
        {
            "load.mass": ("triangular", 5, 7, 13),
            "contact.stiffness": ("lognormal", 1e5, 1.5),
            "contact.damping": ("lognormal", 1e5, 1.3),
        },
        {"thread_contact", "kinematic_constraint"},
    ),
}


def sheet_of(uncertain: dict) -> Sheet:
    """The chapter's drive with uncertain entries, as a data sheet."""
    keys = {"uniform": ("low", "high"), "triangular": ("low", "mode", "high"), "normal": ("mean", "std")}
    values = {"name": "brute force", **{part: dict(entries) for part, entries in CHAPTER.items()}}
    for path, (kind, *numbers) in uncertain.items():
        part, key = path.split(".")
        unit = _UNITS.get(path, "")
        texts = [f"{number!r} {unit}".strip() for number in numbers]
        if kind == "lognormal":
            texts[1] = repr(numbers[1])
        named = dict(zip(keys.get(kind, ("median", "factor")), texts, strict=True))
        values.setdefault(part, {})[key] = named
    return Sheet.of(values)


def drawn(uncertain: dict, count: int, rng: np.random.Generator) -> dict:
    """Drives (n) of the chapter with uncertain entries from numpy's own distributions, tails cut off by redrawing."""
    drives = {
        "r": 5.18e-3, "lead": math.radians(5.57), "I": 3.12e-6, "k": 1.0, "m": 1.0, "mu": 0.218, "c": 2e-4, "c_x": 0.0,
        "slope": 0.0, "m_1": 11.6,
    }  # fmt: skip
    drives = {key: np.full(count, value) for key, value in drives.items()}
    for path, (kind, *numbers) in uncertain.items():
        if kind in ("normal", "lognormal"):
            score = rng.standard_normal(count)
            while (far := np.abs(score) > 4).any():
                score[far] = rng.standard_normal(int(far.sum()))
            middle, width = numbers
            values = middle + width * score if kind == "normal" else middle * width**score
        else:
            values = getattr(rng, kind)(*numbers, size=count)
        drives[_KEYS[path]] = values
    return drives


def points(count: int, rng: np.random.Generator):
    """Speed and force of the package (n each) at the corners of the window, and at random points of it, both ways."""
    corners = [(speed, force) for speed in (20.0, 40.0) for force in (-50.0, 10.0)]
    for way in (1.0, -1.0):
        for speed, force in corners:
            yield np.full(count, way * speed), np.full(count, -force)
        for _ in range(2):
            yield way * rng.uniform(20, 40, count), -rng.uniform(-50, 10, count)


def brute_force(case: str, count: int) -> tuple[dict[str, float], list[tuple[dict, str]]]:
    """Share of the drives in which each mechanism occurs somewhere in the window; and each drive at a random point."""
    uncertain = CASES[case][0]
    rng = np.random.default_rng(11)
    drives = drawn(uncertain, count, rng)
    parts = [part for part in ("support", "contact") if any(path.startswith(part) for path in uncertain)]
    hits: dict = {}
    places = list(points(count, rng))
    for omega, force in places:
        for name, occurs in causes({**drives, "omega": omega, "force": force}, parts).items():
            hits[name] = hits.get(name, False) | occurs
    some = []
    for k in rng.choice(count, 300 if count > 10_000 else 10, replace=False):
        omega, force = places[int(rng.integers(len(places)))]
        one = {**{key: value[k] for key, value in drives.items()}, "omega": omega[k], "force": force[k]}
        some.append((one, parts[0] if parts else "rigid"))
    return {name: float(np.mean(one)) for name, one in hits.items()}, some


def compare(case: str, count: int) -> None:
    """Shares within the intervals of 8192 samples, widened by the scatter of the drives if they are few."""
    found = study(sheet_of(CASES[case][0]), 8192, 3)
    shares, some = brute_force(case, count)
    for name, share in shares.items():
        scatter = 4 * math.sqrt(max(share * (1 - share), 1 / count) / count) if count < 100_000 else 0.0
        low, high = found.probability[name].interval
        print(f"{case}, {name}: {share:.5f} of {count} drives, 95 % {low:.5f} to {high:.5f}")
        assert low - scatter <= share <= high + scatter, name
    assert all(0.005 < shares[name] < 0.995 for name in CASES[case][1])
    worst = 0.0
    for one, part in some:
        expected, measured = measured_growth(one, part)
        worst = max(worst, abs(measured - expected))
        assert expected * measured > 0 or abs(expected) < _BRINK
    print(f"{case}: {len(some)} motions grow or decay as they should, sizes to {worst:.1e}")
    assert worst < _BRINK


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_probabilities_against_thousands_of_drives(case):
    """Every mechanism, by the eigenvalues of matrices from Newton's laws, and some drives by motions that grow."""
    compare(case, 2_000)


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_probabilities_against_a_hundred_thousand_drives(case):
    """10⁵ drives, each at 12 points of the window: their share lies within the confidence interval itself."""
    compare(case, 100_000)


def test_the_contact_of_steady_sliding_carries_the_load():
    """At the chapter's drive: N_0 (cos λ + s μ sin λ) = R, law − where the load resists."""
    one = {"r": 5.18e-3, "lead": 0.1, "mu": 0.2, "c_x": 0.0, "omega": 40.0, "force": -50.0}
    law, contact = steady_contact({key: np.asarray(value) for key, value in one.items()})
    assert law == -1
    assert contact * (math.cos(0.1) - 0.2 * math.sin(0.1)) == pytest.approx(-50, rel=1e-14)
