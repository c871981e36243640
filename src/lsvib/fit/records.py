"""A measured file over time: whether the screw rests, turns evenly, starts, stops, ramps, or jerks, and what jerks tell.

In stick–slip the screw stands while a spring k winds up at the commanded speed Ω, so the torque, in the direction of
turning, climbs as dT/dt = k Ω; it then slips within a time s, and the torque falls. A tooth of period P is

    T_breakaway − T_after = k Ω (P − s),    mean torque = (T_breakaway + T_after) / 2,    displacement = Ω P.

A recorder that averages over a time w rounds corners, but leaves means and the slope within a ramp. So the slope is
that of samples of one ramp, P that of the phase, Ω the mean of the recorded speed, and only s needs the shape: the fall
lasts d, with d² = w² + (1/3 to 1/2) s² or so. A damper takes part in the fall, and puts the mean below the middle by 2ζ/π
of s/P. Sampled each Δ, a line at f is also one at 1/Δ − f, a sawtooth reversed in time: the one that climbs slowly and
falls fast counts. Below LEAST samples a tooth nothing is told. f + 1/Δ gives the samples of f: the slower is taken.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lsvib.fit.tables import REST, SPIKE, Recording, drifts

Array = NDArray[np.float64]
Number = tuple[float, float]  # a value with its standard error
Kind = Literal["rest", "even", "ramp", "start", "stop", "jerks"]

LEAST = 2.3  # samples a tooth: at 2, a sawtooth and its reverse are the same samples
SHORTEST, TEETH = 64, 8  # samples of a record, and teeth or ramps of it, of which jerks are told
UNEVEN = 0.02  # of the interval, by which intervals of time may differ
EXPLAINED = 0.8  # of the variance beside slow change, by teeth; of two frequencies alike they explain 0.78 at most
LIKELIER = 25.0  # by χ², five standard errors, by which a sawtooth must fit better than its reverse
STANDS = 0.7  # of the mean speed, in two of five samples: a screw that is faster does not stand
OTHER = 0.25  # of the amplitude of the teeth: a second line beyond is a second frequency
FASTER = 0.25  # of the mean number of teeth in a quarter of the file, by which quarters may differ
RAMP = (0.3, 0.9)  # of a tooth: after the slip a controller, and what records the torque, still settle
WIDTHS = np.linspace(0.01, 0.65, 33)  # of the fall as recorded, in periods
BLUR = 0.03  # periods, by which the phase of teeth that differ, as it is followed, blurs the width
SHAPE = (0.3, 0.57)  # (d² − w²) / s² of a slip that a damper slows, and of half a cosine
LONGEST = 0.25  # periods: a longer slip is none
DAMPED = 0.13  # 2ζ/π of ζ = 0.2, and its error, as ζ is unknown
BLOCKS = 16  # of a file, of whose mean speeds the error of the mean speed is told
UNSURE = 0.3  # relative standard error from which on a number is not told
UNSURE_OF = {
    "period": "period of the jerks",
    "slope": "slope of the ramps",
    "stiffness": "stiffness",
    "displacement": "displacement of a jerk",
    "breakaway": "torque at breakaway",
    "after": "torque after the slip",
}


@dataclass(frozen=True)
class Record:
    """What a file is, ``said`` in sentences, and what jerks tell, with standard errors over the teeth, or None.

    ``period`` [s], ``slope`` of the ramps [N m/s] and ``stiffness`` [N m/rad], the torque at ``breakaway`` and
    ``after`` the slip in the direction of turning [N m], the ``displacement`` of a jerk [rad], the number of ``teeth``,
    and how long the torque takes to ``fall`` as recorded [s], which no window of averaging exceeds.
    """

    file: str
    kind: Kind
    said: tuple[str, ...]
    timed: bool = False
    period: Number | None = None
    slope: Number | None = None
    stiffness: Number | None = None
    breakaway: Number | None = None
    after: Number | None = None
    displacement: Number | None = None
    fall: Number | None = None
    teeth: int | None = None


@dataclass(frozen=True)
class Teeth:
    """Teeth of a torque: ``phase`` (n) in turns, whole where the screw slips, and ``width`` of the fall in turns.

    ``left`` (n) is what teeth of this ``height`` leave of the torque, ``misfit`` its mean square, ``explained`` the part
    of the variance that they do not leave.
    """

    phase: Array
    width: Number
    height: float
    left: Array
    misfit: float
    explained: float

    @property
    def frequency(self) -> float:
        """Teeth a sample."""
        return float((self.phase[-1] - self.phase[0]) / (self.phase.size - 1))


def look(recording: Recording, interval: float | None = None, averaging: float | None = None) -> Record:
    """Return what a recording is that was sampled each ``interval`` (None: as its time says), averaged over a time [s].

    ``averaging``: the window over which the recorder averages, None where it is unknown, up to an interval.
    """
    name, speed = recording.name, recording.speed
    mean, turning = float(speed.mean()), np.count_nonzero(speed)
    either_way = speed.min() < 0 < speed.max() and abs(mean) < 3 * speed.std() / math.sqrt(speed.size)
    if either_way or mean == 0 or turning < min(TEETH, speed.size):
        return Record(name, "rest", (f"{name}: the screw rests, or turns as much one way as the other.",))
    resting = np.abs(speed) < REST * abs(mean)
    runs = np.diff(np.flatnonzero(np.concatenate([[True], ~resting, [True]]))) - 1  # of rests about samples that turn
    most = 2 * max(1, int(runs[1:-1].max(initial=0)))
    words = [word for word, run in (("begins", runs[0]), ("ends", runs[-1])) if run > most]
    if words:
        said = f"{name}: the record {' and '.join(words)} at rest; only where the screw turns is it steady motion."
        return Record(name, "start" if words[0] == "begins" else "stop", (said,))
    if drifts(speed):
        first, *_, last = (float(part.mean()) for part in np.array_split(speed, 8))
        said = f"{name}: the speed goes from {first:.3g} to {last:.3g} rad/s, so this is no steady motion."
        return Record(name, "ramp", (said,))
    step, problem = _interval(recording, interval)
    if problem:
        said = f"{name}: {problem}, so jerks cannot be told from even turning."
        return Record(name, "even", (said,))
    return replace(_jerks(recording, step, averaging), timed=True)


def _interval(recording: Recording, interval: float | None) -> tuple[float, str]:
    """Return the sampling interval, or why jerks cannot be looked for."""
    if recording.speed.size < SHORTEST:
        return math.nan, f"there are only {recording.speed.size} samples"
    if interval is None and recording.time is not None:
        steps = np.diff(recording.time)
        interval = float(np.median(steps))
        if interval <= 0 or np.abs(steps - interval).max() > UNEVEN * interval:
            return math.nan, "the samples are not evenly spaced in time"
    return (interval, "") if interval else (math.nan, "the time between samples is not known")


def _jerks(recording: Recording, step: float, averaging: float | None) -> Record:
    """Look for teeth, and return what they are, or why none are told."""
    name, sense = recording.name, np.sign(recording.speed.mean())
    speed, torque = sense * recording.speed, sense * recording.torque
    middle, off = np.median(torque), np.abs(torque - np.median(torque))
    torque = np.where(off > SPIKE * 1.4826 * np.median(off), middle, torque)
    line = _line(torque, speed)
    forward, reverse = _teeth(torque, line), _teeth(-torque, line)
    found = min(forward, reverse, key=lambda teeth: teeth.misfit)
    if np.quantile(speed, 0.4) > STANDS * speed.mean():
        said = f"{name}: the screw turns evenly."
        if found.explained > EXPLAINED:
            said = f"{name}: the torque swings {line / step:.3g} times a second, but the screw does not stop."
        return Record(name, "even", (said,))
    if problem := _problem(speed, found, forward, reverse):
        return Record(name, "jerks", (f"{name}: the screw stops now and then, but {problem}; no numbers are told.",))
    return _numbers(name, speed, torque, found, step, averaging)


def _problem(speed: Array, found: Teeth, forward: Teeth, reverse: Teeth) -> str:
    """Return why teeth are none of which numbers can be told."""
    if found.explained < EXPLAINED:
        return "at no one frequency"
    if abs(forward.misfit - reverse.misfit) * speed.size < LIKELIER * found.misfit:
        return "its torque does not climb slowly and fall fast"
    if found is reverse or found.frequency > 1 / LEAST:
        return f"was sampled less than {LEAST:g} times a jerk, so how often it jerks cannot be told"
    if speed[_ramp(found)].mean() > STANDS * speed.mean():
        return "not while its torque climbs"
    amplitude = 4 / speed.size * np.abs(np.fft.rfft(np.hanning(speed.size) * found.left))
    for k in range(6):  # harmonics, folded
        from_line = np.abs(np.fft.rfftfreq(speed.size) - abs((k * found.frequency + 0.5) % 1 - 0.5))
        amplitude[from_line < (0.15 if k else 0.35) * found.frequency] = 0
    if amplitude.max() > OTHER * found.height / math.pi:
        return "at two frequencies"
    if np.ptp(found.phase) < TEETH + 1:
        return f"only {np.ptp(found.phase):.0f} times"
    quarters = [np.ptp(part) for part in np.array_split(found.phase, 4)]
    return "ever more or ever less often" if np.ptp(quarters) > FASTER * np.mean(quarters) else ""


def _ramp(teeth: Teeth) -> NDArray[np.bool_]:
    """Where samples are within a ramp, apart from the fall."""
    place, edge = teeth.phase % 1, 0.5 * teeth.width[0] + BLUR
    return (place > max(RAMP[0], edge)) & (place < min(RAMP[1], 1 - edge))


def _line(torque: Array, speed: Array) -> float:
    """Return the frequency [1/sample] at which torque and speed swing together most, of the mean of cross spectra."""
    size = max(torque.size // 4, SHORTEST)
    base, _ = np.linalg.qr(_slow(torque.size, 8))
    both = np.stack([torque, speed])
    both -= both @ base @ base.T
    parts = [both[:, k : k + size] for k in range(0, torque.size - size + 1, size // 2)]
    spectra = [np.fft.rfft(np.hanning(size) * (part - part.mean(axis=1, keepdims=True)), 8 * size) for part in parts]
    power = np.abs(sum(one.conj() * other for one, other in spectra))
    power[: 3 * 8] = 0  # fewer than three in a part are no line
    return int(np.argmax(power[1:]) + 1) / (8 * size)


def _slow(size: int, terms: int) -> Array:
    """Return columns of slow change: a mean, a line and cosines."""
    x = (np.arange(size) + 0.5) / size
    return np.column_stack([np.ones(size), x - 0.5, *(np.cos(np.pi * k * x) for k in range(1, terms + 1))])


def sawtooth(phase: Array, width: float) -> Array:
    """Return teeth over a phase in turns: they climb from −1/2 to 1/2, fall at whole phases, averaged over a width."""
    ends = [0.5 * ((phase + side) % 1 - 0.5) ** 2 for side in (0.5 * width, -0.5 * width)]
    return (ends[0] - ends[1]) / width


def _smoothed(values: Array, width: float) -> Array:
    """Return Gaussian means along the last axis, of a standard deviation in samples."""
    size, half = values.shape[-1], int(3 * width) + 1
    weight = np.fft.rfft(np.exp(-0.5 * (np.arange(-half, half + 1) / width) ** 2), size + 2 * half)
    of, ones = (
        np.fft.irfft(np.fft.rfft(x, size + 2 * half) * weight, size + 2 * half)[..., half : half + size]
        for x in (values, np.ones(size))
    )
    return np.asarray(of / ones)


def _teeth(torque: Array, frequency: float) -> Teeth:
    """Fit teeth of about a frequency [1/sample], whose phase wanders, beside a slow change of the torque.

    The phase starts from the line, in a window of about two teeth; five times it is shifted to where teeth fit best.
    """
    size, tooth, at = torque.size, max(1 / frequency, 2.5), np.arange(torque.size)
    base, _ = np.linalg.qr(_slow(size, int(np.clip(0.3 * size * frequency, 2, 48))))
    level = torque - base @ (base.T @ torque)
    beat = level * np.exp(-2j * np.pi * frequency * at)
    angle = np.angle(_smoothed(beat.real, 1.0 * tooth) + 1j * _smoothed(beat.imag, 1.0 * tooth))
    phase = frequency * at + np.unwrap(angle) / (2 * np.pi) - 0.25  # teeth are 1/π cos(2π (phase + 1/4)) + ...
    shifts = np.linspace(-0.2, 0.2, 41)
    for reach in (2.5, 1.5, 1.0, 1.0, 1.0):
        _, height, width = min(_fits(base, level, phase, WIDTHS[::2]))
        still = level - height * sawtooth(phase, width)
        still = level - base @ (base.T @ still)
        off = np.array([(still - height * sawtooth(phase + shift, width)) ** 2 for shift in shifts])
        off = _smoothed(off, reach * tooth)
        least = off.argmin(axis=0).clip(1, shifts.size - 2)
        before, now, after = off[least - 1, at], off[least, at], off[least + 1, at]
        fine = 0.5 * (before - after) / np.maximum(before - 2 * now + after, np.finfo(float).tiny)
        step = shifts[least] + fine.clip(-0.5, 0.5) * (shifts[1] - shifts[0])
        phase = phase + _smoothed(step, 0.5 * reach * tooth)
    fits = np.array(list(_fits(base, level, phase, WIDTHS)))
    misfit, height, _ = fits[fits[:, 0].argmin()].tolist()
    weight = np.exp(-0.5 * (fits[:, 0] / misfit - 1) * (size - base.shape[1]))
    width = float(weight @ WIDTHS / weight.sum())
    spread = math.sqrt(weight @ (WIDTHS - width) ** 2 / weight.sum() + np.ptp(WIDTHS[:2]) ** 2 / 12)
    left = level - height * sawtooth(phase, width)
    left -= base @ (base.T @ left)
    return Teeth(phase, (width, spread), height, left, misfit / size, 1 - misfit / float(level @ level))


def _fits(base: Array, level: Array, phase: Array, widths: Array) -> Iterator[tuple[float, float, float]]:
    """Return the sum of squares that teeth of each width, with a shift of their phase, leave, their height and width."""
    whole = float(level @ level)
    for width in widths.tolist():
        ahead, behind = sawtooth(phase + 0.02, width), sawtooth(phase - 0.02, width)
        columns = np.column_stack([sawtooth(phase, width), ahead - behind])
        columns -= base @ (base.T @ columns)
        (height, shift), *_ = np.linalg.lstsq(columns, level, rcond=None)
        left = level - columns @ (height, shift)
        yield (float(left @ left), float(height), width) if height > 0 else (whole, 0.0, width)


def _slope(torque: Array, teeth: Teeth, step: float) -> Number | None:
    """Return the slope of samples of one ramp, over all ramps but those that are far off; None for too few."""
    ramp = _ramp(teeth)
    tooth, time, held = np.floor(teeth.phase[ramp]).astype(int), step * np.flatnonzero(ramp), torque[ramp]
    tooth -= tooth.min()
    count = np.bincount(tooth)
    time, held = (x - (np.bincount(tooth, x) / np.maximum(count, 1))[tooth] for x in (time, held))
    climb, spread = (np.bincount(tooth, x)[count > 1] for x in (time * held, time * time))
    if climb.size < TEETH:
        return None
    off = np.abs(climb - np.median(climb / spread) * spread)
    near = off <= 3.5 * 1.4826 * np.median(off)
    climb, spread = climb[near], spread[near]
    slope = climb.sum() / spread.sum()
    return float(slope), float(np.linalg.norm(climb - slope * spread) / spread.sum())


def _numbers(name: str, speed: Array, torque: Array, teeth: Teeth, step: float, averaging: float | None) -> Record:
    """Return what teeth tell; None, and a sentence, for a number that is not sure."""
    slips = np.interp(np.arange(np.ceil(teeth.phase[0]), teeth.phase[-1]), teeth.phase, step * np.arange(speed.size))
    period, error = np.diff(slips).mean(), np.diff(slips).std(ddof=1) / math.sqrt(slips.size - 1)
    blocks = [part.mean() for part in np.array_split(speed, BLOCKS)]
    mean, mean_error = speed.mean(), np.std(blocks, ddof=1) / math.sqrt(BLOCKS)
    width, width_error = teeth.width
    said = [f"the screw jerks {1 / period:.3g} times a second, so its mean torque is no point of the friction law."]
    found: dict[str, Number] = {
        "period": (period, error),
        "displacement": (mean * period, mean * period * math.hypot(mean_error / mean, error / period)),
        "fall": (width * period, math.hypot(width_error, BLUR) * period),
    }
    if averaging is None:
        said.append(
            f"the torque falls within {width * period:.2g} s as recorded, by the slip and by averaging, which "
            "cannot be told apart; the errors of breakaway and of the torque after the slip allow for both."
        )
    height = 0.0
    if slope := _slope(torque, teeth, step):
        windows = (0.0, step) if averaging is None else (averaging, averaging)
        longest, shortest = (
            min(math.sqrt(max((width + blur) ** 2 - (window / period) ** 2, 0) / shape), LONGEST)
            for window, blur, shape in zip(windows, (BLUR, -BLUR), SHAPE, strict=True)
        )
        slip, slip_error = 0.5 * (longest + shortest), (longest - shortest) / math.sqrt(12)
        height = slope[0] * period  # of a tooth whose slip takes no time
        middle, middle_error = torque.mean() + DAMPED * slip * height, teeth.left.std() / math.sqrt(speed.size)
        half = 0.5 * (1 - slip) * period
        parts = (half * slope[1], 0.5 * height * slip_error, middle_error, DAMPED * slip * height)
        torques_error = float(np.linalg.norm(parts))
        stiffness = slope[0] / mean
        found |= {
            "slope": slope,
            "stiffness": (stiffness, abs(stiffness) * math.hypot(slope[1] / slope[0], mean_error / mean)),
            "breakaway": (middle + half * slope[0], torques_error),
            "after": (middle - half * slope[0], torques_error),
        }
    else:
        said.append(f"fewer than {TEETH} ramps hold two samples, so neither slope nor stiffness nor torques are told.")
    for key, words in UNSURE_OF.items():
        value, error = found.get(key, (1.0, 0.0))
        if error > UNSURE * (height if "torque" in words else abs(value)):
            said.append(f"the {words} cannot be told, for its standard error would be {error:.2g} of {value:.2g}.")
            del found[key]
    numbers = {key: (float(value), float(error)) for key, (value, error) in found.items()}
    return Record(name, "jerks", tuple(f"{name}: {text}" for text in said), **numbers, teeth=slips.size - 1)
