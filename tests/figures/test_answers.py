"""Pictures of a user's own answers: what they show, from the computed dataset and from its file alike."""

import numpy as np
import pytest
import xarray as xr

import lsvib
from lsvib.datasets.cycles import branch_dataset
from lsvib.datasets.io import write_dataset
from lsvib.errors import InputError

DRIVE = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
COMMAND = {"times": [0, 0.1, 0.2], "speeds": [0, 40, 0]}


def branch() -> xr.Dataset:
    drive = lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18)
    return branch_dataset(drive, drive.follow(drive.cycles().cycles[0], "axial_force", (-18.2, -17.8)))


ANSWERS = {  # what makes it, panels with data, words and units that they show
    "motion": (
        lambda: DRIVE.simulate("rest", 0.3, command=COMMAND, outputs=("normal_force",)), 3,
        ["Angular speed of the screw", "[rad s⁻¹]", "Normal force of the threads", "[N]", "Time"],
    ),
    "sweep": (lambda: DRIVE.sweep(axial_force=[-60, -10, 10]), 5, ["Amplitude", "[rad]", "Axial force", "[N]"]),
    "plane": (
        lambda: DRIVE.sweep(axial_force=[-60, -10, 10], mass=[9, 11]), 2, ["What the motion ends on", "Amplitude"],
    ),
    "reserve": (lambda: DRIVE.resilience_sweep(axial_force=[-20, -10]), 3, ["Energy", "[J]", "Axial force"]),
    "branch": (branch, 2, ["Amplitude", "Period of the cycle", "Axial force", "[s]"]),
    "chart": (
        lambda: DRIVE.chart(("contact_stiffness", 1e6, 1e9, 3), ("contact_damping", 1e3, 1e6, 3)), 1,
        ["Stiffness of the thread contact", "[N m⁻¹]"],
    ),
    "map": (lambda: DRIVE.attraction({"u": (-0.1, 0.1, 4), "w": (-60, 60, 4)}), 1, ["rad"]),
}  # fmt: skip


def shown(figure) -> tuple[int, str]:
    """Number of panels, colour bars left out, and all words on them."""
    panels = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
    words = [f"{axes.get_title('left')} {axes.get_xlabel()} {axes.get_ylabel()}" for axes in figure.axes]
    return len(panels), " ".join(words)


@pytest.mark.parametrize("kind", ANSWERS)
def test_an_answer_and_its_file_are_drawn_alike(kind, tmp_path):
    make, panels, words = ANSWERS[kind]
    dataset = make()
    write_dataset(dataset, tmp_path / "answer.nc", "test")
    file = tmp_path / "answer.nc"
    found, again, opened = (shown(lsvib.draw(given)) for given in (dataset, file, lsvib.open(file)))
    assert found == again == opened
    assert found[0] == panels
    assert [word for word in words if word not in found[1]] == []


def test_a_motion_shows_speed_command_rest_and_seizures():
    motion = DRIVE.simulate({"u": 0.1, "w": 0.0}, 0.05, command={"times": [0, 0.05], "speeds": [40, 30]})
    speed, *_ = lsvib.draw(motion).axes
    lines = {line.get_label(): line for line in speed.get_lines()}
    np.testing.assert_allclose(lines["command"].get_ydata(), np.interp(motion.time, [0, 0.05], [40, 30]))
    assert len(lines["seizure"].get_xdata()) == int((motion.event_normal_impulse != 0).sum()) > 0
    (drawn,) = (line.get_ydata() for line in speed.get_lines() if line.get_label().startswith("_"))
    np.testing.assert_allclose(drawn, motion.velocity_deviation + 40)


def test_what_cannot_be_drawn_is_refused():
    for dataset in (xr.Dataset(), DRIVE.sweep(axial_force=[1, 2], mass=[1, 2], support_damping=[1e-3, 2e-3])):
        with pytest.raises(InputError, match="cannot be drawn; motions, sweeps"):
            lsvib.draw(dataset)
    plane = lsvib.Drive(contact_stiffness=1e8, contact_damping=1e6)
    found = plane.attraction({"u": (-0.1, 0.1, 2), "e": (-1e-6, 1e-6, 2), "w": 0.0, "v": 0.0})
    with pytest.raises(InputError, match="only maps of u and w"):
        lsvib.draw(found)
