"""How much faster one method is than others at an equal error."""

import math
from collections.abc import Iterable, Sequence


def time_at_error(points: Iterable[tuple[float, float]], level: float) -> float:
    """Return the time [s] that a method needs for an error of at most ``level``; nan if it never gets there.

    ``points``: pairs (error, time [s]) of its runs. Between two runs error and time are interpolated in logarithms; a
    method whose coarsest run is already better needs the time of its fastest run that is good enough.
    """
    found = math.nan
    runs = sorted((error, seconds) for error, seconds in points if error >= 0 and seconds > 0)
    for k, (error, seconds) in enumerate(runs):
        if error > level:
            continue
        best = seconds
        if k + 1 < len(runs) and runs[k + 1][0] > level and error > 0 and runs[k + 1][1] < seconds:
            worse, quick = runs[k + 1]
            share = math.log(level / error) / math.log(worse / error)
            best = math.exp((1 - share) * math.log(seconds) + share * math.log(quick))
        found = best if math.isnan(found) else min(found, best)
    return found


def fastest(methods: Iterable[Sequence[tuple[float, float]]], level: float) -> float:
    """Return the shortest time [s] in which one of several methods reaches an error; nan if none does."""
    times = [time for time in (time_at_error(points, level) for points in methods) if not math.isnan(time)]
    return min(times, default=math.nan)
