"""Both sides of every threshold of the axial force, for random drives.

The threshold is computed from closed forms with many digits; the motions on either side are followed by the engine,
event by event. A statement on one side of a threshold is judged by the events of motions:

* stick: slip that starts where θ′ = 0 is touched, the end of rest, comes back to θ′ = 0 within a turn, or never;
* detach: slip from the end of rest reaches N = 0 first, or θ′ = 0 with rest;
* global stability: motions from all over the plane, from the end of rest and from the cycle without rest settle, or one
  of them does not.
"""

import math

import numpy as np
import pytest
from references.wide_drives import power

from lsvib.engine.kernels.layout import Status
from lsvib.engine.motion import follow
from lsvib.errors import DivergenceError, EngineError, InputError, NoThreshold
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.models.names import Event
from lsvib.models.rigid import rigid_automaton
from lsvib.stability.force_thresholds import threshold_force, widest_return
from lsvib.stability.slip import SlipDrive

DISTANCES = [10.0**-n for n in range(1, 10)]  # relative, of the forces beside a threshold
STANDS = (Event.STICK, Event.REVERSAL)


def random_drive(rng, kind: str) -> Drive:
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
            return Drive.of(values)
        except InputError:
            continue


def forward(drive: Drive) -> tuple[SlipDrive, float]:
    return SlipDrive.of(drive), math.copysign(1.0, drive.input_speed)


def beside(rng, threshold: float, onset: float):
    """Yield (side, R) near and far from a threshold beyond the onset, all for Ω > 0."""
    for distance in DISTANCES:
        yield -1, threshold - abs(threshold) * distance
        yield 1, threshold + abs(threshold) * distance
    for share in (0.5, 0.1, rng.random()):
        yield -1, onset + (threshold - onset) * share
    for factor in (2.0, 10.0, power(rng, 0, 4)):
        yield 1, onset + (threshold - onset) * factor


def events(drive: Drive, force: float, start, count: int) -> list[Event]:
    """The first events of a motion at a force, without the releases from rest that it begins with."""
    try:
        kinds = [Event(int(k)) for k in follow(changed(drive, force), start, math.inf, max_events=count).kind]
    except DivergenceError:
        return []
    while kinds and kinds[0] == Event.RELEASE:
        kinds = kinds[1:]
    return kinds


def changed(drive, force):
    return rigid_automaton(drive.replace(axial_force=force))


def judge_onset(rng, drive):
    onset = threshold_force(drive, "onset")
    for side, force in beside(rng, abs(onset), 0.0):
        c = coefficients(drive.replace(axial_force=math.copysign(force, onset)))
        assert (c.damping[c.steady_law] > 0) == (side < 0)


def end_of_rest(drive: Drive) -> tuple[float, float]:
    """State in which rest ends and slip under law + begins: θ′ = 0, without acceleration."""
    made, sign = forward(drive)
    return sign * float(made.damping[1] * made.speed / made.stiffness), -drive.input_speed


def slips_beside(rng, drive: Drive, threshold: float, count: int):
    """Yield (side, |R|, first events of slip from the end of rest) for forces beside a threshold beyond the onset."""
    onset, sign = threshold_force(drive, "onset"), forward(drive)[1]
    assert sign * threshold > sign * onset
    for side, force in beside(rng, sign * threshold, sign * onset):
        if sign * onset < force < 1e12 and force != sign * threshold:
            yield side, force, events(drive, sign * force, end_of_rest(drive), count)


def judge_stick(rng, drive):
    """The cycle is unique and what is inside of it winds outwards to it, what is outside inwards."""
    for side, force, kinds in slips_beside(rng, drive, threshold_force(drive, "stick"), 30):
        if Event.GRAZE in kinds:  # a turn grows by less than rounding
            continue
        if side > 0:
            assert any(kind in STANDS for kind in kinds[:3]), force
        else:
            assert not any(kind in STANDS for kind in kinds), force


def judge_detach(rng, drive):
    for side, force, kinds in slips_beside(rng, drive, threshold_force(drive, "detach"), 6):
        if side > 0:
            assert kinds[:2] == [Event.STICK, Event.RELEASE], force
        else:
            assert kinds[0] == Event.CONTACT_REVERSAL, force


def starts(rng, made: SlipDrive, force: float, count: int):
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
    if set(motion.kind[-500:].tolist()) != {Event.SEIZURE}:
        return False
    steps = np.diff(sign * motion.after[-500:, 0])
    backward = sign * motion.end_state[0] > float(made.damping[-1] * made.speed / made.stiffness)
    return bool((steps < 0).all() if backward or made.outward <= 0 else (steps > 0).all())


def judge_global(rng, drive):
    made, sign = forward(drive)
    threshold = sign * threshold_force(drive, "global_stability")
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


JUDGES = {"onset": judge_onset, "stick": judge_stick, "detach": judge_detach, "global_stability": judge_global}


@pytest.mark.parametrize("kind", ["any", "damped", "paradox"])
def test_thresholds_of_random_drives(kind):
    rng, judged = np.random.default_rng(11), set()
    for _ in range(5):
        drive = random_drive(rng, kind)
        for name, judge in JUDGES.items():
            try:
                threshold_force(drive, name)
            except NoThreshold:
                continue
            judge(rng, drive)
            judged.add(name)
    assert judged
