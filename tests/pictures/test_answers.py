"""Pictures of a user's own answers: what they show, from the computed dataset and from its file alike."""

from contextlib import nullcontext

import numpy as np
import pytest
import xarray as xr

import lsvib
from lsvib.answers.cycles import branch_dataset
from lsvib.answers.io import write_dataset
from lsvib.errors import InputError

DRIVE = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)


def branch() -> xr.Dataset:
    drive = lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18)
    return branch_dataset(drive.follow(drive.cycles().cycles[0], "axial_force", (-18.2, -17.8)))


ANSWERS = {  # what makes it, panels with data, words and units that they show
    "motion": (
        lambda: DRIVE.simulate("rest", 0.3, command={"times": [0, 0.2], "speeds": [0, 9]}, outputs=["normal_force"]), 3,
        ["Angular speed of the screw", "[rad s⁻¹]", "Normal force of the threads", "[N]", "Time"],
    ),
    "sweep": (lambda: DRIVE.sweep(axial_force=[-60, -10, 10]), 5, ["Amplitude", "[rad]", "Axial force", "[N]"]),
    "plane": (
        lambda: DRIVE.sweep(axial_force=[10, -60, -10], mass=[9, 11], start="rest"), 1, ["Axial force", "[N]", "mass"],
    ),
    "branch": (branch, 2, ["Amplitude", "Period of the cycle", "Axial force", "[s]"]),
    "chart": (
        lambda: DRIVE.sweep(contact_damping=[1e3, 3e4, 1e6], contact_stiffness=[1e6, 3e7, 1e9]), 1,
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
    dataset.to_netcdf(file)  # is CF, too, and says of each parameter where it comes from
    with xr.open_dataset(file, decode_cf=False) as raw:
        assert (raw.Conventions, raw.lsvib_version) == ("CF-1.11", lsvib.__version__)
        assert [name for name in dataset.coords if "_FillValue" in raw[name].attrs] == []
        assert raw.pitch_radius.origin == "printed: Table 8.1"
        origins = {raw[name].origin.partition(":")[0] for name in ("mass", "support_damping", "axial_force")}
        assert origins <= {"given", "varied"}


@pytest.mark.parametrize("ask", ["cycles", "basin"])
def test_what_a_method_returns_is_drawn_and_shown_by_a_notebook(ask):
    figure = lsvib.draw(getattr(DRIVE, ask)())
    assert shown(figure) == (1, " Deviation $u$ [rad] Rate $\\dot u$ [rad s⁻¹]")
    assert figure._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(InputError, match="cannot be drawn; motions, sweeps"):
        lsvib.draw(getattr(lsvib.Drive(), ask)())  # steady sliding attracts all


SPOILED = [  # kind, what is done to it, and what the sentence says, or nothing where there is a picture
    ("motion", lambda x: xr.Dataset(), "a dataset over nothing cannot be drawn; motions, sweeps"),
    ("motion", lambda x: x.drop_vars("mode"), "mode"),
    ("motion", lambda x: (x["mode"].attrs.pop("flag_meanings"), x)[1], "flag_meanings is missing"),
    ("motion", lambda x: (x.normal_force.attrs.update(symbol=r"$\frac{$"), x)[1], "ParseException|Expected"),
    ("motion", lambda x: x.assign(own=("time", 2 * x.time.values), words=("time", x.time.values.astype(str))), ""),
    ("sweep", lambda x: x.assign(own=("other", [1.0, 2.0]), more=x.amplitude.drop_attrs()), ""),
    ("sweep", lambda x: x.drop_vars("attractor"), "cannot be drawn; motions, sweeps"),
    ("plane", lambda x: x.expand_dims(support_damping=[1e-3, 2e-3]), "cannot be drawn; motions, sweeps"),
    ("branch", lambda x: x.assign_attrs(changes="{"), "Expecting property name"),
    ("chart", lambda x: (x["behaviour"].attrs.pop("flag_meanings"), x)[1], "flag_meanings is missing"),
    ("map", lambda x: x.isel(angle_deviation=slice(0, 0)), "not as lsvib makes it, so it cannot be drawn"),
    ("map", lambda x: x.rename(angle_deviation="thread_mismatch"), "only maps of u and w can be drawn"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "spoil", "words"), SPOILED)
def test_a_dataset_that_is_not_as_it_was_made_is_drawn_or_refused_in_a_sentence(kind, spoil, words):
    spoiled = spoil(ANSWERS[kind][0]())
    with pytest.raises(InputError, match=f"({words}).*\\.$") if words else nullcontext():
        lsvib.draw(spoiled)


def test_a_motion_shows_its_phase_plane_and_friction_loop():
    outputs = ["normal_force", "sliding_speed", "friction_torque"]
    motion = DRIVE.simulate({"u": 0.1, "w": 0.0}, 0.05, outputs=outputs)
    (plane,), (loop,) = (lsvib.draw(motion, kind).axes for kind in ("phase_plane", "friction_loop"))
    lines = {line.get_label(): line for line in plane.get_lines()}
    assert len(lines["start of a seizure"].get_xdata()) == int((motion.event_normal_impulse != 0).sum()) > 0
    u, w = np.mean([lines["$N = 0$"].get_xdata(), lines["$N = 0$"].get_ydata()], axis=1)
    assert DRIVE.simulate({"u": u, "w": w}, 1e-9, samples=2).normal_force[0] == pytest.approx(0, abs=1e-9)
    slips = (motion["mode"] != 4) & (motion.sliding_speed != 0)  # after the seizure at the start it is zero, but once
    drawn = [x[np.isfinite(x)][1:] for x in loop.get_lines()[0].get_data()]
    force = 0.218 * 5.18e-3 / np.cos(np.deg2rad(5.57)) * np.abs(motion.normal_force) * np.sign(motion.sliding_speed)
    np.testing.assert_allclose(drawn, [motion.sliding_speed[slips], force[slips]], rtol=1e-9, atol=1e-12)
    with pytest.raises(
        InputError, match="'loop' cannot be drawn of this; of a motion phase_plane and friction_loop can"
    ):
        lsvib.draw(motion, "loop")
    with pytest.raises(InputError, match="needs sliding_speed and friction_torque among the outputs"):
        lsvib.draw(motion.drop_vars("friction_torque"), "friction_loop")


def test_a_motion_shows_speed_command_rest_and_seizures():
    motion = DRIVE.simulate({"u": 0.1, "w": 0.0}, 0.05, command={"times": [0, 0.05], "speeds": [40, 30]})
    speed, *_ = lsvib.draw(motion).axes
    lines = {line.get_label(): line for line in speed.get_lines()}
    np.testing.assert_allclose(lines["command"].get_ydata(), np.interp(motion.time, [0, 0.05], [40, 30]))
    assert len(lines["seizure"].get_xdata()) == int((motion.event_normal_impulse != 0).sum()) > 0
    (drawn,) = (line.get_ydata() for line in speed.get_lines() if line.get_label().startswith("_"))
    np.testing.assert_allclose(drawn, motion.velocity_deviation + 40)
