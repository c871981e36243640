"""Motor and brake as limits, moves and what a ramp leaves, against integrals over time and closed forms."""

import math

import numpy as np
import pytest

import lsvib
from lsvib.sheets.assessment import assess
from lsvib.sheets.draw import Draw
from lsvib.sheets.output import as_json
from lsvib.sheets.report import report
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import statics

MOVE = {"distance": "200 mm", "speed": "100 mm/s", "acceleration_time": "0.1 s"}
BASE = {
    "name": "a lift", "thread": {"lead": "10 mm", "pitch_diameter": "16 mm"}, "friction": {"coefficient": 0.1},
    "load": {"mass": "10 kg", "orientation": "vertical"}, "operation": {"speed": "300 rpm"},
    "screw": {"inertia": "4e-5 kg*m^2"}, "coupling": {"stiffness": "200 N*m"}, "damping": {"rotational": "1 mN*m*s"},
}  # fmt: skip


def sheet(**changes) -> Sheet:
    return Sheet.of({**BASE, **changes})


def over_time(v: dict[str, float], profile: str) -> dict[str, float]:
    """What a cycle out and back takes of the motor, by the balance of forces on the flanks, at 20,000 even times."""
    at, way = np.linspace(0, v["time"], 20_001)[1:] - v["time"] / 40_000, np.array([[1], [-1]])
    part = np.clip(np.minimum(at, v["time"] - at) / v["ramp"], 0.0, 1.0)
    share = np.where(part < 0.5, 2 * part**2, 1 - 2 * (1 - part) ** 2) if profile == "s-curve" else part
    a, travel, angle = np.gradient(share, at) * v["speed"], v["lead"] / (2 * math.pi), math.atan(v["steep"] / math.pi)
    axial = way * v["force"] + v["guide"] + v["mass"] * a
    mu = np.sign(axial) * v["mu"]
    normal = axial / (math.cos(angle) - mu * math.sin(angle))
    torque = normal * (math.sin(angle) + mu * math.cos(angle)) * 0.5 * v["d"] + v["J"] * a / travel
    motor = torque * v["eta"] ** -np.sign(torque) / v["i"] + v["Jm"] * v["i"] * a / travel
    work = (np.clip(motor, 0, None) * v["i"] * share * v["speed"] / travel).mean() * 2 * v["time"]
    return {"rms_torque": np.sqrt((motor**2).mean()), "cycle_energy": work, "peak_torque": np.abs(motor).max()}


NAMES = ("d", "steep", "mu", "mass", "force", "rubs", "J", "Jm", "i", "eta", "speed", "time", "part", "limit")
LOW = np.array([6e-3, 0.2, 0.01, 0.1, 1, 0.01, 1e-6, 1e-6, 1, 0.6, 0.01, 0.5, 0.05, 0.3])
HIGH = np.array([0.03, 1, 0.2, 100, 1000, 0.3, 1e-4, 1e-4, 5, 1, 1, 5, 0.5, 3])
SHEET = """{{name: drawn, thread: {{lead: {lead} m, pitch_diameter: {d} m}}, friction: {{coefficient: {mu}}},
load: {{mass: {mass} kg, force: {force} N}}, guide: {{friction: {guide} N}}, screw: {{inertia: {J} kg*m^2}},
coupling: {{gear_ratio: {i}}}, motor: {{inertia: {Jm} kg*m^2, peak_torque: {limit} N*m, gear_efficiency: {eta}}},
operation: {{move: {{speed: {speed} m/s, distance: {distance} m, acceleration_time: {ramp} s, profile: {profile},
back: true}}}}}}"""


@pytest.mark.parametrize("seed", range(30))
def test_random_moves_take_what_an_integral_over_time_says(seed, tmp_path):
    rng, profile = np.random.default_rng([71, seed]), ("trapezoid", "triangle", "s-curve")[seed % 3]
    v = dict(zip(NAMES, LOW * (HIGH / LOW) ** rng.random(14), strict=True))
    v["ramp"] = v["time"] * (0.5 if profile == "triangle" else v["part"])
    v["lead"], v["guide"] = v["d"] * v["steep"], v["force"] * v["rubs"]
    wanted, distance = over_time(v, profile), v["speed"] * (v["time"] - v["ramp"])
    v["limit"], weak = v["limit"] * wanted["peak_torque"], v["limit"] < 1
    (tmp_path / "a.yaml").write_text(SHEET.format(**v, profile=profile, distance=distance), encoding="utf-8")
    found = lsvib.assess(tmp_path / "a.yaml", None)
    assert {key: found["statics"][key]["worst"] for key in wanted} == pytest.approx(wanted, rel=2e-3)
    assert found["verdict"] == ("motor too weak" if weak else None)
    assert {"motor is too weak" in found["brief"][0], "exceeded: " in " ".join(found["brief"])} == {weak}


@pytest.mark.parametrize("more", [{}, {"damping": {"rotational": "5e-3 N*m*s/rad"}}, {"load": {"force": "-200 N"}}])
def test_up_to_the_highest_speed_the_curve_is_enough(more):
    gear, load = {"gear_ratio": 1.5}, {"mass": ["12 kg", "15 kg"], "orientation": "vertical"}
    motor = {
        "gear_efficiency": 0.9,
        "torque_curve": [["0 rpm", "0.5 N*m"], ["600 rpm", "0.4 N*m"], ["3000 rpm", "0.05 N*m"]],
    }
    given = {"motor": motor, "coupling": gear, "load": {**load, "force": ["0 N", "50 N"]}, **more}
    for way, most in statics(sheet(**given)).highest_speed.items():
        for factor in (1 - 1e-4, 1 + 1e-4):
            speed = {"speed": f"{factor * most['load_speed']} m/s", "direction": way}
            assert statics(sheet(**given, operation=speed)).rows["motor_torque"].exceeded == (factor > 1)


WEAK = "The motor is too weak: moving the load takes 271 mN m at the motor, which gives"  # 8 mm · mg tan(λ + ρ) + c Ω
MAY = "The motor may be too weak: within the given uncertainties moving the load takes up to 314 mN m at the motor"
HOLDS = "The brake is too weak: holding the load without current takes 76.1 mN m, but it holds 50 mN m at most. What"
BOTH = {"rated_torque": "0.2 N*m", "torque_curve": [["0 rpm", "1 N*m"], ["999 rpm", "1 N*m"]]}
GIVES, STEPPER = {"motor": {"rated_torque": "0.28 N*m"}}, {"inertia": "5e-5 kg*m^2", "holding_torque": "0.6 N*m"}


@pytest.mark.parametrize(
    ("more", "verdict", "first"),
    [({"motor": STEPPER | {"holding_torque": "0.1 N*m"}}, "motor too weak", f"{WEAK} 100 mN m at most. What follows"),
     ({"motor": {"torque_curve": [["1 rpm", "1 N*m"], ["299 rpm", "1 N*m"]]}}, "motor too weak", f"{WEAK} nothing at"),
     (GIVES | {"friction": {"coefficient": [0.05, 0.15]}}, "motor may be too weak", MAY),
     ({"motor": BOTH}, "motor too weak", f"{WEAK} 200 mN m at most"),
     ({"motor": BOTH, "operation": {"move": MOVE | {"pause": "9 s"}}}, "steady", "This"),
     ({"brake": {"torque": "0.05 N*m"}}, "brake too weak", HOLDS), ({"motor": STEPPER}, "steady", "This drive runs"),
     (GIVES | {"brake": {"torque": "0.08 N*m"}}, "steady", "This drive runs steadily")],
)  # fmt: skip
def test_what_is_too_weak_is_said_first(more, verdict, first):
    found = assess(sheet(**more), samples=64)
    told, page = as_json(found), " ".join(report(found, []).split())
    assert (told["verdict"], told["vibration"], told["brief"][0][: len(first)]) == (verdict, "steady", first)
    assert all(text in page for text in (first, *told["brief"][4:]))
    assert ("holding torque at every speed" in page) == ("holding_torque" in more.get("motor", ()))
    assert ("about half the torque that it can give; in steady running it must" in page) == ("100 mN m" in first)


@pytest.mark.parametrize("back", [False, True])
def test_a_ramp_leaves_the_swing_of_an_oscillator(back):
    """After a step of the acceleration by a it swings by a (1 − cos ω t) / ω²; turned back at once, the sum of four."""
    free, travel = {"friction": {"coefficient": 0}, "damping": {}, "load": {"mass": "10 kg"}}, 0.01 / (2 * math.pi)
    found = assess(sheet(**free, operation={"move": MOVE | {"back": back}}), 64).ripple
    inertia, steps = 4e-5 + 10 * travel**2, {0: 1, 0.1: -1, 1.1: -back, 1.3: back}
    rate, at = math.sqrt(200 / inertia), np.linspace(0, 2.4, 400_000)
    swings = sum(sign * (1 - np.cos(rate * (at - t))) * (at > t) for t, sign in steps.items())
    assert found.coupling_torque == pytest.approx(inertia / travel * np.abs(swings).max(), rel=1e-4)
    assert found.peak_to_peak == pytest.approx(4 * abs(math.sin(0.05 * rate)) / rate, rel=1e-3)


def test_a_guide_rubs_by_the_weight_on_it():
    """THK, ball screws, high-speed transfer: 0.003 · 80 kg · g + 15 N; with another mass it is another friction."""
    guide, loads = {"coefficient": 0.003, "friction": "15 N"}, ({"mass": "80 kg"}, {"mass": "160 kg"})
    one, two = (Draw.of(sheet(load=load, guide=guide)) for load in loads)
    assert one.values["slide_friction"] == pytest.approx(17.35, abs=5e-3)
    assert one.scaled(["mass"], 2.0).values == pytest.approx(two.values)


@pytest.mark.parametrize(
    ("part", "entry", "unit", "row"),
    [("motor", "inertia", "e-5 kg*m^2", "peak_torque"), ("motor", "gear_efficiency", "0 %", "motor_torque"),
     ("guide", "coefficient", "0 %", "motor_torque"), ("move", "distance", "00 mm", "rms_torque"),
     ("move", "pause", " s", "rms_torque"), ("move", "speed", "0 mm/s", "load_speed"),
     ("move", "acceleration_time", "00 ms", "acceleration_torque"), ("brake", "torque", " N*m", "brake_torque")],
)  # fmt: skip
def test_three_times_an_entry_is_seen(part, entry, unit, row):
    rows, load = [], {"mass": "10 kg", "orientation": "30 deg"}
    for factor in (1, 3):
        given = {"motor": {"rated_torque": ["1 N*m", "2 N*m"]}, "move": MOVE, "guide": {"friction": "1 N"}}
        given[part] = {**given.get(part, {}), entry: f"{factor}{unit}"}
        rows.append(statics(sheet(operation={"move": given.pop("move")}, load=load, **given)).rows[row])
    assert (rows[0].worst, rows[0].limit) != (rows[1].worst, rows[1].limit)
