"""The friction law of the threads, and the formulas of the coefficients in balls, arrays and series; certain signs."""

import math
import re
from pathlib import Path
from types import SimpleNamespace

import flint
import numpy as np
import pytest
from flint import arb, arb_series
from references.command_line import complaint
from references.drives import nut_drive, support_drive, threads_drive

from lsvib import Drive
from lsvib.drives import friction, pairings
from lsvib.drives.drive import changed
from lsvib.drives.mechanics import coefficients, coefficients_of, plus
from lsvib.drives.mechanism import solved
from lsvib.errors import EngineError, InputError
from lsvib.stability.threshold import solve_threshold
from lsvib.systems.exact.arithmetic import many_digits, sign

LAW = {"stribeck_rise": 0.05, "stribeck_speed": 0.1, "friction_slope": -0.02}


def values(drive, speeds, power):
    return 0.218 + 0.05 * np.exp(-((speeds / 0.1) ** power)) - 0.02 * speeds


@pytest.mark.parametrize("power", [1, 2])
def test_law_in_balls_and_arrays(power):
    drive = Drive(**LAW, stribeck_exponent=power)
    speeds = np.array([0.01, 0.1, 0.5, 5.0])
    expected, step = values(drive, speeds, power), 1e-6
    np.testing.assert_allclose(friction.coefficient(drive, speeds), expected, rtol=1e-15)
    slopes = (values(drive, speeds + step, power) - values(drive, speeds - step, power)) / (2 * step)
    np.testing.assert_allclose(friction.unbounded(drive, speeds)[1], slopes, rtol=1e-8)
    with many_digits():
        for speed, mu in zip(speeds, expected, strict=True):
            series = friction.coefficient(drive.exact(), arb_series([arb(speed), 1], prec=2))
            assert math.isclose(float(series[0]), mu, rel_tol=1e-15)
            assert abs(series[1] - friction.unbounded(drive.exact(), arb(speed))[1]) < 1e-100
    sliding = Drive(input_speed=-7.0).pitch_radius * 7.0 / math.cos(drive.lead_angle)
    exact = drive.replace(input_speed=-7.0).exact()
    assert math.isclose(float(exact.steady_friction), values(drive, sliding, power), rel_tol=1e-15)
    assert float(exact.static_friction) == 0.268


def test_steady_sliding_of_many_drives():
    """Drives with and without a law, and one whose friction is cut off, in one call."""
    drive = Drive(**LAW)
    changes = {"stribeck_rise": np.array([0.0, 0.05, 0.05, 0.05]), "friction_slope": np.array([0.0, -0.02, 0.1, -9.0])}
    mu, rate = friction.steady({**dict(drive), **changes}, math.tan(drive.lead_angle))
    speed = drive.pitch_radius * drive.input_speed / math.cos(drive.lead_angle)
    for k in range(4):
        one = drive.replace(**{key: float(x[k]) for key, x in changes.items()})
        assert math.isclose(mu[k], float(one.exact().steady_friction), rel_tol=1e-14)
        slope = friction.unbounded(one.exact(), arb(speed))[1] if k < 3 else 0.0  # the last one is cut off
        assert math.isclose(rate[k], float(slope), rel_tol=1e-13)
    assert mu[3] == rate[3] == 0


@pytest.mark.parametrize("kind", [Drive, threads_drive, support_drive, nut_drive])
def test_drives_list_the_law_that_they_have(kind):
    assert not set(dict(kind())) & set(friction.NAMES)
    law = {**LAW, "static_friction_coefficient": 0.3, "stribeck_exponent": 2.0}
    assert {key: value for key, value in kind(**law) if key in friction.NAMES} == law
    assert kind.of(dict(kind(**law))) == kind(**law)
    assert kind(**law).exact().static_friction == 0.3
    for constant in (kind(), kind(static_friction_coefficient=0.3)):
        assert constant.exact().steady_friction is constant.exact().friction_coefficient


STATIC = (
    "static_friction_coefficient = {} is outside the allowed range {} (the friction of slow sliding) <= "
    "static_friction_coefficient < cot(lead_angle) = 10.2541."
)


@pytest.mark.parametrize(
    ("law", "sentence"),
    [
        ({"stribeck_exponent": 1.5}, "stribeck_exponent = 1.5 is neither 1 nor 2."),
        (
            {"stribeck_exponent": 3.0},
            "stribeck_exponent = 3.0 is outside the allowed range 1 <= stribeck_exponent <= 2.",
        ),
        ({"stribeck_rise": 0.1}, "stribeck_rise = 0.1 needs stribeck_speed > 0."),
        ({"stribeck_rise": -0.1}, "stribeck_rise = -0.1 is outside the allowed range 0 <= stribeck_rise."),
        (
            {"stribeck_rise": 10.1, "stribeck_speed": 0.1},
            "friction_coefficient + stribeck_rise = 10.318, the friction of slow sliding, is not below "
            "cot(lead_angle) = 10.2541.",
        ),
        ({"static_friction_coefficient": 0.2}, STATIC.format(0.2, 0.218)),
        ({"static_friction_coefficient": 0.25, **LAW}, STATIC.format(0.25, 0.268)),
        ({"static_friction_coefficient": 11}, STATIC.format(11, 0.218)),
        (
            {"friction_slope": 50},
            "friction_slope = 50 makes the friction coefficient 10.6271 at the sliding speed 0.208183 m/s of steady "
            "sliding, which is not below cot(lead_angle) = 10.2541.",
        ),
        (
            {"friction_slope": 2e6},
            "friction_slope = 2000000.0 is outside the allowed range 0 or 1e-18 <= |friction_slope| <= 1e+06 s m-1.",
        ),
        (
            {"stribeck_speed": 1e-13},
            "stribeck_speed = 1e-13 is outside the allowed range 0 or 1e-12 <= stribeck_speed <= 1e+06 m s-1.",
        ),
        ({"friction_slope": "steep"}, None),
        ({"stribeck_rise": math.nan}, None),
        ({"stribeck_rise": math.inf}, None),
    ],
)
def test_a_law_that_is_none_gets_one_sentence(law, sentence):
    found = complaint(Drive, **law)
    if sentence is None:
        ((key, value),) = law.items()
        assert found.startswith(f"{key} = {value!r} ")
    else:
        assert found == sentence


@pytest.mark.parametrize("name", pairings.PAIRINGS)
def test_a_pairing_makes_a_drive(name):
    one = pairings.PAIRINGS[name]
    assert 0 < one.low <= one.high < 1
    for kind in (Drive, nut_drive):
        drive = kind(friction=name)
        assert drive == kind(**one.parameters())
        assert one.low <= drive.friction_coefficient <= one.high
        other = kind(mass=2, **LAW, static_friction_coefficient=0.4).replace(friction=name)
        assert other == kind(mass=2, friction=name)
    assert Drive.of({"friction": name, "mass": "2"}) == Drive.of(changed({**LAW, "mass": 2}, {"friction": name}))


def test_numbers_of_pairings_are_those_of_their_sources():
    """Middles of ranges, and both laws over the rate of the screw, as they are printed."""
    assert Drive(friction="steel_on_bronze_lubricated").friction_coefficient == 0.15
    assert Drive(friction="iglidur_j").friction_coefficient == 0.12
    seat, lever = Drive(friction="powered_seat"), 5.18e-3 / math.cos(math.radians(5.57))
    assert math.isclose(seat.friction_slope * lever, -4.47e-4, rel_tol=1e-14)
    onset = solve_threshold(seat, "onset", "axial_force")
    assert min(x.value for x in onset.solutions if x.value > 0) == pytest.approx(88.934, rel=1e-5)
    screw = Drive(friction="measured_screw", pitch_radius=5.5e-3, lead_angle=math.atan(2 / (11 * math.pi)))
    rate = np.array([0.5, 3.2, 20.0])
    speed = screw.pitch_radius * rate / math.cos(screw.lead_angle)
    np.testing.assert_allclose(friction.coefficient(screw, speed), 0.27 + 0.1 * np.exp(-2 * rate / 6.4), rtol=1e-4)


def test_a_pairing_beside_parameters():
    bronze = "steel_on_bronze_dry"
    drive = Drive(friction=bronze, static_friction_coefficient=0.5, **LAW)
    assert (drive.friction_coefficient, drive.static_friction_coefficient, drive.stribeck_rise) == (0.4, 0.5, 0.05)
    assert changed({"friction": bronze}, {"friction_coefficient": 0.1}) == {**pairings.in_parameters(
        {"friction": bronze}), "friction_coefficient": 0.1}  # fmt: skip
    for given, key in ((bronze, "friction_coefficient"), ("powered_seat", "stribeck_rise")):
        for make in (Drive, Drive().replace, lambda **values: Drive.of(values)):
            with pytest.raises(InputError, match=f"^friction and {key} are both given; give one of them.$"):
                make(friction=given, **{key: 0.1})
    for name in ("butter", 0.2, None, [bronze]):
        with pytest.raises(InputError, match=r"^friction = .* is not known; known are steel_on_bronze_dry, .*seat\.$"):
            Drive(friction=name)


def test_the_page_lists_the_pairings_as_they_are():
    page = (Path(__file__).parents[2] / "docs" / "friction.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| ([\d.–]+) \| (.*) \| (.*) \|$", page, re.MULTILINE)
    expected = []
    for name, one in pairings.PAIRINGS.items():
        numbers = f"{one.low:g}" if one.low == one.high else f"{one.low:g}–{one.high:g}"
        law = ", ".join(f"{key} {value:.6g}" for key, value in one.law.items())
        expected.append((name, numbers, law or "–", one.source))
    assert rows == expected


DRIVE = Drive(mass=8.0, translation_damping=1e3, axial_force=-20.0)


def test_terms_that_are_not_there_are_exactly_zero():
    drive = Drive(support_damping=0.0, axial_force=0.0)
    c = coefficients(drive)
    assert all(x.is_zero() for x in (c.net_force, c.damping[1], c.damping[-1], c.deflection, c.q_row[1], c.q_row[2]))
    assert coefficients(DRIVE).slack(coefficients(DRIVE).steady_law) == 0


def test_coefficients_hold_their_formulas_to_many_digits():
    """Γ₊ vanishes at the critical mass: of two doubles next to it one is on either side, and the balls say which."""
    mass = 10.106965213139869
    gamma = [coefficients(Drive(mass=m)).gamma[1] for m in (mass - 2e-15, mass + 2e-15)]
    assert [sign(x) for x in gamma] == [1, -1]
    assert all(float(x.rad()) < 1e-150 for x in gamma)


def test_the_same_formulas_carry_derivatives():
    """dΓ_s/dm = −ξ_s tan λ r_m², enclosed."""
    with many_digits():
        values = {key: arb_series([value], prec=2) for key, value in vars(DRIVE.exact()).items()}
        values["mass"] = arb_series([DRIVE.mass, 1], prec=2)
        found, c, d = coefficients_of(SimpleNamespace(**values)), coefficients(DRIVE), DRIVE.exact()
        for law in (1, -1):
            assert found.gamma[law][0].overlaps(c.gamma[law])
            assert found.gamma[law][1].overlaps(-c.xi[law] * d.tan_lead * d.pitch_radius**2)
            assert found.damping[law][1].is_zero()
        assert found.steady_law == c.steady_law
        assert found.paradox is c.paradox


def test_a_sign_that_is_not_certain_is_refused_with_the_parameter():
    with many_digits(), pytest.raises(EngineError, match="change mass a little"):
        sign(arb(1, 2), "mass")
    assert sign(arb(0)) == 0


def test_sums_that_cancel_are_exactly_zero():
    """As tan λ is transcendental, a difference that holds zero to so many digits vanishes for good."""
    with many_digits():
        third, tan = arb(1) / 3, DRIVE.exact().tan_lead
        (zero,) = plus((third * tan,), (-tan / 3,))
        assert zero == 0
        found = solved([({"x": 1, "y": tan}, (tan,)), ({"y": third}, (third,))])
        assert found["x"][0] == 0
        with pytest.raises(EngineError, match="digits do not determine"):
            plus((arb(1, 1e-3),), (arb(-1, 1e-3),))


def test_the_precision_of_the_caller_is_left_alone():
    before = flint.ctx.prec
    coefficients(Drive(mass=3.21))
    assert flint.ctx.prec == before
