"""What the explorer computes and says without a browser: views, links, exports."""

import asyncio
import http.client
import inspect
import math
import random
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import product
from pathlib import Path
from queue import Queue
from urllib.parse import parse_qsl

import numpy as np
import pytest
import yaml
from references.command_line import complaint
from references.drives import DRIVES, PARADOX
from references.sizes import sizes

import lsvib
from lsvib.answers.io import read_dataset
from lsvib.cli.pages import view_of
from lsvib.drives import chapter
from lsvib.drives.model import model_of
from lsvib.drives.scene import Scene
from lsvib.dynamics.curves import Window
from lsvib.explore import answers
from lsvib.explore.view import OF_LAW, View, around
from lsvib.systems.attractor import Attractor
from lsvib.words import plain

WINDOW = Window(-0.15, 0.13, -50.0, 35.0)


def random_view(seed: int) -> View:
    """A view of any drive with numbers of many digits."""
    draw = random.Random(seed)
    kind = draw.choice(list(DRIVES.values()))
    drive = kind(
        mass=draw.uniform(1, 20), axial_force=draw.uniform(-50, 50), support_damping=10 ** draw.uniform(-5, -2)
    )
    u, w = draw.uniform(-0.2, 0.2), draw.uniform(-90, 90)
    window = draw.choice([None, Window(u - draw.random(), u + 1e-3, w - 10 * draw.random(), w + 1e-3)])
    more = {name: draw.random() for name in model_of(drive).states[2:]}
    rest = {"duration": draw.random() + 1e-3, "window": window, "over": "mass", "low": 1 / 3, "high": 7.1}
    return View(drive=drive, u=u, w=w, more=more, **rest)


@pytest.mark.parametrize("seed", range(8))
def test_a_link_gives_the_view_back(seed):
    view = random_view(seed)
    assert View.of(dict(parse_qsl(view.query()))) == view


@pytest.mark.parametrize(
    ("query", "said"),
    [
        ("mass=-1", "mass = -1.0 is outside the allowed range 1e-18 <= mass <= 1e+09 kg."),
        ("u=nan", "u = 'nan' is not a number."),
        ("left=1&right=0&bottom=0&top=1", "window u = 1 to 0 is outside the allowed range low < high"),
        ("left=1", "needs left, right, bottom and top"),
        ("over=mass&low=-3&high=2", "mass = -3"),
    ],
)
def test_a_bad_link_is_refused_in_one_sentence(query, said):
    assert said in complaint(View.of, dict(parse_qsl(query)))


def test_the_map_is_that_of_the_drive():
    cells = (40, 30)
    found = answers.labels(PARADOX, WINDOW, cells)
    grid = {"u": (*WINDOW[:2], cells[0]), "w": (*WINDOW[2:], cells[1])}
    assert (found == PARADOX.attraction(grid).label.values).all()
    assert set(answers.shares(found)) == {Attractor.STEADY_SLIDING, Attractor.SPRAG_SLIP_CYCLE}
    assert math.isclose(sum(answers.shares(found).values()), 1)


def test_the_thresholds_on_the_amplitude_curve():
    view = View(lsvib.Drive(translation_damping=1000), low=10.0, high=60.0)
    assert set(answers.thresholds_over(view)) == {"onset", "stick", "detach"}


def test_the_critical_friction_on_the_page_is_that_of_its_drive():
    """Γ₊ of the rigid drive that is shown vanishes there; the chapter's is that of a drive with axial support."""
    view = View(lsvib.Drive(mass=15), over="friction_coefficient", low=0.1, high=0.4)
    marked = answers.thresholds_over(view)
    exact = view.drive.threshold("kinematic_constraint", "friction_coefficient").value
    assert marked == {"kinematic_constraint": exact}
    sides = [view.drive.replace(friction_coefficient=marked["kinematic_constraint"] * (1 + d)) for d in (-1e-9, 1e-9)]
    assert [drive.stability().kind == "saddle" for drive in sides] == [False, True]


def test_exports_are_the_view(tmp_path):
    view = View(PARADOX, u=0.1, duration=0.05, window=WINDOW)
    (tmp_path / "scene.yaml").write_bytes(answers.export("scene.yaml", view))
    assert Scene.of(yaml.safe_load((tmp_path / "scene.yaml").read_text(encoding="utf-8"))) == view.scene()
    (tmp_path / "motion.nc").write_bytes(answers.export("motion.nc", view))
    opened = view_of(tmp_path / "scene.yaml")
    assert (opened.drive, opened.scene()) == (view.drive, view.scene())
    motion = read_dataset(tmp_path / "motion.nc")
    assert motion.sizes["time"] == view.scene().samples
    own = PARADOX.simulate({"u": 0.1, "w": 0.0}, 0.05, samples=2001)
    assert (motion.u.values == own.u).all()
    assert motion.mass == 11


@pytest.mark.slow
def test_a_sheet_opens_with_the_motion_of_its_report(monkeypatch):
    """Of this one it starts with the screw off its place; from u and w alone it would come to slide steadily."""
    assessment = pytest.importorskip("lsvib.sheets.assessment", exc_type=ImportError)
    assess, told = assessment.assess, []
    monkeypatch.setattr(assessment, "assess", lambda *of, **more: told.append(assess(*of, **more)) or told[0])
    view = view_of(Path(__file__).parents[2] / "examples" / "positioning_slide.yaml")
    end, motion = answers.followed(view).steady, told[0].nominal.vibration
    assert (view.scene().start, plain(end.label)) == (motion.scene["start"], motion.attractor)
    assert 1 / end.period == pytest.approx(motion.frequency, rel=1e-9)
    page = page_of(view)
    page._say_words()
    assert f"{1e6 * motion.amplitude:.4g} µm at the load" in page._words.text
    assert f"({motion.frequency:.4g} Hz)" in page._words.text
    assert answers.followed(replace(view, more={})).steady.label == Attractor.STEADY_SLIDING


@pytest.mark.slow
def test_a_sheet_opens_with_the_friction_of_its_flanks_explained():
    pytest.importorskip("lsvib.sheets.assessment", exc_type=ImportError)
    view = view_of(Path(__file__).parents[2] / "examples" / "machine_slide.yaml")
    assert view.note.startswith(f"Friction coefficients are {view.drive.friction_coefficient / 0.15:.4g} times those")
    page = page_of(view)
    page._say_words()
    assert page._words.text.endswith("its flanks slope, and the equations are for a square thread.")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("modes: {}", "draw it with"),
        ("{drive: {}, start: {u: 0, w: 1}, duration: 1, command: {times: [0, 1], speeds: [0, 40]}}", "the command of"),
        (
            "{drive: {}, start: {u: 0, w: 1}, duration: 1, physics: [axial_force, support_damping]}",
            "the physics of",
        ),
        ("mass: 3", "mass is not a known key"),
    ],
)
def test_a_file_that_cannot_be_shown_is_refused_in_one_sentence(text, said, tmp_path):
    (tmp_path / "own.yaml").write_text(text)
    assert said in complaint(view_of, tmp_path / "own.yaml")


def test_a_bad_port_is_refused_in_one_sentence():
    said = "lsvib: port = 99999 is outside the allowed range 0 <= port <= 65535.\n"
    assert refusal("explore", "--no-show", "--port", "99999") == said


def test_without_bokeh_the_command_says_what_to_install():
    said = refusal("explore", "--no-show", before="import sys; sys.modules['bokeh'] = None; ")
    assert said == "lsvib: lsvib explore needs bokeh, which is not installed: pip install 'lsvib[explore]'.\n"


def refusal(*arguments: str, before: str = "") -> str:
    program = f"{before}from lsvib.cli.app import main; main()"
    done = subprocess.run([sys.executable, "-c", program, *arguments], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    return done.stderr


@pytest.fixture(scope="module")
def port():
    pytest.importorskip("bokeh")
    command = [sys.executable, "-m", "lsvib", "explore", "--no-show", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        yield int(re.search(r"localhost:(\d+)/", process.stdout.readline()).group(1))
        process.terminate()


def answered(port: int, path: str, host: str = "localhost:{}", **headers: str) -> tuple[int, str]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    connection.request("GET", path, headers={"Host": host.format(port), **headers})
    answer = connection.getresponse()
    text = "" if answer.status == 101 else answer.read().decode()
    connection.close()
    return answer.status, text


@pytest.mark.parametrize("path", ["/", "/?mass=9", "/export/scene.yaml", "/static/js/bokeh.min.js", "/ws", "/metadata"])
def test_only_this_machine_is_served(port, path):
    """A page of another site whose name is rebound to this machine is one of another host, whatever it asks for."""
    for host in ("elsewhere.org:{}", "elsewhere.org", "localhost", "localhost:1"):
        assert answered(port, path, host) == (403, "The explorer answers to localhost and 127.0.0.1 only.")
    assert answered(port, path)[0] == (400 if path == "/ws" else 200)


def test_a_light_request_beside_heavy_ones_is_answered_in_a_second(port):
    heavy = [
        "/?duration=100000&mass=11&support_damping=0.001&axial_force=-10&u=0.1",
        "/export/motion.nc?duration=100000&mass=11&support_damping=0.001&axial_force=-10&u=0.1",
        "/export/motion.nc?duration=1&u=0.1&translation_damping=1e15&friction_slope=-1e-5",
    ]
    answered(port, heavy[2])  # which compiles what a friction law needs
    with ThreadPoolExecutor(3) as threads:
        asked = [threads.submit(answered, port, path) for path in heavy]
        began = time.monotonic()
        assert answered(port, "/metadata")[0] == 200
        assert time.monotonic() - began < 1.5
    given = [one.result() for one in asked]
    assert [status for status, _ in given] == [200, 400, 400]
    assert all("takes too long for a page; shorten it" in text for _, text in given[1:])


@pytest.mark.slow
def test_pages_are_limited(port):
    """A page of another site may make a browser load this one as often as it likes."""
    with ThreadPoolExecutor(20) as threads:
        given = list(threads.map(lambda _: answered(port, "/"), range(20)))
    assert any("<title>Too many pages of the explorer are open" in text for _, text in given)
    assert answered(port, "/export/scene.yaml")[0] == 200


def test_a_browser_may_call_this_machine_by_name_or_number(port):
    """The page comes to life over a socket, which its server opens to pages of its own address alone."""
    from bokeh.util.token import generate_jwt_token

    socket = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "x"}
    socket["Sec-WebSocket-Protocol"] = f"bokeh, {generate_jwt_token('any')}"
    for host, answer in (("localhost", 101), ("127.0.0.1", 101), ("elsewhere.org", 403)):
        assert answered(port, "/ws", **socket, Origin=f"http://{host}:{port}")[0] == answer


LAW = {"stribeck_rise": 0.0203, "stribeck_speed": 0.013704, "friction_slope": -0.0859}


def test_a_view_with_a_friction_law_follows_it():
    """Its map and the coefficient that is drawn are those of the drive; its closed forms are not used."""
    drive = lsvib.Drive(axial_force=100, input_speed=10, **LAW)
    view = View(drive, u=0.0, w=-9.0, duration=0.2)
    assert View.of(dict(parse_qsl(view.query()))) == view
    assert answers.at_once(lsvib.Drive())
    assert not answers.at_once(drive)
    shown = answers.followed(view)
    assert shown.steady.label == Attractor.STICK_SLIP_CYCLE
    window, cells = answers.window_around(drive, shown), (6, 4)
    grid = {"u": (*window[:2], cells[0]), "w": (*window[2:], cells[1])}
    assert (answers.labels(drive, window, cells) == drive.attraction(grid).label.values).all()
    speeds, coefficients, visited = answers.friction_visited(drive, shown)
    expected = 0.218 + 0.0203 * math.e ** (-speeds / 0.013704) - 0.0859 * speeds
    assert coefficients == pytest.approx(expected, rel=1e-12)
    fastest = drive.pitch_radius / math.cos(drive.lead_angle) * (shown.w + 10).max()
    assert (speeds[visited].min(), speeds[visited].max()) == (0.0, pytest.approx(fastest, rel=1e-12))


def test_every_parameter_of_a_law_can_be_moved_and_varied():
    """All have a field and a slider that show their value, and a range of the amplitude curve that is accepted."""
    pytest.importorskip("bokeh")
    from lsvib.explore.controls import Controls

    view = View(lsvib.Drive(static_friction_coefficient=0.45, **LAW))
    controls = Controls(view, lambda key, text: None)
    for key, (low, high) in OF_LAW.items():
        assert float(controls.fields[key].value) == controls.sliders[key].value == getattr(view.drive, key)
        assert (controls.sliders[key].start, controls.sliders[key].end) == (low, high)
        assert View(view.drive, over=key, **around(view.drive, key)).over == key
    dry = lsvib.Drive(slide_friction=5, slide_static_friction=8)
    assert View(dry, over="slide_static_friction", **around(dry, "slide_static_friction")).low == 5.0
    controls.show(View())
    assert "stribeck_rise" not in controls.fields
    controls.all.active = [0]
    assert controls.sliders["stribeck_rise"].value == float(controls.fields["stribeck_rise"].value) == 0


def page_of(view: View):
    pytest.importorskip("bokeh")
    from bokeh.document import Document

    from lsvib.explore.page import Page

    answers.READY.update(product((False, True), repeat=3))
    page = Page(Document(), view)
    page._answer()
    return page


def settled(page):
    """The colours of the map when what takes longer is done, too; what a server would call is called here."""
    page.document.add_next_tick_callback = (ticks := []).append
    page._settle()
    for each in ticks:  # they add others
        if inspect.isawaitable(found := each()):
            asyncio.run(found)
    return set(page.plots.sources["map"].data["image"][0].ravel().tolist())


def test_a_page_with_a_friction_law_opens(monkeypatch):
    monkeypatch.setattr(answers, "COARSE", (6, 4))
    monkeypatch.setattr(answers, "values_of", lambda view, count: [view.drive.axial_force])
    page = page_of(View(lsvib.Drive(axial_force=100, input_speed=10, **LAW), w=-9.0, duration=0.2))
    colours = settled(page)
    words = page._words.text
    assert "0 to 0.126 m/s, with a friction coefficient of 0.207 to 0.238." in words  # 0.218 - 0.0859 * 0.126
    assert colours == set(answers.rgba(answers.labels(page.view.drive, page.view.window, (6, 4))).ravel().tolist())
    assert (page._alert.text, "Of 1 drives" in page._words.text) == ("", True)
    assert len(page.plots.sources["near"].data["x"]) == len(page.plots.sources["curve"].data["x"]) == 1
    assert page.shown.steady.label == Attractor.STICK_SLIP_CYCLE
    assert max(page.plots.sources["law"].data["y"]) == pytest.approx(0.2383, rel=1e-12)


@pytest.mark.parametrize("part", sizes(["nut"], ["support"]))
def test_a_drive_with_compliant_parts_and_a_law_is_followed_without_its_map(part, monkeypatch):
    """The page says so, and draws the curve; a rotating nut slides at the speed at which the screw turns in it."""
    monkeypatch.setattr(answers, "values_of", lambda view, count: [view.drive.axial_force])
    page = page_of(View(DRIVES[part](axial_force=100, input_speed=10, **LAW), w=-9.0, duration=0.05))
    assert settled(page) == {answers.rgba(np.array([-2]))[0]}
    assert "No map is shown" in page._words.text
    assert len(page.plots.sources["near"].data["x"]) == 1
    motion = page.view.drive.simulate({"u": 0.0, "w": -9.0}, 0.05, samples=2001)
    if part == "nut":
        turning = 10 + motion.w.values - motion.nut_rate.values
        per_turn = page.view.drive.pitch_radius / math.cos(page.view.drive.lead_angle)
        assert np.abs(page.shown.sliding).max() == pytest.approx(per_turn * np.abs(turning).max(), rel=1e-3)


@pytest.mark.parametrize("work", ["labels", "thresholds_over", "curves"])
def test_an_answer_that_comes_when_the_drive_has_changed_is_not_shown(work, monkeypatch):
    """Nothing remains of the drive before either: no amplitude, threshold, share or link."""
    page, finished = page_of(View(PARADOX, u=0.02, low=-20.0, high=-5.0)), getattr(answers, work)
    settled(page)
    assert page._said.styles["visibility"] == "visible"
    assert len(page.plots.sources["near"].data["x"]) == 61

    def overtaken(*of):
        found = finished(*of)
        monkeypatch.undo()
        page.ask("mass", "9")
        page._answer()
        return found

    monkeypatch.setattr(answers, work, overtaken)
    settled(page)
    assert (page.view.drive.mass, page._shares) == (9, {})
    own = answers.rgba(answers.labels(page.view.drive, page.view.window, answers.DRAGGED))
    assert np.array_equal(page.plots.sources["map"].data["image"][0], own)
    assert not any(len(page.plots.sources[name].data["x"]) for name in ("near", "curve", "marks", "bar"))
    assert page._said.styles["visibility"] == "hidden"


@pytest.mark.parametrize(
    ("key", "text", "parts", "mass", "said"),
    [("mass", "9", ("threads",), 9, ""), ("duration", "-1", (), 11, "outside the allowed range")],
)
def test_a_page_says_that_it_compiles(key, text, parts, mass, said, monkeypatch):
    """Nothing remains of the drive before; what was asked meanwhile is answered too, or the drive before is back."""
    page, ticks = page_of(View(PARADOX, u=0.02)), Queue()
    settled(page)
    page.document.add_next_tick_callback = ticks.put
    monkeypatch.setattr(answers, "READY", ready := {answers.kind_of(PARADOX)})
    monkeypatch.setattr(answers, "make_ready", lambda view: ready.add(answers.kind_of(view.drive)))
    page.ask("parts", "threads")
    page._answer()
    assert ("compiled" in page._alert.text, page._said.styles["visibility"]) == (True, "hidden")
    assert all(np.size(page.plots.sources[name].data["x"]) == 0 for name in ("map", "lines", "near", "history", "bar"))
    page.ask(key, text)
    ticks.get(timeout=5)()
    assert (page.view.drive.parts, page.view.drive.mass) == (parts, mass)
    assert (said in page._alert.text, bool(page._alert.text)) == (True, bool(said))
    assert len(page.plots.sources["history"].data["x"]) > 1


def test_parts_are_put_in_and_taken_out():
    """Those that are new have the values of the chapter; the parameter of the curve goes with its part."""
    page = page_of(View(drive=PARADOX, u=0.02))
    page.ask("parts", "support threads")
    page._answer()
    assert page.view.drive.parts == ("support", "threads")
    assert dict(page.view.drive).items() > (chapter.PARTS["threads"] | chapter.PARTS["support"]).items()
    assert page.controls.parts.active == [1, 3]
    page.ask("over", "support_stiffness")
    page._answer()
    page.ask("parts", "threads")
    page._answer()
    assert page.view.drive.parts == ("threads",)
    assert page.view.over == "axial_force"
    assert "support_stiffness" not in page.controls.fields
    page.ask("slider:static_friction_coefficient", "0.4")  # whose slider has been hidden meanwhile
    page._answer()
    assert page.view.drive.static_friction_coefficient == 0.4
