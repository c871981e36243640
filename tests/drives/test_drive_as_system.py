"""A drive written as a system of one's own, whose equations stand there in words, ends as the drive does."""

import re
from collections import Counter

import pytest

import lsvib
from lsvib.drives.model import model_of
from lsvib.errors import InputError
from lsvib.systems import Label
from lsvib.systems.cycles import cycle_of

SOFT = dict(contact_stiffness=1e6, contact_damping=1e3, translation_damping=1000)
JAM = dict(mass=11, contact_stiffness=1e6, contact_damping=1e6, axial_force=60, translation_damping=0)  # Γ₊ < 0
DRIVES = [
    (dict(axial_force=10), Label.EQUILIBRIUM),
    (dict(axial_force=-30), Label.EQUILIBRIUM),
    (dict(axial_force=0, static_friction_coefficient=0.3), Label.EQUILIBRIUM),
    (dict(axial_force=20, input_speed=0), Label.EQUILIBRIUM),
    (dict(support_damping=0, translation_damping=0), Label.FAMILY),
    (dict(axial_force=30), Label.CYCLE),  # slips all the time, with contact reversals
    (dict(), Label.CYCLE),  # sticks and slips
    (dict(axial_force=-60, input_speed=-5, static_friction_coefficient=0.3), Label.CYCLE),
    (dict(axial_force=60, **SOFT), Label.CYCLE),
    (dict(axial_force=-20, **SOFT), Label.EQUILIBRIUM),
    (JAM, Label.CYCLE),
]


@pytest.mark.parametrize(("values", "label"), DRIVES)
@pytest.mark.parametrize(("u", "w"), [(0.003, 1.0), (0.1, 20.0), (0.2, -150.0), (0.05, None)])  # None: the screw stands
def test_a_drive_and_its_system_end_alike(values, label, u, w):
    drive = lsvib.Drive(**{"translation_damping": 1000} | values)
    system, speed = drive.system(), drive.input_speed
    rate = -speed if w is None else w
    way = "forward" if speed + rate > 0 else "backward"
    mode = [*system.modes][-1] if w is None else f"slip_{way}_positive"
    state = model_of(drive).initial_state(drive, {"u": u, "w": rate}).tolist()
    start = dict(zip(system.states, state, strict=True))
    start["z"] += drive.describe().steady["coupling_deflection"]
    known, end = drive.steady_state({"u": u, "w": rate}), system.steady_state(mode, start)
    assert end.label == label
    if label == Label.EQUILIBRIUM:
        deflection = drive.describe().steady["coupling_deflection"] if speed else known.state[0]
        assert end.state["z"] == pytest.approx(deflection, rel=1e-10)
        return
    assert end.period == pytest.approx(known.orbit.end_time, rel=1e-10)
    if label == Label.CYCLE:
        cycle = cycle_of(known)
        assert end.multipliers == pytest.approx(cycle.multipliers, abs=1e-10)
        assert Counter(mode for _, mode in end.cycle.itinerary) == Counter(mode for _, mode in cycle.itinerary)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        (dict(mass=11), "parameters.real_below_critical_mass = 'sqrt(Gamma_plus)' is not a real number."),
        (dict(slide_friction=1), "the drive has slide_friction; only rigid or compliant threads with one"),
        (dict(friction_slope=0.1), "the drive has friction_slope; only rigid"),
        (dict(motor_inertia=1e-5, integral_gain=1), "the drive has a motor with its controller; only rigid"),
    ],
)
def test_what_a_drive_has_beyond_is_refused(values, sentence):
    with pytest.raises(InputError, match=re.escape(sentence)):
        lsvib.Drive(**values).system()
    with pytest.raises(InputError, match="below_critical_mass"):
        lsvib.Drive().system().replace(m=10.11)  # the critical mass is 10.107 kg (8.20)
    assert lsvib.Drive().system().replace(m=10.1).parameters["m"] == 10.1
