"""A measured file over time: rest, even turning, a start, a stop, a ramp or jerks, and what the jerks tell.

In stick–slip the screw stands while a spring k winds up at the commanded speed Ω, so the torque, in the direction of
turning, climbs as dT/dt = k Ω; it then slips within a time s, and the torque falls. A tooth of period P is

    T_breakaway − T_after = k Ω (P − s),    mean torque = (T_breakaway + T_after) / 2.

A recorder that averages over a time w rounds corners, but leaves means and the slope within a ramp. So the slope is
that of samples of one ramp, P that of the phase, Ω the mean of the recorded speed, and only s needs the shape: the fall
lasts d, with d² = w² + (0.3 to 0.57) s². A damper takes part in the fall; it puts the mean below the middle by 2ζ/π s/P
of the height. Sampled each Δ, a line at f is also one at 1/Δ − f, a sawtooth reversed in time: the one that climbs
slowly and falls fast counts. Below LEAST samples a tooth nothing is told. f + 1/Δ gives the samples of f: f is taken.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lsvib.sheets.torque.starts import Array, Moved, Number, grain, told
from lsvib.sheets.torque.tables import REST, SPIKE, Recording, drifts

Kind = Literal["rest", "even", "ramp", "start", "stop", "jerks"]

LEAST = 2.3  # samples a tooth: at 2, a sawtooth and its reverse are the same samples
SHORTEST, TEETH = 64, 8  # samples of a record, and teeth or ramps of it, of which jerks are told
SPOILED = 0.05  # of the samples, rows that may be lost
SLOWLY = 0.7  # correlation of neighbouring speeds from which on a screw turns both ways; less is noise about rest
NOT_EVEN = "its samples are not known to be evenly spaced in time"
UNEVEN = 0.1  # of the interval, by which a time that is rounded may be off that of even samples
EXPLAINED = 0.8  # of the variance beside slow change, by teeth; of two frequencies alike they explain 0.78 at most
LIKELIER = 25.0  # by χ², five standard errors, by which a sawtooth must fit better than its reverse
SWINGS = 0.2  # of the mean speed: standard deviation from which on slow changes are a motion of their own
STANDS = 0.7  # of the mean speed, in two of five samples: a screw that is faster does not stand
OTHER = 0.25  # of the amplitude of the teeth: a second line beyond is a second frequency
FASTER = 0.25  # of the mean number of teeth in a quarter of the file, by which quarters may differ
RAMP = (0.3, 0.9)  # of a tooth: after the slip a controller, and what records the torque, still settle
CHOSEN = 1.2  # by which the scatter of ramps makes too little of the error, as noise has part in where a ramp is seen
WIDTHS = np.linspace(0.01, 0.65, 33)  # of the fall as recorded, in periods
FOLLOWED = ((1.0, 6.0), (0.7, 4.0))  # teeth, or samples if they are more, over which a phase is followed, then closer
BLUR = 0.03  # periods, by which the phase of teeth that differ, as it is followed, blurs the width
SHAPE = (0.3, 0.57)  # (d² − w²) / s² of a slip that a damper slows, and of half a cosine
LONGEST = 0.25  # periods: a longer slip is none
DAMPED = 0.13  # 2ζ/π of ζ = 0.2, and its error, as ζ is unknown
BLOCKS = 16  # of a file, of whose mean speeds the error of the mean speed is told
UNSURE = 0.3  # relative standard error of the mean speed from which on nothing that rests on it is told


@dataclass(frozen=True)
class Record:
    """What a file is, ``said`` in sentences, and what jerks tell, with standard errors over the teeth, or None.

    ``period`` [s], ``slope`` of the ramps [N m/s] and ``stiffness`` [N m/rad], the torque at ``breakaway`` and
    ``after`` the slip in the direction of turning [N m], and the number of ``teeth``. Starts and stops tell the
    ``inertia`` of all that turns [kg m²], less that of a known mass that moves with it, and ``breakaway``; ``turning``
    is that inertia also where its error is so large that it is not told.
    """

    file: str
    kind: Kind
    said: tuple[str, ...]
    period: Number | None = None
    slope: Number | None = None
    stiffness: Number | None = None
    breakaway: Number | None = None
    after: Number | None = None
    inertia: Number | None = None
    turning: Number | None = None
    teeth: int | None = None


@dataclass(frozen=True)
class Teeth:
    """Teeth of a torque: ``phase`` (n) in turns, whole where the screw slips, and ``width`` of the fall in turns.

    ``left`` (n) is what teeth of this ``height`` leave of the torque, ``misfit`` its mean square,
    ``explained`` the share of the variance that they do not leave.
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


def look(
    recording: Recording, interval: float | None = None, averaging: float | None = None, load: Moved | None = None
) -> Record:
    """Return what a recording is that was sampled each ``interval`` (None: as its time says), averaged over a time [s].

    ``averaging``: the window over which the recorder averages, None where it is unknown, up to an interval.
    ``load``: as in :func:`lsvib.sheets.torque.starts.told`.
    """
    recording, step = evenly(recording, interval)
    name, speed = recording.name, recording.speed
    mean = float(speed.mean())
    either_way = speed.min() < 0 < speed.max() and abs(mean) < 3 * speed.std() / math.sqrt(speed.size)
    slowly = bool(speed[1:] @ speed[:-1] > SLOWLY * (speed @ speed))  # one way, then the other
    if (either_way and not slowly) or not speed.any() or np.count_nonzero(speed) < min(TEETH, speed.size):
        return Record(name, "rest", (f"{name}: the screw rests, or turns as much one way as the other.",))
    resting = np.abs(speed) < REST * (np.abs(speed).mean() if either_way else abs(mean))
    runs = np.diff(np.flatnonzero(np.concatenate([[True], ~resting, [True]]))) - 1  # of rests about samples that turn
    inner = runs[1:-1] if np.count_nonzero(runs[1:-1]) > 2 else runs[:0]  # of jerks; a rest or two part starts
    most = 2 * max(1, int(inner.max(initial=0)))
    words = [word for word, run in (("begins", runs[0]), ("ends", runs[-1])) if run > most]
    if words:
        said = f"{name}: the record {' and '.join(words)} at rest; only where the screw turns can it be steady motion."
        return _moved(recording, "start" if words[0] == "begins" else "stop", said, step, averaging, load)
    if either_way or drifts(speed):
        first, last = speed[: speed.size // 8 + 1].mean(), speed[-(speed.size // 8 + 1) :].mean()
        said = f"{name}: the speed goes from {first:.3g} to {last:.3g} rad/s, so this is not steady motion."
        return _moved(recording, "ramp", said, step, averaging, load)
    stops = bool(np.quantile(speed / mean, 0.4) <= STANDS)
    if speed.size < SHORTEST:
        problem = f"there are only {speed.size} samples"
    elif not step:
        problem = NOT_EVEN
    else:
        speed, torque = np.sign(mean) * speed, np.sign(mean) * recording.torque
        off = np.abs(torque - np.median(torque))
        torque = np.where(off > SPIKE * 1.4826 * np.median(off), np.median(torque), torque)
        teeth, problem = _told(speed, torque, stops)
    swing = recording.speed - mean
    if not stops and problem and swing.std() > SWINGS * abs(mean) and swing[1:] @ swing[:-1] > SLOWLY * (swing @ swing):
        low, high = np.sort(recording.speed)[[0, -1]]
        said = f"{name}: the speed swings from {low:.3g} to {high:.3g} rad/s, so this is not steady motion."
        return _moved(recording, "ramp", said, step, averaging, load)
    if not stops and problem:
        return Record(name, "even", (f"{name}: the screw turns steadily.",))
    if problem or not stops:
        said = "the torque climbs slowly and falls fast as in jerks, but the recorded speed does not stop"
        said = f"the recorded speed is often far below its mean, as in jerks, but {problem}" if stops else said
        return Record(name, "jerks", (f"{name}: {said}; no numbers are given.",))
    return _numbers(name, speed, torque, teeth, step, averaging)


def evenly(recording: Recording, interval: float | None) -> tuple[Recording, float]:
    """Return a recording at even times, straight lines where rows are lost or uneven, and their interval [s].

    It is zero where times are not known, do not ascend or leave out too much; those may be rounded.
    """
    at = recording.time
    if interval or at is None or at.size < 2:
        return recording, interval or 0.0
    step, gaps = float(at[-1] - at[0]) / (at.size - 1), np.diff(at)
    off = np.abs(at - at[0] - step * np.arange(at.size)).max()
    rounded = grain(gaps)  # of a time; a row that is lost makes a gap of a whole step more
    if step > 0 and off <= max(UNEVEN * step, 1.001 * rounded * (rounded < 0.75 * step)):
        return recording, step
    step = float(np.median(gaps))
    if gaps.min() <= 0 or at[-1] - at[0] > (1 + SPOILED) * at.size * step:
        return recording, 0.0
    even = np.arange(at[0], at[-1] + 0.5 * step, step)
    found = {name: np.interp(even, at, getattr(recording, name)) for name in ("speed", "torque")}
    return replace(recording, **found, time=even), step


def _moved(
    recording: Recording, kind: Kind, said: str, step: float, averaging: float | None, load: Moved | None
) -> Record:
    """Return what a record of starts, stops or ramps tells, sampled each ``step``, 0 where it is not even."""
    why = "" if step and recording.speed.size >= SHORTEST // 2 else NOT_EVEN if not step else "it is too short"
    more = [f"no inertia is found, as {why}."]
    numbers: dict[str, Any] = {}
    if not why:
        numbers, more = told(recording.speed, recording.torque, step, averaging, load)
    return Record(recording.name, kind, (said, *(f"{recording.name}: {text}" for text in more)), **numbers)


def _told(speed: Array, torque: Array, stops: bool) -> tuple[Teeth, str]:
    """Return teeth, and why they are none of which numbers can be told; those of the torque alone if no speed stops."""
    for closely in FOLLOWED:
        forward, reverse = (
            _teeth(sign * torque, _line(torque, speed if stops else torque), *closely) for sign in (1, -1)
        )
        found = min(forward, reverse, key=lambda teeth: teeth.misfit)
        if found.explained > EXPLAINED:
            break
    likelier = abs(forward.misfit - reverse.misfit) / found.misfit * speed.size
    ramp, often = _ramp(found), found.frequency
    other = 4 / speed.size * np.abs(np.fft.rfft(np.hanning(speed.size) * found.left))
    for k in range(6):  # harmonics, folded
        from_line = np.abs(np.fft.rfftfreq(speed.size) - abs((k * often + 0.5) % 1 - 0.5))
        other[from_line < (0.15 if k else 0.35) * often] = 0
    quarters = [np.ptp(part) for part in np.array_split(found.phase, 4)]
    problems = {
        f"only {np.ptp(found.phase):.0f} times": 1 < np.ptp(found.phase) < TEETH + 1,
        "at no single frequency that stands out": found.explained < EXPLAINED,
        "its torque does not climb slowly and fall fast": likelier < LIKELIER,
        "its torque climbs fast and falls slowly, as fewer than two samples a jerk would show it": found is reverse,
        f"it is sampled less than {LEAST:g} times a jerk": often > 1 / LEAST,
        "not while its torque climbs": stops and speed[ramp].sum() > STANDS * speed.mean() * np.count_nonzero(ramp),
        "at two frequencies": other.max() > OTHER * found.height / math.pi,
        "few of its ramps have two samples": math.isnan(_slope(torque, found)[0]),
        "more and more, or less and less often": np.ptp(quarters) > FASTER * np.mean(quarters),
    }
    return found, next((problem for problem, holds in problems.items() if holds), "")


def _ramp(teeth: Teeth) -> NDArray[np.bool_]:
    """Where samples are within a ramp, apart from the fall."""
    place, edge = teeth.phase % 1, 0.5 * teeth.width[0] + BLUR
    return (place > max(RAMP[0], edge)) & (place < min(RAMP[1], 1 - edge))


def _line(torque: Array, speed: Array) -> float:
    """Return the frequency [1/sample] at which torque and speed swing together most, of the mean of cross spectra."""
    size = max(torque.size // 4, SHORTEST)
    both = _quick(_slow(torque.size, 8), np.stack([torque, speed]))
    parts = [both[:, k : k + size] for k in range(0, torque.size - size + 1, size // 2)]
    spectra = [np.fft.rfft(np.hanning(size) * (part - part.mean(axis=1, keepdims=True)), 8 * size) for part in parts]
    power = np.abs(sum(one.conj() * other for one, other in spectra))
    power[: 3 * 8] = 0  # fewer than three in a part are no line
    return int(np.argmax(power[1:]) + 1) / (8 * size)


def _slow(size: int, terms: int) -> Array:
    """Return orthonormal columns of slow change: cosines of up to so many half waves."""
    waves = np.cos(np.pi * np.outer(np.arange(size) + 0.5, np.arange(terms + 1)) / size)
    return np.asarray(waves / np.sqrt((waves**2).sum(axis=0)))


def _quick(base: Array, values: Array) -> Array:
    """Return values, by their last axis, without what is slow; without BLAS, whose threads take long to wake."""
    return np.asarray(values - np.einsum("nk,...k->...n", base, np.einsum("nk,...n->...k", base, values)))


def sawtooth(phase: Array, width: float | Array) -> Array:
    """Return teeth over a phase in turns: they climb from −1/2 to 1/2, fall at whole phases, averaged over a width."""
    later, sooner = (edge - np.floor(edge) - 0.5 for edge in (phase + 0.5 * width, phase - 0.5 * width))
    return 0.5 * (later**2 - sooner**2) / width


def _smoothed(values: Array, width: float) -> Array:
    """Return Gaussian means along the last axis, of a standard deviation in samples."""
    size, half = values.shape[-1], int(3 * width) + 1
    whole = 1 << (size + 2 * half - 1).bit_length()  # a length of many small factors, for speed
    weight = np.fft.rfft(np.exp(-0.5 * (np.arange(-half, half + 1) / width) ** 2), whole)
    both = (np.fft.irfft(np.fft.rfft(x, whole) * weight, whole) for x in (values, np.ones(size)))
    means, ones = (x[..., half : half + size] for x in both)
    return np.asarray(means / ones)


def _teeth(torque: Array, frequency: float, memory: float, fewest: float) -> Teeth:
    """Fit teeth of about a frequency [1/sample], whose phase wanders, beside a slow change of the torque.

    The phase starts from the line, in a window of about two teeth; five times it is shifted to where teeth fit best.
    """
    size, tooth, at = torque.size, max(1 / frequency, fewest), np.arange(torque.size)
    base = _slow(size, int(np.clip(0.3 * size * frequency, 4, 48)))
    level = _quick(base, torque)
    beat = level * np.exp(-2j * np.pi * frequency * at)
    angle = np.angle(_smoothed(beat.real, memory * tooth) + 1j * _smoothed(beat.imag, memory * tooth))
    phase = frequency * at + np.unwrap(angle) / (2 * np.pi) - 0.25  # teeth are 1/π cos(2π (phase + 1/4)) + ...
    shifts = np.linspace(-0.2, 0.2, 41)
    for reach in (2.5, 1.5, 1.0, 1.0, 1.0):
        _, height, width = min(_fits(base, level, phase, WIDTHS[::4]).tolist())
        sway = level - height * sawtooth(phase, width)
        still = level - sway + _quick(base, sway)
        off = (still - height * sawtooth(phase + shifts[:, None], width)) ** 2
        off = _smoothed(off, reach * tooth)
        least = off.argmin(axis=0).clip(1, shifts.size - 2)
        before, now, after = off[least - 1, at], off[least, at], off[least + 1, at]
        fine = 0.5 * (before - after) / np.maximum(before - 2 * now + after, np.finfo(float).tiny)
        step = shifts[least] + fine.clip(-0.5, 0.5) * (shifts[1] - shifts[0])
        phase = phase + _smoothed(step, 0.5 * reach * tooth)
    fits = _fits(base, level, phase, WIDTHS)
    tiny, (misfit, height, _) = np.finfo(float).tiny, min(fits.tolist())
    weight = np.exp(-0.5 * (fits[:, 0] - misfit) / (misfit + tiny) * (size - base.shape[1]))
    width = float(np.average(WIDTHS, weights=weight))
    spread = math.sqrt(np.average((WIDTHS - width) ** 2, weights=weight) + np.ptp(WIDTHS[:2]) ** 2 / 12)
    left = _quick(base, level - height * sawtooth(phase, width))
    explained = 1 - (misfit + tiny) / float(level @ level + tiny)
    return Teeth(phase, (width, spread), height, left, misfit / size + tiny, explained)


def _fits(base: Array, level: Array, phase: Array, widths: Array) -> Array:
    """Return the squares that teeth of each width, free in height and shift, leave, their height and width (k, 3)."""
    over = widths[:, None]
    ahead, behind = sawtooth(phase + 0.02, over), sawtooth(phase - 0.02, over)
    one, shift = _quick(base, np.stack([sawtooth(phase, over), ahead - behind]))
    a, b, c = (np.einsum("kn,kn->k", *pair) for pair in ((one, one), (shift, shift), (one, shift)))
    p, q = (np.einsum("kn,n->k", own, level) for own in (one, shift))
    height, moved = np.array([b * p - c * q, a * q - c * p]) / (np.maximum(a * b - c * c, 1e-9 * a * b) + 1e-99)
    gain = np.where(height > 0, height * p + moved * q, 0.0)
    return np.column_stack([level @ level - gain, np.maximum(height, 0), widths])


def _slope(torque: Array, teeth: Teeth) -> Number:
    """Return the slope by samples of one ramp, over all ramps but those that are far off; NaN for too few."""
    ramp = _ramp(teeth)
    _, tooth, count = np.unique(np.floor(teeth.phase[ramp]), return_inverse=True, return_counts=True)
    time, held = (x - (np.bincount(tooth, x) / count)[tooth] for x in (np.flatnonzero(ramp), torque[ramp]))
    climb, spread = (np.bincount(tooth, x)[count > 1] for x in (time * held, time * time))
    if climb.size < TEETH:
        return math.nan, math.nan
    off = np.abs(climb - np.median(climb / spread) * spread)
    near = off <= 3.5 * 1.4826 * np.median(off)
    slope = climb[near].sum() / spread[near].sum()
    return float(slope), float(CHOSEN * np.linalg.norm((climb - slope * spread)[near]) / spread[near].sum())


def _numbers(name: str, speed: Array, torque: Array, teeth: Teeth, step: float, averaging: float | None) -> Record:
    """Return what teeth tell, and a sentence where the mean speed, and what rests on it, is not sure."""
    slips = np.interp(np.arange(np.ceil(teeth.phase[0]), teeth.phase[-1]), teeth.phase, step * np.arange(speed.size))
    period, count, mean = np.diff(slips).mean(), slips.size - 1, speed.mean()
    error = math.hypot(_error(np.diff(slips)), BLUR * period / count)  # of the teeth, and of where they are
    mean_error = _error(np.array([part.mean() for part in np.array_split(speed, BLOCKS)])) / mean
    width, blur = teeth.width[0], math.hypot(teeth.width[1], BLUR)
    said = [f"the screw jerks {1 / period:.3g} times a second, so its mean torque is not a point of the friction law."]
    slope = tuple(value / step for value in _slope(torque, teeth))
    found = {"period": (period, error), "slope": slope}
    beat = abs(1 / teeth.frequency - round(1 / teeth.frequency)) * slips.size
    if mean_error > UNSURE or beat < 1:  # within an interval, samples see the same part of all teeth
        why = "samples keep in step with the jerks" if beat < 1 else f"its standard error is {mean_error:.0%}"
        said.append(f"the mean speed is uncertain, as {why}, so no stiffness is found.")
    else:
        found["stiffness"] = (slope[0] / mean, slope[0] / mean * math.hypot(slope[1] / slope[0], mean_error))
    if averaging is not None and averaging > (width + 2 * blur) * period:
        said.append(f"averaging over {averaging:.3g} s would hide the fall of torque that is seen, so it is not used.")
        averaging = None
    windows = (0.0, step) if averaging is None else (averaging, averaging)
    longest, shortest = (
        min(math.sqrt(max(max(width + edge, 0) ** 2 - (window / period) ** 2, 0) / shape), LONGEST)
        for window, edge, shape in zip(windows, (BLUR, -BLUR), SHAPE, strict=True)
    )
    slip, slip_error = 0.5 * (longest + shortest), (longest - shortest) / math.sqrt(12)
    half, height = 0.5 * (1 - slip) * period, slope[0] * period
    middle = torque.mean() + DAMPED * slip * height
    parts = (half * slope[1], 0.5 * height * slip_error, DAMPED * slip * height, _error(teeth.left))
    for key, side in (("breakaway", 1), ("after", -1)):
        found[key] = (middle + side * half * slope[0], np.linalg.norm(parts))
    if averaging is None:
        said.append(
            f"the torque falls within {(width + BLUR) * period:.2g} s as recorded, through slip and through averaging, "
            "which cannot be separated; the errors of the torques allow for both."
        )
    numbers = {key: (float(value), float(error)) for key, (value, error) in found.items()}
    return Record(name, "jerks", tuple(f"{name}: {text}" for text in said), **numbers, teeth=count)


def _error(values: Array) -> float:
    """Return the standard error of a mean of independent values."""
    return float(values.std(ddof=1) / math.sqrt(values.size))
