"""Pictures of a user's own answers: what they show, from the computed dataset and from its file alike."""

import json
from contextlib import nullcontext
from functools import cache

import numpy as np
import pytest
import xarray as xr
from references.figure_checks import without_room

import lsvib
from lsvib.answers.attributes import flagged
from lsvib.answers.cycles import branch_dataset
from lsvib.answers.io import write_dataset
from lsvib.errors import InputError
from lsvib.pictures import drawing, style
from lsvib.systems import System

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


@cache
def answer(kind: str) -> xr.Dataset:
    return ANSWERS[kind][0]()


def shown(figure) -> tuple[int, str]:
    """Number of panels, colour bars left out, and all words on them."""
    panels = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
    words = [f"{axes.get_title('left')} {axes.get_xlabel()} {axes.get_ylabel()}" for axes in figure.axes]
    return len(panels), " ".join(words)


@pytest.mark.parametrize("kind", ANSWERS)
def test_an_answer_and_its_file_are_drawn_alike(kind, tmp_path):
    _, panels, words = ANSWERS[kind]
    dataset = answer(kind)
    write_dataset(dataset, tmp_path / "answer.nc", "test")
    file = tmp_path / "answer.nc"
    found, again, opened = (shown(lsvib.draw(given)) for given in (dataset, file, lsvib.open(file)))
    assert found == again == opened
    assert found[0] == panels
    assert without_room(lsvib.draw(dataset)) == []
    assert [word for word in words if word not in found[1]] == []
    dataset.to_netcdf(file)  # is CF, too, and says of each parameter where it comes from
    with xr.open_dataset(file, decode_cf=False) as raw:
        assert (raw.Conventions, raw.lsvib_version) == ("CF-1.11", lsvib.__version__)
        assert [name for name in dataset.coords if "_FillValue" in raw[name].attrs] == []
        assert raw.pitch_radius.origin == "printed: Table 8.1"
        origins = {raw[name].origin.partition(":")[0] for name in ("mass", "support_damping", "axial_force")}
        assert origins <= {"given", "varied"}


MOVED = {  # what is done to the words of two curves, and what is found
    "covers": lambda first, second, _: second.set(position=first.get_position(), rotation=first.get_rotation()),
    "covers a line": lambda first, _, line: first.set_position(line),
    "covers a frame": lambda first, *_: first.set_x(9.0),
    "leaves the picture": lambda first, *_: first.set_x(0.0),
}


@pytest.mark.parametrize("fault", MOVED)
def test_curves_on_each_other_keep_their_names_and_words_that_are_moved_are_found(fault, monkeypatch):
    mass, force = (np.tile(np.linspace(*ends, 20), 2) for ends in ((9.2, 10.8), (-50.0, 0.0)))
    points = {"boundary_mass": mass, "boundary_axial_force": force, "boundary_line": np.repeat([0, 1], 20)}
    names = flagged("boundary_point", np.repeat([1, 0], 20), "name", ["onset", "even_speed"])
    dataset = answer("plane").assign({name: ("boundary_point", own) for name, own in points.items()})
    dataset = dataset.assign(boundary_name=names)
    figure = lsvib.draw(dataset)
    first, second = figure.axes[0].texts
    assert {first.get_text(), second.get_text()} == {r"onset, $\tilde R = 0$", "steady from rest"}
    assert without_room(figure) == []
    style.laid_out(figure).set_layout_engine(None)  # which would make room
    MOVED[fault](first, second, (mass[10], force[10]))
    assert [words for words in without_room(figure) if fault in words] != []
    monkeypatch.setattr(drawing, "write", lambda *_, **__: False)  # as if there were no room
    (legend,) = lsvib.draw(dataset).legends
    assert {first.get_text(), second.get_text()} <= {text.get_text() for text in legend.get_texts()}


@pytest.mark.parametrize("ask", ["cycles", "basin"])
def test_what_a_method_returns_is_drawn_and_shown_by_a_notebook(ask):
    figure = lsvib.draw(getattr(DRIVE, ask)())
    assert shown(figure) == (1, " Deviation $u$ [rad] Rate $\\dot u$ [rad s⁻¹]")
    assert figure._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(InputError, match="cannot be drawn; motions, sweeps"):
        lsvib.draw(getattr(lsvib.Drive(), ask)())  # steady sliding attracts all


def test_a_system_with_states_of_the_names_of_a_drive_is_none():
    spiral = System(states=["u", "w"], modes={"one": {"u": "w", "w": "-u - 0.1*w"}})
    figure = lsvib.draw(spiral.simulate("one", {"u": 1}, 10))
    assert [axes.get_title("left") for axes in figure.axes] == ["State u", "State w"]


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
    ("map", lambda x: x.isel(u=slice(0, 0)), "not one that lsvib writes, so it cannot be drawn"),
    ("map", lambda x: x.rename(u="thread_mismatch"), "only maps of u and w can be drawn"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "spoil", "words"), SPOILED)
def test_a_dataset_that_is_not_as_it_was_made_is_drawn_or_refused_in_a_sentence(kind, spoil, words):
    spoiled = spoil(answer(kind).copy(deep=True))
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
    v, f = loop.get_lines()[0].get_data()  # samples and, after the start, what was before and after each event
    later = motion.isel(event=motion.event_time.values > 0)
    order = np.argsort(np.append(np.repeat(later.event_time, 2), motion.time), kind="stable")
    speed, force = (
        np.append(np.transpose([later[f"event_{name}_before"], later[f"event_{name}_after"]]), motion[name])[order]
        for name in ("sliding_speed", "normal_force")
    )
    torque = 0.218 * 5.18e-3 / np.cos(np.deg2rad(5.57)) * np.abs(force) * np.sign(speed)
    slips, drawn = speed != 0, np.isfinite(v) & (v != 0)
    np.testing.assert_allclose([v[drawn], f[drawn]], [speed[slips], torque[slips]], rtol=1e-9, atol=1e-12)
    with pytest.raises(InputError, match="'loop' cannot be drawn from this; of a motion of a drive phase_plane and"):
        lsvib.draw(motion, "loop")
    with pytest.raises(InputError, match="needs sliding_speed and friction_torque among the outputs"):
        lsvib.draw(motion.drop_vars("friction_torque"), "friction_loop")


def test_a_motion_shows_speed_command_rest_and_seizures():
    motion = DRIVE.simulate({"u": 0.1, "w": 0.0}, 0.05, command={"times": [0, 0.05], "speeds": [40, 30]})
    speed, *_ = lsvib.draw(motion).axes
    lines = {line.get_label(): line for line in speed.get_lines()}
    command = lines["command"]
    np.testing.assert_allclose(command.get_ydata(), np.interp(command.get_xdata(), [0, 0.05], [40, 30]))
    assert len(lines["seizure"].get_xdata()) == int((motion.event_normal_impulse != 0).sum()) > 0
    (drawn,) = (line.get_ydata() for line in speed.get_lines() if line.get_label().startswith("_"))
    ends = [motion[f"event_w_{when}"][motion.event_time > 0] for when in ("before", "after")]
    assert sorted(drawn) == sorted(np.concatenate([motion.w, *ends]) + 40)
    (*_, last) = lsvib.draw(DRIVE.simulate({"u": 0.1, "w": 0.0}, 0.05, samples=20)).axes
    assert "samples between events, so peaks are cut off" in last.get_xlabel()


def test_a_branch_has_no_gap_and_its_changes_lie_on_it():
    """Two cycles meet in a fold at 1; of the third sheet, at 0.5 as the first, one change is told."""
    columns = {
        "A": [0, 0.5, 1, 0.5, 0.2, 0.6],
        "along": np.arange(6.0),
        "amplitude": np.arange(1.0, 7),
        "period": np.ones(6),
    }
    dataset = xr.Dataset({name: ("point", np.array(own, float)) for name, own in columns.items()})
    changes = [{"kind": "stability", "value": 0.5, "along": 3.0, "name": "period doubling"}]
    dataset = dataset.assign(attracting=("point", [1, 1, 0, 0, 1, 0])).assign_attrs(changes=json.dumps(changes))
    amplitude, period = lsvib.draw(dataset).axes
    lines = {line.get_label(): line.get_ydata() for line in amplitude.get_lines()}
    drawn = [np.isfinite(lines[name][1:] + lines[name][:-1]) for name in ("attracts", "does not attract")]
    assert np.transpose(drawn).tolist() == [[True, False], *4 * [[False, True]]]
    assert lines["period doubling"].tolist() == [4.0]
    assert period.get_ylim() == pytest.approx((0.9, 1.1))
