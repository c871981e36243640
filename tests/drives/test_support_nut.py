"""Axial support and rotating nut against the linear models, their rigid limits, balances, and an independent reference.

The reference (``reference/two_bodies_steps.py``) takes Newton's laws with the normal force and the friction as
unknowns, advances by Taylor series with a fixed step of 2 µs and finds the mode after each event by trying all of them;
where Γ₊ > 0 it insists that exactly one is consistent. It is good to some 1e-11, the rounding of 1e4 steps.
"""

import math

import mpmath
import numpy as np
import pytest
from references.two_bodies_steps import SteppedDrive, simulate

import lsvib
from references import two_bodies_digits
from lsvib.drives.parameters import NutParameters, RigidParameters, SupportParameters
from lsvib.drives.registry import find_model
from lsvib.drives.rigid import rigid_automaton
from lsvib.drives.second_body.nut import NutEvent, NutMode
from lsvib.drives.second_body.support import SupportEvent, SupportMode
from lsvib.engine.kernels import columns, dispatch
from lsvib.engine.kernels.status import FIRST_MODEL_KIND
from lsvib.engine.motion import enter, follow
from lsvib.errors import InputError
from lsvib.steady_sliding import linearised

KINDS = {"support": (SupportParameters, SupportMode), "nut": (NutParameters, NutMode)}
MODELS = sorted(KINDS)
EVENTS = {"support": SupportEvent, "nut": NutEvent}
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)
FRICTIONS = ("slide_friction", "bearing_friction")
WORDS = {"forward": 1, "backward": -1, "positive": 1, "negative": -1, "held": 0}
LOADED = {"mass": 1.0, "translation_damping": 1000.0, "axial_force": 40.0}
RUBBED = {
    "support": {**LOADED, "screw_mass": 3.0, "slide_friction": 8.0, "bearing_friction": 0.02},
    "nut": {**LOADED, "slide_friction": 8.0, "bearing_friction": 0.02},
}
PARADOX = {
    "support": {"mass": 15.0, "screw_mass": 50.0, "support_damping": 1e-3},
    "nut": {"mass": 11.0, "support_damping": 1e-3},
}
STIFF = {"screw_mass": 3.0, "support_stiffness": 1e8, "axial_support_damping": 2e4}
LEAST = {"support": (1e-2, 1.0, 1e-7, 1e-4), "nut": (1e-2, 1.0, 1e-2, 1.0)}
START = (0.1, 0.0, 0.0, 0.0)


def build(model, slide=False, bearing=False, **parameters):
    """Drive, automaton and reference of one set of parameters."""
    drive = KINDS[model][0].of(parameters)
    frictions = tuple(name for name, there in zip(FRICTIONS, (slide, bearing), strict=True) if there)
    automaton = find_model(model).build(drive, frictions, "contact_sign")
    return drive, automaton, SteppedDrive(model, dict(drive), frictions)


def key_of(model, automaton, mode):
    """Mode in the words of the reference: (direction of slip, sign of N, direction of the second body)."""
    words = KINDS[model][1](int(automaton.codes[mode])).name.lower().split("_")
    numbers = [WORDS[word] for word in words if word in WORDS]
    if words[0] == "slip":
        return numbers[0], numbers[1], (numbers[2] if len(numbers) > 2 else None)
    side = numbers.pop(0) if words[1:2] and words[1] in ("positive", "negative") else 0
    return 0, side, (numbers[0] if numbers else None)


def random_scene(rng):
    """Damped, loaded drives turning either way, with and without F_0 and T_0, on both sides of Γ₊ = 0, and a start.

    Returns model, slide, bearing, parameters, start. F_0 comes with a light screw and T_0 with a light nut: the models
    refuse the others.
    """
    model, (slide, bearing) = MODELS[rng.integers(2)], rng.integers(2, size=2).tolist()

    def between(low, high):
        return float(10 ** rng.uniform(low, high))

    parameters = {
        "mass": between(-0.5, 0.4) if bearing and model == "nut" else between(-0.5, 1.6),
        "friction_coefficient": rng.uniform(0.05, 0.4),
        "axial_force": float(rng.choice([-1, 1])) * between(0, 2.3),
        "input_speed": float(rng.choice([-1, 1])) * rng.uniform(2, 60),
        "support_damping": between(-4.5, -2.5),
        "translation_damping": rng.integers(2) * rng.uniform(50, 2000),
        "slide_friction": slide * between(0.5, 2.3),
        "bearing_friction": bearing * between(-2.5, 0),
    }
    if model == "support":
        parameters |= {
            "screw_mass": between(-1, 0.4) if slide else between(0, 3),
            "support_stiffness": between(4, 7),
            "axial_support_damping": rng.integers(2) * rng.uniform(10, 1000),
        }
        own = rng.uniform(-1e-4, 1e-4), rng.uniform(-0.05, 0.05)
    else:
        parameters |= {
            "nut_inertia": between(-5.5, -4.5),
            "nut_stiffness": between(-1, 2),
            "nut_damping": between(-5, -2),
        }
        own = rng.uniform(-0.1, 0.1), rng.uniform(-50, 50)
    return model, slide, bearing, parameters, (rng.uniform(-0.4, 0.4), rng.uniform(-100, 100), *own)


def random_motions(seed, count):
    """Models and starts that are not refused: scene, automaton, reference."""
    rng = np.random.default_rng(seed)
    while count:
        scene = random_scene(rng)
        model, slide, bearing, parameters, _ = scene
        try:
            _, automaton, reference = build(model, slide, bearing, **parameters)
        except InputError:
            continue
        yield scene, automaton, reference
        count -= 1


def size_of(motion):
    """Largest coordinates at events and ends, but no less than what steady sliding is resolved to."""
    size = np.abs(np.vstack([motion.before, motion.after, motion.start_state, motion.end_state])).max(axis=0)
    return np.maximum(size, LEAST["nut" if "nut_angle" in motion.automaton.states else "support"])


def compare(model, automaton, reference, start, t_end):
    """Follow both; same modes after the events, and errors of times [s] and of the final state (relative)."""
    motion = follow(automaton, start, t_end, max_events=3000)
    end, _, events = simulate(reference, start, t_end, 2e-6)
    ours = motion.kind >= FIRST_MODEL_KIND
    assert [key_of(model, automaton, mode) for mode in motion.mode[ours]] == [event.mode_after for event in events]
    late = np.abs(motion.time[ours] - [event.time for event in events]).max(initial=0.0)
    return motion, late, np.max(np.abs(motion.end_state - end) / size_of(motion))


@pytest.mark.parametrize("force", [50.0, -50.0])
@pytest.mark.parametrize("model", MODELS)
def test_steady_sliding_is_the_linear_model(model, force):
    """The field around steady sliding is the state matrix of steady_sliding/linearised.py, without a constant."""
    own = {"axial_support_damping": 30.0} if model == "support" else {"nut_inertia": 5e-6, "nut_stiffness": 3.0}
    parameters = {**own, "mass": 1.5, "translation_damping": 70.0, "axial_force": force}
    drive, automaton, _ = build(model, **parameters)
    mode, _ = enter(automaton, np.zeros(4))
    law = linearised.steady_law(drive)
    assert key_of(model, automaton, mode) == (1, law, None)
    expected = getattr(linearised, f"{model}_model")(drive, law).jacobian()
    field = automaton.tables.flow.field[mode]
    np.testing.assert_allclose(field[:, :4], expected, rtol=1e-13, atol=0)
    assert np.abs(field[:, 4]).max() <= 1e-30
    rows = automaton.tables.flow.oscillators[mode]
    found = np.concatenate([np.roots([1, row[columns.A1], row[columns.A0]]) for row in rows if row[columns.A0]])
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(np.linalg.eigvals(expected)), rtol=1e-10)


@pytest.mark.parametrize(
    "parameters",
    [LOADED, {"mass": 11.0, "axial_force": -10.0, "support_damping": 1e-3}, {"mass": 15.0, "support_damping": 1e-3}],
    ids=["stick-slip", "Painlevé, R < 0", "Painlevé"],
)
@pytest.mark.parametrize(
    ("model", "key", "large"), [("support", "screw_mass", (1e6, 1e9)), ("nut", "nut_inertia", (1.0, 1e3))]
)
def test_heavy_body_gives_the_rigid_drive(model, key, large, parameters):
    """m_1 → ∞, I_2 → ∞: the screw cannot shift, the nut cannot turn; with seizures, and to first order."""
    rigid = follow(rigid_automaton(RigidParameters.of(parameters)), START[:2], 0.03)
    times, errors = np.linspace(0, 0.03, 2001), []
    expected = rigid.at(times)[0][:, 0]
    for value in large:
        motion = follow(build(model, **parameters, **{key: value})[1], START, 0.03)
        np.testing.assert_array_equal(motion.kind, rigid.kind)
        errors.append(np.abs(motion.at(times)[0][:, 0] - expected).max() / np.abs(expected).max())
    assert errors[0] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(large[1] / large[0], rel=0.01)


@pytest.mark.parametrize("parameters", [{"mass": 1.0}, LOADED], ids=["one stick", "stick-slip"])
@pytest.mark.parametrize("model", MODELS)
def test_stiff_support_gives_the_rigid_drive(model, parameters):
    """k_1 → ∞ (with a light screw), k_2 → ∞, each with a damper near its critical value: first order in 1/k."""
    times, errors = np.linspace(0, 0.03, 2001), []
    expected = follow(rigid_automaton(RigidParameters.of(parameters)), START[:2], 0.03).at(times)[0][:, 0]
    for stiffness in (1e10, 1e12):
        own = {"support_stiffness": stiffness, "screw_mass": 0.1, "axial_support_damping": math.sqrt(0.1 * stiffness)}
        if model == "nut":
            own = {"nut_stiffness": 1e-4 * stiffness, "nut_damping": math.sqrt(3e-10 * stiffness)}
        found = follow(build(model, **parameters, **own)[1], START, 0.03).at(times)[0][:, 0]
        errors.append(np.abs(found - expected).max() / np.abs(expected).max())
    assert errors[1] < 2e-6
    assert 60 < errors[0] / errors[1] < 170


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("slide", [False, True])
@pytest.mark.parametrize("bearing", [False, True])
def test_stick_slip_against_the_reference(model, slide, bearing):
    parameters = RUBBED[model] if slide or bearing else LOADED
    _, automaton, reference = build(model, slide, bearing, **parameters)
    motion, late, error = compare(model, automaton, reference, START, 0.1)
    assert len(motion.time) >= 2
    assert late <= 1e-13
    assert error <= 1e-10


@pytest.mark.parametrize("force", [50.0, -20.0])
@pytest.mark.parametrize("model", MODELS)
def test_seizures_against_the_reference(model, force):
    _, automaton, reference = build(model, **PARADOX[model], axial_force=force)
    motion, late, error = compare(model, automaton, reference, START, 0.05)
    assert np.sum(motion.kind == EVENTS[model].SEIZURE) >= 1
    assert late <= 1e-13
    assert error <= 1e-10


@pytest.mark.parametrize("scene", ["rubbed", "paradox"])
@pytest.mark.parametrize("model", MODELS)
def test_closed_form_of_the_reference_against_its_steps(model, scene):
    """The reference in closed form, of which errors in the sweeps are taken, against the one in steps of 2 µs."""
    rubbed = scene == "rubbed"
    drive, _, reference = build(model, rubbed, rubbed, **(RUBBED if rubbed else PARADOX)[model])
    end, _, events = simulate(reference, START, 0.02, 2e-6)
    exact = two_bodies_digits.simulate(dict(drive), model, FRICTIONS if rubbed else (), START, 0.02)
    assert len(events) >= 1
    assert [(e.mode_after, e.seizure) for e in exact.events] == [(e.mode_after, e.seizure) for e in events]
    size = np.maximum(np.abs(np.array([e.state for e in events])).max(axis=0), LEAST[model])
    assert np.all(np.abs(np.array(exact.state, dtype=float) - end) <= 1e-10 * size)


def check_random_motions(seed, count):
    visited = {model: set() for model in MODELS}
    for (model, *_, start), automaton, reference in random_motions(seed, count):
        motion, late, error = compare(model, automaton, reference, start, 0.03)
        visited[model] |= {key_of(model, automaton, mode) for mode in motion.mode}
        # The largest errors seen in some 2000 motions were 3e-13 s and 3e-10.
        assert late <= 1e-11, (model, dict(reference.p), start)
        assert error <= 1e-9, (model, dict(reference.p), start)
    return visited


@pytest.mark.slow
def test_random_motions_against_the_reference():
    visited = check_random_motions(1, 40)
    for model in MODELS:
        rests = {(0, side, a) for side in ((1, -1) if model == "support" else (0,)) for a in (None, 1, -1)}
        slips = {(d, q, a) for d in (1, -1) for q in (1, -1) for a in (None, 1, -1)}
        assert rests | slips <= visited[model]
        assert len({mode for mode in visited[model] if mode[2] == 0}) >= 3


@pytest.mark.long
def test_many_more_random_motions_against_the_reference():
    assert all(check_random_motions(2, 1500).values())


@pytest.mark.parametrize("model", MODELS)
def test_start_at_rest_finds_the_one_consistent_mode(model):
    """Threads and second body both at rest, any deflection: the engine's order of tests against trial of all modes."""
    rng = np.random.default_rng(3)
    _, automaton, reference = build(model, True, True, **RUBBED[model])
    seen = set()
    for _ in range(150):
        state = np.array([rng.uniform(-0.6, 0.6), -40.0, 0.0, 0.0])
        state[2] = rng.uniform(-1e-4, 1e-4) if model == "support" else rng.uniform(-0.6, 0.6)
        mode, _ = enter(automaton, state)
        expected = reference.choose(state, {0, 1})
        assert key_of(model, automaton, mode) == expected
        seen.add(expected)
    assert len(seen) >= 8


def test_mirror_symmetry_is_exact():
    """(state, R, Ω) → −(state, R, Ω): the same bits with the other sign."""
    for (model, slide, bearing, parameters, start), automaton, _ in random_motions(3, 10):
        motion = follow(automaton, start, 0.03, max_events=300)
        opposite = {name: -parameters[name] for name in ("axial_force", "input_speed")}
        image = follow(
            build(model, slide, bearing, **{**parameters, **opposite})[1], -np.array(start), 0.03, max_events=300
        )
        for name in ("time", "kind"):
            np.testing.assert_array_equal(getattr(image, name), getattr(motion, name))
        for name in ("sign", "before", "after", "end_state"):
            np.testing.assert_array_equal(getattr(image, name), -getattr(motion, name))


class Balance:
    """Energy [J] and powers [W] from the reference's forces."""

    def __init__(self, model, reference):
        self.model, self.d, self.p = model, reference, reference.p
        self.rows = {}

    def speeds(self, states):
        slip, second, travel = self.d.speeds(states.T)
        return slip, (second if self.model == "nut" else slip), travel

    def energy(self, states):
        p = self.p
        _, screw, travel = self.speeds(states)
        own = ("screw_mass", "support_stiffness") if self.model == "support" else ("nut_inertia", "nut_stiffness")
        parts = [p["screw_inertia"] * screw**2, p["mass"] * travel**2, p[own[0]] * states[:, 3] ** 2]
        parts += [
            p["coupling_stiffness"] * (self.d.z0 + states[:, 0]) ** 2,
            p[own[1]] * (self.d.q0 + states[:, 2]) ** 2,
        ]
        return 0.5 * sum(parts)

    def power(self, mode, states):
        p = self.p
        slip, screw, travel = self.speeds(states)
        damping = p["axial_support_damping" if self.model == "support" else "nut_damping"]
        feed = -p["coupling_stiffness"] * (self.d.z0 + states[:, 0]) * p["input_speed"] + p["axial_force"] * travel
        loss = p["support_damping"] * screw**2 + p["translation_damping"] * travel**2 + damping * states[:, 3] ** 2
        loss += self.d.F0 * np.abs(travel) + self.d.T0 * np.abs(screw)
        if mode[0]:
            if mode not in self.rows:
                self.rows[mode] = self.d.row(lambda x: self.d.forces(mode, x)[2])
            normal = states @ self.rows[mode][:4] + self.rows[mode][4]
            loss += p["friction_coefficient"] * np.abs(normal * slip) * p["pitch_radius"] / self.d.cos
        return np.stack([feed, -loss])


def test_energy_balance():
    """Motor and R feed what dampers and frictions consume on every arc; a seizure consumes the energy of the slip."""
    for (model, *_, start), automaton, reference in random_motions(4, 30):
        balance, flow = Balance(model, reference), automaton.tables.flow
        motion = follow(automaton, start, 0.02, max_events=60)
        for mode, first, last, duration in zip(*motion.arcs(), strict=True):
            rows = flow.oscillators[mode]
            rate = np.max(np.abs(rows[:, columns.ALPHA]) + rows[:, columns.BETA] + rows[:, columns.DELTA])
            pieces = max(1, math.ceil(rate * duration))
            times = ((np.arange(pieces)[:, None] + 0.5 * (NODES + 1)) / pieces * duration).ravel()
            states = np.empty((times.size, 4))
            for time, state in zip(times, states, strict=True):
                dispatch.advance(flow, mode, first, time, state)
            works = (
                balance.power(key_of(model, automaton, mode), states)
                @ np.tile(0.5 * WEIGHTS, pieces)
                / pieces
                * duration
            )
            before, after = balance.energy(np.stack([first, last]))
            assert abs(after - before - works.sum()) <= 1e-11 * (before + after + np.abs(works).sum())
        for k in range(len(motion.time)):
            before, after = balance.energy(np.stack([motion.before[k], motion.after[k]]))
            lost = 0.0
            if motion.kind[k] == EVENTS[model].SEIZURE:
                slip = reference.speeds(motion.before[k])[0]
                # What moves with the slip: m̃ (or m) along the axis and I (or I_eff) about it.
                p, reach = reference.p, reference.reach
                inertia, mass = p["screw_inertia"], p["mass"]
                if model == "support":
                    mass = mass * p["screw_mass"] / (mass + p["screw_mass"])
                else:
                    inertia = inertia * p["nut_inertia"] / (inertia + p["nut_inertia"])
                lost = 0.5 * (inertia + mass * reach**2) * slip**2
            assert abs(before - after - lost) <= 1e-11 * (before + lost)


@pytest.mark.parametrize(("model", "regular"), [(model, regular) for model in MODELS for regular in (True, False)])
def test_every_mode_against_the_matrix_exponential(model, regular):
    """One arc in each mode with 40 digits: every slip and rest, the second body sliding or held."""
    parameters = RUBBED[model] if regular else PARADOX[model]
    drive, automaton, plain = build(model, regular, regular, **parameters)
    rng = np.random.default_rng(5)
    with mpmath.workdps(40):
        exact = SteppedDrive(model, dict(drive), FRICTIONS if regular else (), exact=True)
        for mode in range(len(automaton.codes)):
            key = key_of(model, automaton, mode)
            state = np.array([0.1, 60.0, 1e-4 if model == "support" else 0.1, 0.02 if model == "support" else 30.0])
            state = plain.tie(state * rng.uniform(-1, 1, 4), {i for i in (0, 1) if key[2 * i] == 0})
            rows = [exact.row(lambda x, i=i, key=key: exact.field(key, x)[i]) for i in range(4)]
            table = mpmath.matrix([list(row) for row in rows] + [[0] * 5])
            for duration in (1e-5, 2e-3, 1e-2):
                flow = mpmath.expm(table * mpmath.mpf(duration))
                expected = np.array([float(x) for x in flow * mpmath.matrix([*map(float, state), 1])])[:4]
                found = np.empty(4)
                dispatch.advance(automaton.tables.flow, mode, state, duration, found)
                size = np.maximum(np.maximum(np.abs(state), np.abs(expected)), LEAST[model])
                assert np.max(np.abs(found - expected) / size) <= 1e-12, (key, duration)


@pytest.mark.parametrize("model", MODELS)
def test_friction_of_size_zero_changes_nothing(model):
    own = STIFF if model == "support" else {}
    common = {"support_damping", "translation_damping", "axial_force"}
    common.add("nut_damping" if model == "nut" else "axial_support_damping")
    scene = {"model": model, "start": {"u": 0.1, "w": 0.0}, "duration": 0.05, **LOADED, **own}
    absent = lsvib.simulate(**scene, physics=sorted(common))
    listed = lsvib.simulate(**scene, physics=sorted(common | {"slide_friction", "bearing_friction"}))
    assert absent.sizes["event"] >= 10
    for name in ("angle_deviation", "velocity_deviation", "normal_force"):
        np.testing.assert_array_equal(listed[name].values, absent[name].values)


@pytest.mark.parametrize("model", MODELS)
def test_vanishing_friction_is_no_friction(model):
    """F_0, T_0 → 0 with all their modes and events leads to the motion without them."""
    own = STIFF if model == "support" else {}
    plain = follow(build(model, **LOADED, **own)[1], START, 0.03)
    rubbed = build(model, True, True, **LOADED, **own, slide_friction=1e-9, bearing_friction=1e-12)[1]
    found = follow(rubbed, START, 0.03)
    assert len(found.time) > len(plain.time)
    assert np.max(np.abs(found.end_state - plain.end_state) / size_of(plain)) <= 1e-8


@pytest.mark.parametrize(
    ("model", "parameters", "message"),
    [
        ("support", {"slide_friction": 1.0, "screw_mass": 11.6}, "screw_mass < 10.1"),
        ("nut", {"bearing_friction": 0.01, "mass": 15.0}, "mass < 5.05"),
        ("nut", {"resume": "at_once"}, "contact_sign"),
        ("support", {"resume": "at_once"}, "contact_sign"),
    ],
)
def test_what_is_not_determined_is_refused(model, parameters, message):
    with pytest.raises(InputError, match=message):
        lsvib.simulate(model=model, start={"u": 0.1, "w": 0}, duration=0.1, **parameters)


@pytest.mark.parametrize(
    ("model", "extra"),
    [("support", {"screw_shift": 1e-5, "shift_rate": 0.01}), ("nut", {"nut_angle": 0.05, "nut_rate": -3.0})],
)
def test_scene_starts_and_reports_the_other_coordinate(model, extra):
    outputs = ["normal_force", "axial_contact_force", "coupling_torque", "screw_speed", "nut_speed"]
    motion = lsvib.simulate(model=model, start={"u": 0.1, "w": 5.0, **extra}, duration=0.02, outputs=outputs)
    for name, value in extra.items():
        assert motion[name].values[0] == pytest.approx(value, rel=1e-12)
    mode = motion["mode"].values
    slips = mode == KINDS[model][1].SLIP_FORWARD_POSITIVE
    drive = KINDS[model][0]()
    push = math.cos(drive.lead_angle) + drive.friction_coefficient * math.sin(drive.lead_angle)
    assert slips.mean() > 0.1
    np.testing.assert_allclose(motion["axial_contact_force"][slips], push * motion["normal_force"][slips], rtol=1e-12)
    # The axial balance of the nut at the samples, from five of its speed at a time, all in one mode. Such a difference
    # leaves out (ω h)⁴ / 30 = 6e-9 of the force with the fastest rate ω of 1e3 1/s and h = 2e-5 s.
    v, step = motion["nut_speed"].values, float(motion["time"][1] - motion["time"][0])
    rate = (v[:-4] - 8 * v[1:-3] + 8 * v[3:-1] - v[4:]) / (12 * step)
    force = motion["axial_contact_force"].values
    calm = np.all([mode[:-4] == mode[k : k + len(rate)] for k in range(1, 5)], axis=0)
    assert calm.mean() > 0.9
    assert np.ptp(force[2:-2][calm]) > 1.0  # N
    np.testing.assert_allclose(force[2:-2][calm], (drive.axial_force - drive.mass * rate)[calm], atol=1e-6)
