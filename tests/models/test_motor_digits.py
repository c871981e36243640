"""Cycles of three drives behind a motor against Newton's laws with 45 digits (``references.motor_digits``).

A soft coupling with friction that is constant, whose contact reverses; a stiff one, and a heavy rotor that turns
backwards, with static friction above that of sliding. The test holds 30 digits, which a slow one computes again.
"""

import pytest
from mpmath import mp
from references.motor_digits import MotorCycle

from lsvib import Drive
from lsvib.models.model import model_of

MOTOR = {"motor_inertia": 1e-5, "integral_gain": 1.0}
STATIC = {"axial_force": 50.0, "static_friction_coefficient": 0.3}
DRIVES = {
    "soft coupling": Drive(
        **MOTOR, speed_gain=2e-4, coupling_stiffness=0.2, translation_damping=1000.0, axial_force=40.0
    ),
    "stiff coupling": Drive(
        **MOTOR, **STATIC, speed_gain=5e-4, coupling_stiffness=700.0, coupling_damping=2e-3, input_speed=2.0
    ),
    "heavy rotor": Drive(**(MOTOR | {"motor_inertia": 1e-3}), **STATIC, speed_gain=2e-3, input_speed=-2.0),
}
DIGITS = {  # period [s], amplitude [rad]
    "soft coupling": ("0.0285243654195195698821945229506", "0.205205637940755396987550844794"),
    "stiff coupling": ("0.0301138592850178933830195159335", "0.0172389940304544598398746332633"),
    "heavy rotor": ("0.0272336239979535085430947514298", "0.0206201374165635027804243373474"),
}


@pytest.mark.parametrize("name", DRIVES)
def test_cycles_of_a_drive_with_a_motor(name):
    drive, expected = DRIVES[name], [pytest.approx(float(digits), rel=1e-13) for digits in DIGITS[name]]
    (cycle,), steady = drive.cycles().cycles, drive.steady_state(model_of(drive).from_rest(drive))
    assert [cycle.period, cycle.amplitude] == expected
    assert [steady.period, steady.amplitude] == expected


@pytest.mark.slow
@pytest.mark.parametrize("name", DRIVES)
def test_the_digits_are_those_of_newtons_laws(name):
    with mp.workdps(45):
        found = MotorCycle(dict(DRIVES[name]))
        assert len(found.modes) == 1 + len(DRIVES[name].cycles().cycles[0].itinerary)
        for value, digits in zip((found.period, found.amplitude), DIGITS[name], strict=True):
            assert mp.nstr(value, 30) == digits


def test_the_cycle_that_a_start_reaches_is_among_those_that_are_found():
    """Starts that leave the motor at steady sliding reach another one only."""
    drive = DRIVES["stiff coupling"].replace(coupling_stiffness=1000.0)
    steady = drive.steady_state(model_of(drive).from_rest(drive))
    assert pytest.approx(steady.period, rel=1e-13) in [cycle.period for cycle in drive.cycles().cycles]
