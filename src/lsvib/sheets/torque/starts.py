"""What starts, stops and ramps tell: the inertia of what turns, and the torque at which a screw at rest breaks loose.

Where it turns, T = T_0 + c |ω| + J dω/dt, with a T_0 of friction and load for each direction. Recorded are means over
some time, which obey the same equation. Their derivative is not recorded, so it is integrated over two samples Δ:

    (T₋ + 4 T + T₊) / 6 = T_0 + c |ω| + J (ω₊ − ω₋) / 2Δ        (Simpson's rule, ω as T)

Noise in ω₊ − ω₋ would make J too small, so the equations are weighed not with it, but with its sign where it stands
out, and with zero where the speed is even (instrumental variables). A swing of T_0 with the angle is fitted too.
Friction that falls with the speed looks like inertia: J is that of laws with a fading rise of T_0, each as likely as it
fits. Its error holds their differences, the residuals with their serial correlation and, at the corners of a ramp, what
an unknown time of averaging may change.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lsvib.sheets.torque.tables import REST

Array = NDArray[np.float64]
Number = tuple[float, float]  # a value with its standard error
Moved = Callable[[Array, Array], Array]

SHORTEST = 48  # samples, of which two in each may be taken together
FEWEST = 3  # samples of a ramp, without those in which the screw still or again rests
APART = 0.01  # of what accelerates, that neither friction nor load explain: of less nothing is told
SPARE = 8  # samples more than numbers of a law
STANDS_OUT = 0.15  # of the largest rate of the speed, and
NOISE = 4.0  # times its usual rate in even turning: less is no ramp
FAR, NEAR = 4, 5  # samples from which on noise of rates is independent, and up to which that of torques may be alike
QUANTUM = 0.2  # of a step of rounding, over an interval: standard deviation that it gives the rate
CORNER = 0.2  # of what changes at the corner of a ramp, which averages over no time or a sample show differently
FADING = (0.0, 0.1, 0.2, 0.4, 0.8)  # of the largest speed: over which a rise of friction may fade; 0 is none
UNSURE = 0.25  # relative standard error from which on nothing is told
UNSEEN = 0.2  # of an interval: how long the screw may turn before its recorded speed shows it
TURNS = 1.5  # of the screw, from which on the swing of friction in a turn is told apart
CLIMB = 5.0  # times the noise, by which the torque must climb through rest


def told(
    speed: Array, torque: Array, step: float, averaging: float | None, load: Moved | None
) -> tuple[dict[str, Number], list[str]]:
    """Return ``inertia`` [kg m²] and ``breakaway`` [N m] with errors, and why others are not told.

    ``step``: the interval of the samples [s]; ``averaging``: over which time each stands, None where it is unknown.
    ``load``: the torque [N m] that what moves along the axis takes, at speeds and their rates, if it is known.
    """
    # The rounding of a slow speed does not average out.
    rounded = grain(speed)
    found, why = _of_ramps(speed, torque, step, averaging or 0.0, rounded, load)
    said = [f"no inertia is found, as {why}."] if why else []
    rests = np.abs(speed) < REST * np.abs(speed).max()
    if rests[0] and not rests.all():
        breakaway, why = _breakaway(speed, torque, rests, None if averaging is None else averaging / step)
        found |= {"breakaway": breakaway} if not why else {}
        said += [f"no breakaway torque is found, as {why}."] if why else []
    return found, said


def grain(values: Array) -> float:
    """Return the step to which values are rounded: the least by which they, or what is between two, differ."""
    gaps = np.round(np.diff(np.unique(values)), 12 - math.ceil(math.log10(np.abs(values).max() + 1e-99)))
    return float(np.diff(np.unique(np.append(gaps, 0.0))).min(initial=np.ptp(values)))


def _of_ramps(
    speed: Array, torque: Array, step: float, averaging: float, rounded: float, load: Moved | None
) -> tuple[dict[str, Number], str]:
    """Return inertia, and why there is none; of means of two samples where one changes too little."""
    stops = np.abs(speed) < REST * np.abs(speed).max()
    stops |= np.append(speed[1:], speed[-1]) * speed < 0
    reach = 1 + math.ceil(max(averaging, step) / step - 1e-9)  # of samples in whose mean a rest takes part
    mixed = np.convolve(stops, np.ones(2 * reach + 1), "same") > 0 if 2 * reach < speed.size else stops | True
    turns = 1 + np.flatnonzero(~mixed[1:-1])
    rate = (speed[turns + 1] - speed[turns - 1]) / (2 * step)
    least = STANDS_OUT * float(np.abs(rate).max(initial=0.0))
    mostly = rate.size > 2 * FAR and float(np.median(np.abs(rate))) > least
    # Where ramps fill more than half, the usual rate is noise, which varies three times as much in the difference of
    # two that share a speed; and rates with noise of their own show the way of the speed.
    noise = _usual(rate[2:] - rate[:-2]) / math.sqrt(3) if mostly else _usual(rate)
    usual = NOISE * (noise + QUANTUM * rounded / step)
    way = 0.5 * (np.roll(rate, FAR) + np.roll(rate, -FAR)) if mostly else rate
    ramp = np.abs(way) > max(least, usual)
    # Of a ramp near the noise, the samples that stand out would be those that noise makes larger.
    if np.count_nonzero(ramp) >= FEWEST and np.median(np.abs(rate[ramp])) > 1.5 * usual:
        inertia, why = _inertia(speed, torque, step, turns, np.where(ramp, np.sign(way), 0.0), load)
        known = {"turning": inertia} if inertia[1] else {}
        return known if why else known | {"inertia": inertia}, why
    if speed.size >= 2 * SHORTEST:
        even = speed.size // 2 * 2
        speeds, torques = (x[:even].reshape(-1, 2).mean(axis=1) for x in (speed, torque))
        return _of_ramps(speeds, torques, 2 * step, averaging + step, rounded, load)
    return {}, f"the speed does not clearly change in {FEWEST} samples in which the screw surely turns"


def _usual(rate: Array) -> float:
    """Return the usual rate of the speed, that of even turning or noise."""
    return 1.4826 * float(np.median(np.abs(rate))) if rate.size else 0.0


def _inertia(
    speed: Array, torque: Array, step: float, at: NDArray[np.intp], ramp: Array, load: Moved | None
) -> tuple[Number, str]:
    """Return the inertia, and why it is none; ``at``: samples that turn, ``ramp``: the way of the speed in ramps."""
    held, turned = ((x[at - 1] + 4 * x[at] + x[at + 1]) / 6 for x in (torque, speed))
    rate, bent = (speed[at + 1] - speed[at - 1]) / (2 * step), torque[at - 1] - 2 * torque[at] + torque[at + 1]
    if load is not None:
        held -= load(turned, rate)
    sense, fast = np.sign(turned), np.abs(turned)
    columns = [sense == way for way in (-1, 1) if (sense == way).any()] + [turned]
    angle = (np.cumsum(speed) * step)[at]
    if np.abs(speed[at]).sum() * step > 2 * math.pi * TURNS:
        ways = (sense, 1.0) if len(columns) == 3 else (1.0,)  # of friction, and of what a load does
        columns += [way * wave for way in ways for wave in (np.cos(angle), np.sin(angle))]
    if at.size < len(columns) + 2 + SPARE:
        return (0.0, 0.0), f"the screw surely turns in {at.size} samples only"
    fits = []
    for fading in FADING:
        rise = [sense * np.exp(-fast / (fading * fast.max()))] if fading else []
        others = np.column_stack([*columns, *rise]).astype(float)
        others /= np.linalg.norm(others, axis=0)
        base = np.linalg.svd(others, full_matrices=False)[0]
        weight, free, torques = (x - base @ (base.T @ x) for x in (ramp, rate, held))
        if not (size := float(weight @ free)) > APART * float(ramp @ rate):
            return (0.0, 0.0), "without steady turning, acceleration cannot be separated from friction"
        inertia = float(weight @ torques) / size
        left = torques - inertia * free
        serial, count = _variance(weight, left, base.shape[1] + 1)
        variance = max(serial, float(weight**2 @ left**2)) + float(weight**2 @ (CORNER * bent) ** 2)
        fits.append((inertia, math.sqrt(variance) / size, float(left @ left), count))
    value, error, misfit, alike = np.array(fits).T
    least = max(misfit.min() / (at.size - len(columns) - 2), 1e-30) * alike[misfit.argmin()]
    likely = np.exp(-0.5 * (misfit - misfit.min()) / least)
    mean = float(np.average(value, weights=likely))
    whole = math.sqrt(np.average(error**2 + (value - mean) ** 2, weights=likely))
    unsure = whole > UNSURE * mean
    return (mean, whole), "the torque that accelerates is not far enough above its error" if unsure else ""


def _variance(weight: Array, left: Array, numbers: int) -> Number:
    """Return the variance of a weighed sum of residuals, as alike as they are anywhere, and how many count as one."""
    size = left.size
    alike, both = (np.fft.irfft(np.abs(np.fft.rfft(x, 2 * size)) ** 2)[: size // 4] for x in (left, weight))
    alike /= size
    # What is fitted leaves no residual like the weight, but noise of neighbours, which Simpson's rule makes alike.
    near = 2 * float(alike[:NEAR] @ both[:NEAR]) - alike[0] * both[0]
    alike *= np.linspace(1, 0, size // 4, endpoint=False)  # covariances, fading to zero (Bartlett)
    total = max(2 * float(alike @ both) - alike[0] * both[0], near, alike[0] * both[0])
    count = 2 * float(alike.sum()) / max(alike[0], 1e-300) - 1
    return float(total * size / (size - numbers)), max(1.0, count)


def _breakaway(speed: Array, torque: Array, rests: NDArray[np.bool_], averaging: float | None) -> tuple[Number, str]:
    """Return the torque at which the first rest ends, and why it is none; ``averaging`` in samples.

    The screw turns from between two samples on, of which the first is at rest. So the torque is between theirs, or it
    climbed on from the first and fell at once. A mean over a window is the torque in the middle of it.
    """
    first = int(np.argmin(rests))  # the screw turns for sure; how its speed looks at rest, the first half of it shows
    last = int(np.argmax(np.abs(speed[: first + 1]) > 1.5 * np.abs(speed[: first // 2 + 1]).max())) - 1
    if last < 2 or last + 2 >= speed.size:
        return (0.0, 0.0), "fewer than 3 samples are at rest"
    sense = float(np.sign(speed[first]))
    held = sense * torque[: last + 3]
    noise = 1.4826 * float(np.median(np.abs(np.diff(torque)))) / math.sqrt(2)
    if held[last] - np.median(held[: last // 2 + 1]) < CLIMB * noise or held[last] <= max(0.0, held[:last].max()):
        return (0.0, 0.0), "the torque is not seen to climb at rest before the start"
    sooner, before, climb, after = np.diff(held[last - 2 :]).clip(0.0).tolist()
    ahead = before + max(before - sooner, 0.0)  # as a controller sums up what it lags behind, it climbs ever faster
    window, unknown = (0.5, 1.0) if averaging is None else (averaging, 0.0)
    jump, gain = sense * speed[last + 1], sense * (speed[last + 2] - speed[last + 1])
    fell = climb < ahead or after <= 0 or jump >= gain
    # When the screw breaks loose at the latest, by the speed of the first sample that turns, if it gains evenly.
    at = 0.5 * window - (0.0 if fell else jump / gain * (1 + window))
    low = held[last]
    high = max(held[last + 1] + after * max(at, 0.0) + climb * min(at, 0.0), held[last] + ahead * (1 + at) * fell)
    parts = ((high - low) / 3, UNSEEN * max(before, climb), unknown * (high - low) / 4, noise)
    value, error = 0.5 * (low + high), math.hypot(*parts)
    return (float(value), error), "the torque climbs too fast between two samples" if error > UNSURE * value else ""
