"""A nut of two halves pressed apart: torque by the forces on both flanks, what holds, the fit, and what is refused."""

import math

import numpy as np
import pytest

pytest.importorskip("pint")
pytest.importorskip("scipy")

from lsvib.assess.assessment import assess
from lsvib.assess.output import assess_file
from lsvib.assess.sheet import Sheet
from lsvib.assess.statics import statics
from lsvib.errors import InputError
from lsvib.fit.law import Measured, fitted
from lsvib.models.mechanics import holding_coefficient, relieved_half, thread_force

ANGLE = math.atan(2 / (math.pi * 11))
SHEET = {
    "name": "positioning axis",
    "thread": {"lead": "2 mm", "pitch_diameter": "11 mm"},
    "load": {"force": "2 N"},
    "operation": {"speed": "10 rpm"},
    "friction": {"coefficient": 0.1},
    "nut": {"preload": "0.8 N"},
}


def flank(axial, mu, forward):
    """Force around the screw that turns one flank under an axial force: normal force N and friction μ N, both resolved.

    ``forward``: the screw pushes the flank along; then N cos λ − μ N sin λ is axial, N sin λ + μ N cos λ is not.
    """
    s = 1 if forward else -1
    normal = axial / (math.cos(ANGLE) - s * mu * math.sin(ANGLE))
    return s * normal * (math.sin(ANGLE) + s * mu * math.cos(ANGLE))


@pytest.mark.parametrize("share", [1.0, 0.5])
@pytest.mark.parametrize("force", [0.0, 1.3, 2.5])
def test_torque_is_that_of_both_flanks(force, share):
    """While the preload lasts both rub, beyond it one does; a quarter of 2.5 N is above none of 0.8 N, a half is."""
    mu, preload = 0.13, 0.8
    other = max(preload - (1 - share) * force, 0.0)
    against = flank(force + other, mu, True) + flank(other, mu, False)
    along = flank(other, mu, True) + flank(force + other, mu, False)
    relieved = relieved_half(force, preload, share)
    assert relieved == pytest.approx(other)
    for law, torque in ((-1, against), (1, along)):
        assert thread_force(force, relieved, mu, math.tan(ANGLE), law) == pytest.approx(torque, rel=1e-14)
        assert holding_coefficient(torque, force, relieved, math.tan(ANGLE), law) == pytest.approx(mu, rel=1e-13)


def test_statics_of_a_sheet_with_preload():
    """It takes more torque than without, and holds a load at a friction at which it would not."""
    rows = statics(Sheet.of(SHEET)).rows
    radius, mu = 5.5e-3, 0.1
    assert rows["lifting_torque"].worst == pytest.approx(radius * (flank(2.8, mu, True) + flank(0.8, mu, False)))
    assert rows["lowering_torque"].worst == pytest.approx(radius * (flank(0.8, mu, True) + flank(2.8, mu, False)))
    limit = rows["holding_friction"].limit
    assert flank(0.8, limit, True) == pytest.approx(-flank(2.8, limit, False))
    assert limit < 0.6 * math.tan(ANGLE)
    pressed = Sheet.of(SHEET | {"nut": {"preload": "0.8 N", "length": "10 mm"}})
    alone = Sheet.of(SHEET | {"nut": {"length": "10 mm"}})
    pressures = [statics(sheet).rows["nut_pressure"].worst for sheet in (pressed, alone)]
    assert pressures[0] == pytest.approx(1.4 * pressures[1])


def test_its_motion_is_refused_in_a_sentence(tmp_path):
    drive = {"screw": {"inertia": "2e-6 kg*m^2"}, "coupling": {"stiffness": "1 N*m/rad"}}
    sheet = Sheet.of(SHEET | drive | {"load": {"mass": "0.3 kg", "force": "2 N"}})
    with pytest.raises(InputError, match="the motion of a preloaded nut, both halves of which rub, is not followed"):
        assess(sheet)
    path = tmp_path / "sheet.yaml"
    path.write_text(str(SHEET | drive | {"load": {"mass": "0.3 kg", "force": "2 N"}}))
    found = assess_file(path, None)
    assert found["verdict"] is None
    assert "preloaded nut" in found["brief"][0]


@pytest.mark.parametrize("load", [0.0, 0.4, -2.0])
def test_the_fit_knows_the_preload(load):
    """The same torques without it would be those of a friction that is several times as large."""
    speed = np.array([-20.0, -10.0, -5.0, -2.0, 2.0, 5.0, 10.0, 20.0])
    force, preload, mu = abs(load), 0.8, 0.2
    against = flank(force + preload, mu, True) + flank(preload, mu, False)
    along = flank(preload, mu, True) + flank(force + preload, mu, False)
    torque = 5.5e-3 * np.sign(speed) * np.where(speed * load > 0, against, along)
    held = np.array([[1.0, 1.5 * torque[-1], load]])
    measured = Measured(speed, torque, np.full(8, load), 5.5e-3, ANGLE, held, preload=preload)
    main = fitted(measured, {"coulomb": 0.0, "viscous": 0.0, "stribeck_rise": 0.0, "offset": 0.0}).main
    assert main.values["friction_coefficient"] == pytest.approx(mu, abs=1e-6)
    way = -1 if load > 0 else 1
    known = 1.5 * torque[-1] / 5.5e-3
    assert thread_force(force, preload, main.static[0], math.tan(ANGLE), way) == pytest.approx(known)
