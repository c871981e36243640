"""Records over time: jerks of a measured drive and of known ones, and what must not be taken for jerks."""

import math
from pathlib import Path

import numpy as np
import pytest
from references.sizes import sizes

from lsvib.sheets.torque.records import look
from lsvib.sheets.torque.tables import Recording, read_table

DRIVE = Path(__file__).parents[2] / "examples" / "measured_screw" / "drive1"
RPM, PERCENT = math.pi / 30, 0.0984e-3  # rad/s, N m
AT = np.arange(400)


def test_drive_1_jerks_at_2_rpm_as_others_measured_and_turns_evenly_from_10():
    tables = (read_table(path, (2, 3, 1), (-RPM, -PERCENT, 1e-3), ";") for path in DRIVE.glob("*.csv"))
    records = {table.name: look(table) for table in tables}
    jerky = [records.pop("2.csv"), records.pop("n2.csv")]
    assert len(records) == 30
    for record in records.values():
        said = (f"{record.file}: the screw turns steadily.",)
        assert (record.kind, record.said, record.period) == ("even", said, None)
    for record in jerky:
        assert (record.kind, record.teeth) == ("jerks", 158)
        assert abs(record.period[0] - 0.4026) < 1.96 * math.hypot(record.period[1], 0.0005) < 4e-3
        assert abs(record.slope[0] - 4.55e-3) < 0.95e-3  # quartiles
        assert abs(record.stiffness[0] - 0.0215) < 0.0015 > record.stiffness[1]
    value, error = np.array([record.stiffness for record in jerky]).T
    assert np.average(value, weights=error**-2) == pytest.approx(0.0215, abs=3e-4)
    assert jerky[0].breakaway[0] == pytest.approx(37 * PERCENT, rel=0.02)
    assert 19 * PERCENT < jerky[0].after[0] < 22 * PERCENT
    first, second = jerky[1].said
    said = "n2.csv: the screw jerks 2.49 times a second, so its mean torque is not a point of the friction law."
    assert first == said
    said = "through slip and through averaging, which cannot be separated; the errors of the torques allow for both."
    assert said in second


def stick_slip(random, speed, stiffness, rate, damping, static, kinetic, jitter, duration):
    """Rows of time, torque and angle of J θ'' = k (Ωt − θ) + c (Ω − θ') − friction; and of each slip time and torques.

    Friction swings and drifts, and sticks less or more. A slip is a damped oscillation about the kinetic torque.
    """
    drag, fast, decay = 2 * damping * stiffness / rate, rate * math.sqrt(1 - damping**2), damping * rate
    turn, drift, after = random.uniform(0, 6.3), random.uniform(-0.1, 0.1), np.linspace(0, 2 * math.pi / fast, 1001)
    time, angle, wound, rows, slips = 0.0, 0.0, kinetic / stiffness, [], []
    while time < duration:
        more = static * (0.05 * math.sin(angle + turn) + drift * (time / duration - 0.5))
        wait = max((static + jitter * random.standard_normal() + more - drag * speed) / stiffness - wound, 0) / speed
        rows.append([(time, stiffness * wound + drag * speed, angle)])
        time, wound, rest = time + wait, wound + speed * wait, (kinetic + more) / stiffness
        a, b, turning = wound - rest, (speed + decay * (wound - rest)) / fast, 1j * fast - decay
        wave = (a - 1j * b) * np.exp(turning * after)
        wave, rise = wave.real, (turning * wave).real
        part = np.arange(int(np.flatnonzero(rise[2:] >= speed)[0]) + 3)  # until the screw stands again
        torque = stiffness * (wave + rest) + drag * rise
        rows.append(np.column_stack([time + after, torque, angle + speed * after - wave + a])[part])
        slips.append((time, rows[-1][0, 1], rows[-1][-1, 1]))
        (time, _, angle), wound = rows[-1][-1], wave[part[-1]] + rest
    return np.concatenate(rows).T, np.array(slips).T


def known(seed, per_tooth=None):
    """A recording of stick–slip with noise of 2 %, swing of 5 %, drift, scatter, quanta; interval, window and truth."""
    random = np.random.default_rng(seed)
    period, static, ratio = 10 ** random.uniform(-1.3, 0.3), 10 ** random.uniform(-3, 0), random.uniform(0.65, 0.9)
    speed = min(10 ** random.uniform(-1.5, 0.5), 0.6 / period)  # ten jerks a turn or more
    step = period / (per_tooth or np.exp(random.uniform(math.log(2.6), math.log(20))))
    damping, at = random.uniform(0.05, 0.35), 3 * period + step * np.arange(random.integers(300, 701))
    height = static * (1 - ratio) * (1 + math.exp(-math.pi * damping / math.sqrt(1 - damping**2)))
    stiffness, rate = height / (speed * period), math.pi / (random.uniform(0.02, 0.12) * period)
    window, jitter = max(random.uniform(-0.1, 1), 1e-3) * step, random.uniform(0, 0.06) * height
    law = (speed, stiffness, rate, damping, static, ratio * static)
    (time, torque, angle), slips = stick_slip(random, *law, jitter, at[-1])
    fine = np.linspace(0, at[-1], 400 * slips.shape[1])
    sums = np.cumsum(np.interp(fine, time, torque)) * fine[1]
    torque = (np.interp(at, fine, sums) - np.interp(at - window, fine, sums)) / window
    turned = (np.interp(at, time, angle) - np.interp(at - window, time, angle)) / window
    torque += 0.02 * torque.mean() * random.standard_normal(at.size)
    sense, quantum, percent = random.choice([-1, 1]), random.uniform(0.05, 0.5) * speed, 3e-3 * static
    turned, torque = sense * quantum * np.round(turned / quantum), sense * percent * np.round(torque / percent)
    slip, breakaway, after = slips[:, (slips[0] > at[0] - window) & (slips[0] < at[-1])]
    truth = {"period": np.diff(slip).mean(), "breakaway": breakaway.mean(), "after": after.mean()}
    truth |= {"slope": stiffness * speed, "stiffness": stiffness}
    return Recording(f"{seed}.csv", turned, torque), step, window, truth


@pytest.mark.parametrize("seeds", sizes([range(1000, 1040)], [], [range(200)]), ids=len)
def test_known_jerks_are_within_their_errors(seeds):
    """Of every other one the window of averaging is known. Of forty as many as chance leaves of 95 % are within."""
    off = {}
    for seed in seeds:
        recording, step, window, truth = known(seed)
        record = look(recording, step, window if seed % 2 else None)
        for key, value in truth.items():
            if (found := getattr(record, key)) is not None:
                off.setdefault(key, []).append(abs(found[0] - value) / found[1])
    for key, ratios in off.items():
        assert len(ratios) >= 0.9 * len(seeds), key
        assert np.mean(np.array(ratios) < 1.96) >= (0.88 if len(seeds) == 40 else 0.93), key


def jerks(phase, climb=0.4):
    """Speed and torque of jerks over their phase in turns."""
    return np.where(phase % 1 < 0.2, 5.0, 0.0), 1 + climb * (phase % 1)


def others(seed):
    """What is no stick–slip, or of which no numbers can be told: kind, first words, speed and torque."""
    random, even = np.random.default_rng(seed), np.ones(400)
    phase = random.uniform(0.06, 0.13) * AT + random.uniform()
    wave, (jump, teeth), (also, more) = 2 * np.pi * phase, jerks(phase), jerks(1.43 * phase)
    half = np.maximum(1 + 1.2 * np.sin(wave), 0)
    stops, only = (
        "the recorded speed is often far below its mean, as in jerks, but ",
        "at rest; only where the screw turns can it be steady motion.",
    )
    return {
        "rest": ("rest", "the screw rests, or turns as much one way as the other.", 0 * even, even),
        "noisy": ("rest", "the screw rests, or turns as much one way", 1e-9 * (-1.0) ** AT, even),
        "ramp": ("ramp", "the speed goes from 0.", np.linspace(0.3, 1.7, 400), teeth),
        "start": ("start", f"the record begins {only}", np.where(AT < 80, 0, even), np.where(AT < 80, AT / 80, even)),
        "stop": ("stop", f"the record ends {only}", np.where(AT > 300, 0, even), np.where(AT > 300, 0.2, even)),
        "both": ("start", f"the record begins and ends {only}", np.where(abs(AT - 200) > 150, 0, even), even),
        "spikes": ("even", "the screw turns steadily.", even, 1 + 2 * (jump > 0)),
        "turn": ("even", "the screw", even, 1 + 0.3 * np.sin(0.03 * AT) + 0.1 * np.sin(0.06 * AT)),
        "line": ("even", "the screw", 1 + 0.2 * np.sin(wave), 1 + 0.2 * np.cos(wave)),
        "sawtooth": ("jerks", "the torque climbs slowly and falls fast as in jerks, but", even, teeth),
        "smooth": ("jerks", f"{stops}its torque does not climb slowly and fall fast;", half, 1 + 0.2 * np.cos(wave)),
        "reverse": ("jerks", f"{stops}its torque climbs fast and falls slowly, as fewer than two", *jerks(phase, -0.4)),
        "rare": ("jerks", f"{stops}it is sampled less than 2.3 times a jerk;", *jerks(AT / 2.15)),
        "none": ("jerks", f"{stops}at no single frequency that stands out;", jump, 0 * even),
        "alike": ("jerks", f"{stops}at no single frequency that stands out;", jump + also, teeth + more),
        "two": ("jerks", f"{stops}at two frequencies;", jump, teeth + 0.45 * more),
        "late": ("jerks", f"{stops}not while its torque climbs;", 2.0 * (abs(phase % 1 - 0.6) < 0.24), teeth),
        "few": ("jerks", f"{stops}only 7 times;", *jerks(0.055 * AT[:130])),
        "short": ("jerks", f"{stops}there are only 60 samples;", *jerks(0.21 * AT[:60])),
        "more": ("jerks", f"{stops}more and more, or less", *jerks(np.cumsum(np.linspace(0.09, 0.15, 400)))),
    }  # fmt: skip


@pytest.mark.parametrize("name", others(0))
def test_what_is_no_stick_slip_has_no_numbers(name):
    for seed in (1, 4):
        kind, said, speed, torque = others(seed)[name]
        noise = 0.02 * np.random.default_rng(seed).standard_normal((2, speed.size))
        record = look(Recording("x", speed * (1 + noise[0]), torque + noise[1] * torque.any()), 0.1)
        assert record.said[0].startswith(f"x: {said}"), record.said
        assert (record.kind, record.period, record.stiffness, record.inertia) == (kind, None, None, None)
        assert len(record.said) == 1 or (kind in ("ramp", "start", "stop") and " found, as " in record.said[1])


def test_jerks_need_even_times_and_two_samples_in_a_ramp(monkeypatch):
    assert look(Recording("x", *jerks(0.131 * AT), time=np.round(0.128 * AT, 2))).stiffness is not None
    for time in (None, AT + 99 * (AT > 200), 0 * AT, -AT):
        (said,) = look(Recording("x", *jerks(0.13 * AT), time=time)).said
        assert "but its samples are not known to be evenly spaced in time; no numbers are given." in said
    monkeypatch.setattr("lsvib.sheets.torque.records.RAMP", (0.5, 0.55))
    assert "but few of its ramps have two samples;" in look(Recording("x", *jerks(0.13 * AT)), 1.0).said[0]


def test_fewer_than_two_samples_a_jerk_give_no_numbers():
    for seed in range(6):
        assert look(*known(seed, 1.2 + 0.12 * seed)[:2]).period is None


def test_jerks_in_step_with_the_samples_or_seldom_seen_tell_no_stiffness():
    record = look(Recording("x", *jerks(0.125 * AT + 0.01), time=0.1 * AT))
    assert "x: the mean speed is uncertain, as samples keep in step with the jerks, so no stiffness" in record.said[1]
    assert record.stiffness is None
    _, said = look(*known(213)[:3]).said  # of a window that is known, nothing is said of the fall
    assert "as its standard error is 33%, so no stiffness is found." in said


def test_single_lost_rows_are_bridged_and_many_are_not():
    """Every fiftieth row, as a spoiled cell loses it, changes no number by more than its error; every fifth is said."""
    whole = read_table(DRIVE / "2.csv", (2, 3, 1), (-RPM, -PERCENT, 1e-3), ";")

    def without(nth):
        kept = np.arange(whole.speed.size) % nth != nth - 1
        return look(Recording("2.csv", whole.speed[kept], whole.torque[kept], time=whole.time[kept]))

    full, few = look(whole), without(50)
    for name in ("period", "stiffness", "breakaway", "after"):
        (value, error), (other, _) = getattr(full, name), getattr(few, name)
        assert abs(value - other) < error
    assert "not known to be evenly spaced" in without(5).said[0]
