"""Both sides of every threshold of the axial force, for random drives and for drives that once failed.

The threshold is computed from closed forms with many digits; the motions on either side are followed by the engine,
event by event, and some of them by the Taylor steps of :mod:`benchmarks.sweeps.taylor`, which share nothing
with it. A statement on one side of a threshold is judged by the events of motions:

* stick: slip that starts where θ′ = 0 is touched, the end of rest, comes back to θ′ = 0 within a turn, or never;
* detach: slip from the end of rest reaches N = 0 first, or θ′ = 0 with rest;
* global stability: motions from all over the plane, from the end of rest and from the cycle without rest settle, or one
  of them does not.
"""

import math

import numpy as np
import pytest

from benchmarks.sweeps import taylor
from benchmarks.sweeps.taylor import KINDS
from lsvib.cycles.forward_slip import ForwardDrive
from lsvib.drives.coefficients import coefficients
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import EventKind, rigid_automaton
from lsvib.engine.kernels.status import Status
from lsvib.engine.motion import follow
from lsvib.errors import DivergenceError, EngineError, InputError, NoThreshold
from lsvib.steady_sliding import thresholds
from lsvib.steady_sliding.global_stability import widest_return

DISTANCES = [10.0**-n for n in range(1, 10)]  # relative, of the forces beside a threshold
STANDS = (EventKind.STICK, EventKind.REVERSAL)
NAMES = (
    "pitch_radius", "lead_angle", "screw_inertia", "coupling_stiffness", "support_damping", "friction_coefficient",
    "input_speed", "mass", "translation_damping",
)  # fmt: skip


def drive_of(*values: float) -> RigidParameters:
    return RigidParameters.of(dict(zip(NAMES, values, strict=True)))


def power(rng, low, high):
    return 10.0 ** rng.uniform(low, high)


def random_drive(rng, kind: str) -> RigidParameters:
    """Draw a drive: ``any``; or with Γ₊ > 0 > C₊ (``damped``) or Γ₊ < 0 (``paradox``), at any distance from zero."""
    while True:
        lead = math.radians(rng.uniform(0.5, 45))
        values = {
            "pitch_radius": rng.uniform(1e-3, 50e-3), "lead_angle": lead,
            "friction_coefficient": min(rng.uniform(0.001, 0.9), 0.999 / math.tan(lead)),
            "mass": power(rng, -2, 4), "screw_inertia": power(rng, -9, 1), "coupling_stiffness": power(rng, -3, 6),
            "support_damping": rng.choice([0.0, power(rng, -9, 2)], p=[0.1, 0.9]),
            "translation_damping": rng.choice([0.0, power(rng, -4, 6)], p=[0.1, 0.9]),
            "input_speed": rng.choice([-1, 1]) * power(rng, -2, 4),
        }  # fmt: skip
        if kind != "any":
            tan, mu = math.tan(lead), values["friction_coefficient"]
            arm, damping = values["pitch_radius"] ** 2 * tan, values["translation_damping"]
            plus, minus = ((mu - tan) / (1 + mu * tan), (mu + tan) / (1 - mu * tan))
            away = power(rng, -4, 2) if kind == "damped" else -power(rng, -4, 0)
            values["screw_inertia"] = plus * arm * values["mass"] * (1 + away)
            if kind == "damped":
                values["support_damping"] *= rng.random() < 0.8 and plus * arm * damping / (
                    1 + values["support_damping"]
                )
            # Damping ratios from weak to overdamped.
            law = plus if kind == "damped" else -minus
            inertia = values["screw_inertia"] - law * arm * values["mass"]
            damping = abs(values["support_damping"] - law * arm * damping)
            values["coupling_stiffness"] = (damping / power(rng, -3, 1)) ** 2 / inertia if inertia > 0 else 0.0
        try:
            return RigidParameters.of(values)
        except InputError:
            continue


def forward(drive: RigidParameters) -> tuple[ForwardDrive, float]:
    return ForwardDrive(drive, coefficients(drive)), math.copysign(1.0, drive.input_speed)


def beside(rng, threshold: float, onset: float):
    """Yield (side, R) near and far from a threshold beyond the onset, all for Ω > 0."""
    for distance in DISTANCES:
        yield -1, threshold - abs(threshold) * distance
        yield 1, threshold + abs(threshold) * distance
    for share in (0.5, 0.1, rng.random()):
        yield -1, onset + (threshold - onset) * share
    for factor in (2.0, 10.0, power(rng, 0, 4)):
        yield 1, onset + (threshold - onset) * factor


def events(drive: RigidParameters, force: float, start, count: int) -> list[EventKind]:
    """The first events of a motion at a force, without the releases from rest that it begins with."""
    try:
        kinds = [EventKind(int(k)) for k in follow(changed(drive, force), start, math.inf, max_events=count).kind]
    except DivergenceError:
        return []
    while kinds and kinds[0] == EventKind.RELEASE:
        kinds = kinds[1:]
    return kinds


def changed(drive, force):
    return rigid_automaton(drive.replace(axial_force=force))


def judge_onset(rng, drive):
    onset = thresholds.onset_force(drive)
    for side, force in beside(rng, abs(onset), 0.0):
        c = coefficients(drive.replace(axial_force=math.copysign(force, onset)))
        assert (c.damping[c.steady_law] > 0) == (side < 0)


def end_of_rest(drive: RigidParameters) -> tuple[float, float]:
    """State in which rest ends and slip under law + begins: θ′ = 0, without acceleration."""
    made, sign = forward(drive)
    return sign * float(made.damping[1] * made.speed / made.stiffness), -drive.input_speed


def slips_beside(rng, drive: RigidParameters, threshold: float, count: int):
    """Yield (side, |R|, first events of slip from the end of rest) for forces beside a threshold beyond the onset."""
    onset, sign = thresholds.onset_force(drive), forward(drive)[1]
    assert sign * threshold > sign * onset
    for side, force in beside(rng, sign * threshold, sign * onset):
        if sign * onset < force < 1e12 and force != sign * threshold:
            yield side, force, events(drive, sign * force, end_of_rest(drive), count)


def judge_stick(rng, drive):
    """The cycle is unique and what is inside of it winds outwards to it, what is outside inwards."""
    for side, force, kinds in slips_beside(rng, drive, thresholds.stick_force(drive), 30):
        if EventKind.GRAZE in kinds:  # a turn grows by less than rounding
            continue
        if side > 0:
            assert any(kind in STANDS for kind in kinds[:3]), force
        else:
            assert not any(kind in STANDS for kind in kinds), force


def judge_detach(rng, drive):
    for side, force, kinds in slips_beside(rng, drive, thresholds.detach_force(drive), 6):
        if side > 0:
            assert kinds[:2] == [EventKind.STICK, EventKind.RELEASE], force
        else:
            assert kinds[0] == EventKind.CONTACT_REVERSAL, force


def starts(rng, made: ForwardDrive, force: float, count: int):
    """Starts (Ω > 0): the end of rest, the cycle without rest, others on θ′ = 0 left of the former, and anywhere."""
    speed, first = float(made.speed), float(made.damping[-1] * made.speed / made.stiffness)
    slip_time = float((made.inertia[-1] / made.stiffness) ** 0.5)
    released = first - max(force, 0.0) * float(made.radius * (made.xi[1] - made.xi[-1]) / made.stiffness)
    yield released, -speed
    if made.contact[1] > 0:
        x = float(widest_return(made)[1])
        if math.isfinite(x):
            yield x, -speed
    size = max(abs(released), speed * slip_time)
    for _ in range(count):
        yield released - size * power(rng, -5, 2), -speed
        size_now, angle = size * power(rng, -2, 1), rng.uniform(0, 2 * math.pi)
        yield size_now * math.cos(angle), size_now / slip_time * math.sin(angle)


def settles(drive, force, start, made, sign, count=20_000) -> bool | None:
    """Whether a motion settles; None if unknown.

    Overdamped slip may seize a million times on its way. It counts as settling if u moves one way only: backward slip
    moves left until it rests; so does slip that seizes while u falls; other slip moves right, to smaller turns.
    """
    try:
        motion = follow(changed(drive, force), start, math.inf, max_events=count)
    except EngineError:
        return None
    if motion.status == Status.SETTLED:
        return True
    if set(motion.kind[-500:].tolist()) != {EventKind.SEIZURE}:
        return False
    steps = np.diff(sign * motion.after[-500:, 0])
    backward = sign * motion.end_state[0] > float(made.damping[-1] * made.speed / made.stiffness)
    return bool((steps < 0).all() if backward or made.outward <= 0 else (steps > 0).all())


def judge_global(rng, drive):
    made, sign = forward(drive)
    threshold = sign * thresholds.global_stability_force(drive)
    onset = float(made.onset)
    assert threshold < onset or onset == 0 > threshold
    below = [(side, force) for side, force in beside(rng, threshold, threshold)][:18]
    below += [(-1, onset - (onset - threshold) * factor) for factor in (2.0, 10.0)]
    below += [(1, onset - (onset - threshold) * share) for share in (0.5, 0.01, rng.random())]
    for side, force in below:
        if not (abs(force) < 1e12 and force < onset * (1 - 1e-12) + 0.0) or force == threshold:
            continue
        found = [settles(drive, sign * force, (sign * u, sign * w), made, sign) for u, w in starts(rng, made, force, 2)]
        if side < 0:
            assert False not in found, force
        else:
            assert False in found, force


# Each of these had a threshold on the wrong side of the onset, a wrong one, or none for a wrong reason.
ONCE_WRONG = {
    "slip grows in large motions, c = 0": (
        (0.01175, 0.5882, 3.821e-06, 0.03315, 0.0, 0.8823, 0.7332, 0.3057, 0.06414),
        {"stick": "no limit cycle"},
    ),
    "slip grows in large motions, Ω < 0": (
        (0.0446, 0.07159, 5.456e-05, 0.003885, 3.311e-09, 0.7757, -6560.0, 0.4993, 0.03054),
        {"stick": "no limit cycle"},
    ),
    "slip hardly grows": (
        (0.001576, 0.08171, 8.154, 49400.0, 1.435e-05, 0.2614, -26.89, 0.04609, 12640.0),
        {"stick": -56.21676007444131},
    ),
    "growth and decay almost balance": (
        (
            0.0018491986511144601, 0.013952965105095659, 2.2933523313552496e-07, 1783.6443795971413, 0.0,
            0.0788572174040147, 34.339591408972126, 2.282350423333777, 0.00016045615513050874,
        ),
        {"stick": None},
    ),
    "law + is fast against law −": (
        (
            0.008733182777977952, 0.07713120231482697, 0.00010572632869418406, 57121773.602652945, 0.19581995425607404,
            0.6446099494869246, 0.34024698804917525, 33.17468148660606, 62095.25142606497,
        ),
        {"stick": None},
    ),
    "slip from rest turns back": (
        (0.036, 0.02502, 0.3925, 28.9, 7.567e-08, 0.4943, 0.7337, 391.2, 435.9),
        {"detach": "slip backward, not in rest"},
    ),
    "the corner was taken for the threshold": (
        (0.0232, 0.3751, 7.58e-08, 491.8, 0.4942, 0.7185, -0.5531, 0.0343, 92.07),
        {"global": "and under every smaller one with it"},
    ),
    "only forces with the motion start cycles": (
        (0.02063, 0.3712, 6.812e-06, 34.4, 0.001216, 0.5409, -541.1, 0.3284, 324.8),
        {"global": -1376.56766665683},
    ),
    "a cycle without rest right of the origin": (
        (
            0.009776392991936327, 0.6227839925295562, 7.28065919624951e-05, 1.120577148412004e-05,
            8.598931950157458e-06, 0.8540925524129295, -2469.894127628262, 15.993680515195168, 0.9825725271758998,
        ),
        {"global": -16.527331539534792},
    ),
    "seizures that end while u falls": (
        (
            0.02027104255996163, 0.21776696291226794, 5.991470308032455e-05, 0.19114906602020426, 12.318538876053871,
            0.22365394776920638, -2479.328398061341, 4485.285517333959, 592.2422224556753,
        ),
        {"global": "and under every smaller one with it"},
    ),
    "cycles without rest are not excluded": (
        (0.02695, 0.3581, 4.65e-06, 8342000.0, 0.002477, 0.515, -35.64, 0.1797, 33270.0),
        {"global": "not covered"},
    ),
    "law + does not turn": (
        (0.03562, 0.3284, 0.0002572, 0.03153, 0.0005575, 0.4178, 0.06683, 0.0137, 230.9),
        {"stick": "grows without a turn", "detach": "grows without a turn"},
    ),
}  # fmt: skip

JUDGES = {"onset": judge_onset, "stick": judge_stick, "detach": judge_detach, "global": judge_global}


def computed(name: str):
    return thresholds.global_stability_force if name == "global" else getattr(thresholds, f"{name}_force")


def judged(rng, drive) -> list[str]:
    """Judge all thresholds of a drive; returns the names of those that it has."""
    names = []
    for name, judge in JUDGES.items():
        try:
            computed(name)(drive)
        except NoThreshold:
            continue
        judge(rng, drive)
        names.append(name)
    return names


@pytest.mark.parametrize("case", ONCE_WRONG)
def test_drive_that_was_wrong(case):
    values, expected = ONCE_WRONG[case]
    drive = drive_of(*values)
    for name, claim in expected.items():
        compute = computed(name)
        if isinstance(claim, str):
            with pytest.raises(NoThreshold, match=claim):
                compute(drive)
            continue
        if claim is not None:
            assert compute(drive) == pytest.approx(claim, rel=1e-12)
        JUDGES[name](np.random.default_rng(1), drive)


def test_reasons_hold_for_their_drives():
    """Slip without a turn leaves N > 0 or never ends; slip that grows comes to θ′ = 0; slip from rest turns back."""
    rng = np.random.default_rng(2)
    for case in ("law + does not turn", "slip grows in large motions, c = 0"):
        drive = drive_of(*ONCE_WRONG[case][0])
        for _ in range(20):
            force = float(forward(drive)[0].onset) * (1 + power(rng, -4, 4))
            kinds = events(drive, force, end_of_rest(drive), 3000)
            if case == "law + does not turn":
                assert not kinds or kinds[0] == EventKind.CONTACT_REVERSAL
            else:
                assert any(kind in STANDS for kind in kinds)
    drive = drive_of(*ONCE_WRONG["slip from rest turns back"][0])
    start = end_of_rest(drive)
    force = 2.546315944946203  # where slip from rest no longer reaches N = 0
    assert events(drive, force * (1 - 1e-6), start, 6)[0] == EventKind.CONTACT_REVERSAL
    assert events(drive, force * (1 + 1e-6), start, 6)[0] == EventKind.REVERSAL


def test_steps_of_another_integrator_agree():
    """The slip from the end of rest on both sides of detachment and of the first touch of rest, by Taylor steps."""
    drive = RigidParameters.of(mass=1.0, translation_damping=1e3)
    start = end_of_rest(drive)
    times, kinds = np.zeros(50), np.zeros(50, dtype=np.int64)
    for name, first in (("stick", {"stick", "reversal"}), ("detach", {"contact_reversal"})):
        threshold = getattr(thresholds, f"{name}_force")(drive)
        for distance in DISTANCES[:7]:
            for side in (-1, 1):
                constants = taylor.constants(dict(drive.replace(axial_force=threshold * (1 + side * distance))))
                _, count, *_ = taylor.run(constants, *start, 0.05, times, kinds)
                names = [KINDS[k] for k in kinds[:count]]
                names = names[names[0] == "release" :][: 3 if name == "stick" else 1]
                assert bool(first & set(names)) == ((side > 0) == (name == "stick")), (name, side, distance)


@pytest.mark.parametrize("kind", ["any", "damped", "paradox"])
def test_thresholds_of_random_drives(kind):
    rng = np.random.default_rng(11)
    names = [name for _ in range(5) for name in judged(rng, random_drive(rng, kind))]
    assert names


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["any", "damped", "paradox"])
def test_thresholds_of_many_random_drives(kind, seed):
    rng = np.random.default_rng(100 + seed)
    names = [name for _ in range(50) for name in judged(rng, random_drive(rng, kind))]
    assert set(names) & set(JUDGES)
