"""A part that the package does not have, a flywheel behind a second coupling, by the rows that CONTRIBUTING names."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lsvib
from lsvib.drives import drive, names
from lsvib.drives.drive import Value, quantity

OWN = {"flywheel_inertia": 4e-6, "flywheel_stiffness": 3.0, "flywheel_damping": 1e-5}


class WithFlywheel(lsvib.Drive):
    flywheel_inertia: Value = quantity(None, "I_f", "kg m2", "moment of inertia of the flywheel", ge=1e-30, le=1e6)
    flywheel_stiffness: Value = quantity(None, "k_f", "N m rad-1", "stiffness of its coupling", ge=1e-21, le=1e15)
    flywheel_damping: Value = quantity(None, "c_f", "N m s rad-1", "damping of its coupling", ge=0, le=1e15)


@pytest.fixture(autouse=True)
def flywheel(monkeypatch):
    monkeypatch.setitem(drive.PARTS, "flywheel", tuple(OWN))
    for name in OWN:
        monkeypatch.setitem(drive.PART_OF, name, "flywheel")
    monkeypatch.setitem(drive.IN_WORDS, "flywheel", "a flywheel behind a second coupling")
    monkeypatch.setitem(names.COORDINATES, "flywheel", ("flywheel_angle", "flywheel_rate"))
    monkeypatch.setitem(names.BODIES, "flywheel", names.Body("φ", on="screw"))
    monkeypatch.setitem(names.WORDS, "flywheel_angle", ("angle of the flywheel", "rad", "$φ$"))
    monkeypatch.setitem(names.WORDS, "flywheel_rate", ("angular speed of the flywheel", "rad s-1", "$φ'$"))


def accelerations(p, gamma: float, u: float, w: float, v: float, rate: float) -> tuple[float, float]:
    """Those of screw and flywheel in slip under the law of steady sliding."""
    twist = p.flywheel_stiffness * (v - u) + p.flywheel_damping * (rate - w)
    return (twist - p.support_damping * w - p.coupling_stiffness * u) / gamma, -twist / p.flywheel_inertia


def test_motion_stability_and_cycles_of_a_drive_with_a_flywheel():
    p = WithFlywheel(mass=8.0, **OWN)
    gamma = float(lsvib.drives.mechanics.coefficients(WithFlywheel(mass=8.0)).gamma[1])
    assert any("φ″ = − 3 (φ − θ) − 1e-05 (φ′ − θ′)" in line for line in p.describe().equations)
    # stability against the matrix of Newton's laws
    columns = [accelerations(p, gamma, *row) for row in np.eye(4)]
    matrix = np.zeros((4, 4))
    matrix[0, 1] = matrix[2, 3] = 1.0
    matrix[1], matrix[3] = zip(*columns, strict=True)
    ours = np.sort_complex(np.array(p.stability().eigenvalues))
    np.testing.assert_allclose(ours, np.sort_complex(np.linalg.eigvals(matrix)), rtol=1e-9)
    # a motion without events
    start = {"u": 1e-4, "w": 0.1, "flywheel_angle": -1e-4, "flywheel_rate": 0.2}
    found = solve_ivp(lambda t, x: matrix @ x, (0, 0.02), [*start.values()], method="DOP853", rtol=1e-12, atol=1e-14)
    motion = p.simulate(start, 0.02)
    assert not motion.sizes["event"]
    ends = [float(motion[name][-1]) for name in ("u", "flywheel_angle", "flywheel_rate")]
    np.testing.assert_allclose(ends, found.y[[0, 2, 3], -1], rtol=1e-8)
    # a stiff coupling makes one body of both
    stiff = p.replace(flywheel_stiffness=1e5, flywheel_damping=0.1, static_friction_coefficient=0.3, input_speed=2.0)
    one = WithFlywheel(mass=8.0, screw_inertia=3.12e-6 + 4e-6, static_friction_coefficient=0.3, input_speed=2.0)
    cycles, expected = stiff.cycles().cycles, one.cycles().cycles
    assert cycles
    assert expected
    assert cycles[0].period == pytest.approx(expected[0].period, rel=1e-4)
    assert abs(cycles[0].to_json()["work"]["balance"]) < 1e-9
