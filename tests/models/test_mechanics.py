"""The formulas of the coefficients in balls, arrays and series; signs are certain, and what is not there is zero."""

from types import SimpleNamespace

import flint
import numpy as np
import pytest
from flint import arb, arb_series

from lsvib.engine.exact.arithmetic import Divided, many_digits, sign
from lsvib.errors import EngineError
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients, coefficients_of, plus, solved

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


def test_the_same_formulas_serve_many_drives():
    drives = [DRIVE.replace(mass=m) for m in (1.0, 5.0, 9.0)]
    values = {key: np.array([getattr(d, key) for d in drives]) for key in Drive.model_fields}
    lead, values["steady_friction"] = values["lead_angle"], values["friction_coefficient"]
    d = SimpleNamespace(**values, tan_lead=np.tan(lead), sin_lead=np.sin(lead), cos_lead=np.cos(lead))
    for k, drive in enumerate(drives):
        np.testing.assert_allclose(coefficients_of(d).gamma[1][k], float(coefficients(drive).gamma[1]), rtol=1e-14)
    d.axial_force = np.array([1.0, -1.0, 1.0]) * 1e6
    with pytest.raises(Divided) as parts:
        coefficients_of(d)
    assert parts.value.signs.tolist() == [1, -1, 1]


def test_a_sign_that_is_not_certain_is_refused_with_the_parameter():
    with many_digits(), pytest.raises(EngineError, match="change mass a little"):
        sign(arb(1, 2), "mass")
    assert sign(arb(0)) == 0


def test_sums_that_cancel_are_exactly_zero():
    """As tan λ is transcendental, a difference that holds zero to so many digits vanishes for good."""
    with many_digits():
        third, tan = arb(1) / 3, DRIVE.exact().tan_lead
        (zero,) = plus((third * tan,), (-tan / 3,))
        assert zero.is_zero()
        found = solved([({"x": 1, "y": tan}, (tan,)), ({"y": third}, (third,))])
        assert found["x"][0] == 0
        with pytest.raises(EngineError, match="digits do not determine"):
            plus((arb(1, 1e-3),), (arb(-1, 1e-3),))


def test_the_precision_of_the_caller_is_left_alone():
    before = flint.ctx.prec
    coefficients(Drive(mass=3.21))
    assert flint.ctx.prec == before
