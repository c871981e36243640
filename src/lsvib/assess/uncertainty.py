"""Probability of each mechanism over the uncertain entries of a sheet, by quasi-Monte Carlo; what causes the spread.

The samples are points of one scrambled Sobol sequence.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import binomtest, qmc, sobol_indices, uniform

from lsvib.assess.drive import (
    lifting_efficiency,
    lowering_efficiency,
    nominal_draw,
    quantities,
    random_entries,
    square_thread,
)
from lsvib.assess.mechanisms import Worst, worst
from lsvib.assess.sheet import Sheet
from lsvib.errors import InputError

BLOCK = 2**12  # samples at once: few enough for the processor's caches, many enough for NumPy
CONFIDENCE = 0.95  # of the intervals beside probabilities, the usual one
BINS = np.linspace(-1.0, 1.0, 41)
"""Edges of the classes of reserve that samples are counted in."""
_EDGE = 1e-9  # of the unit interval: keeps quantiles off the ends
_STARTS = 4  # of the search for the worst case
_MOST_BITS = 12  # of its corners: no more of them are looked at than a block has samples


@dataclass(frozen=True)
class Probability:
    """How often a mechanism occurs: ``value`` [1] and its confidence ``interval`` [1]; ``counts`` by reserve."""

    value: float
    interval: tuple[float, float]
    counts: NDArray[np.int64]


@dataclass(frozen=True)
class Uncertainty:
    """What the samples say: ``samples``, ``probability`` by mechanism, ``any`` of them, and the worst ``share``s.

    ``first_order`` and ``total``: Sobol indices [1] by mechanism and entry, absent where a reserve does not vary.
    ``lowest``: the shares (d) of the sample with the lowest reserve of each mechanism. ``holds``: how often the thread
    is self-locking (no ``counts``), and ``lifting`` the lowest and highest lifting efficiency [1] of the samples.
    """

    samples: int
    probability: dict[str, Probability]
    any: Probability
    first_order: dict[str, dict[str, float]]
    total: dict[str, dict[str, float]]
    lowest: dict[str, NDArray[np.float64]]
    holds: Probability
    lifting: tuple[float, float]


def draw_of(sheet: Sheet, shares: NDArray[np.float64]) -> dict[str, Any]:
    """Return the entries of a sheet for points (d, n) of the unit cube, one coordinate to an uncertain entry."""
    draw: dict[str, Any] = dict(nominal_draw(sheet))
    spreads = sheet.spreads
    for path, share in zip(random_entries(sheet), np.atleast_2d(shares), strict=True):
        draw[path] = spreads[path].quantile(np.clip(share, _EDGE, 1 - _EDGE))
    return draw


def evaluated(sheet: Sheet, shares: NDArray[np.float64]) -> dict[str, Worst]:
    """Return the lowest reserve of each mechanism over the window for points (d, n) of the unit cube.

    Raises ``InputError`` if the friction of one of them is so strong that the drive cannot move at all.
    """
    found = worst(sheet, quantities(sheet, draw_of(sheet, shares)))
    size = shares.shape[1]
    found = {
        name: Worst(np.broadcast_to(one.reserve, (size,)), np.broadcast_to(one.corner, (size,)))
        for name, one in found.items()
    }
    if any(np.isnan(one.reserve).any() for one in found.values()):
        raise InputError(
            "friction reaches values at which the threads jam whatever the torque, coefficient >= cot(lead angle); "
            "narrow friction or the lead of the thread."
        )
    return found


def study(sheet: Sheet, samples: int, seed: int) -> Uncertainty:
    """Sample the uncertain entries of a sheet; ``samples``: a power of two; ``seed``: of the scrambling.

    Raises ``InputError`` in one sentence.
    """
    entries = random_entries(sheet)
    if entries:
        total, sequence = samples, qmc.Sobol(len(entries), scramble=True, rng=seed)
        count = min(samples, BLOCK)
        results = [_block(sheet, sequence.random(count).T) for _ in range(samples // count)]
        first, whole = _indices(sheet, entries, count, seed)
    else:
        total, results, first, whole = 1, [_block(sheet, np.zeros((0, 1)))], {}, {}
    names = list(results[0]["lowest"])
    probability = {name: _probability(results, name, total, bool(entries)) for name in (*names, "any", "holds")}
    least, most = zip(*(result["lifting"] for result in results), strict=True)
    lowest = {name: min((result["lowest"][name] for result in results), key=lambda low: low[0])[1] for name in names}
    return Uncertainty(
        total, {name: probability[name] for name in names}, probability["any"], first, whole, lowest,
        probability["holds"], (min(least), max(most)),
    )  # fmt: skip


def _block(sheet: Sheet, shares: NDArray[np.float64]) -> dict[str, Any]:
    """What a block of samples says, points (d, n) of the unit cube.

    Counts of occurrence by mechanism, and of threads that are self-locking; counts in classes of reserve; the lowest
    reserve of each mechanism with its place; the ends of the lifting efficiency.
    """
    found = evaluated(sheet, shares)
    angle, coefficient = square_thread(sheet, quantities(sheet, draw_of(sheet, shares)))
    held = np.broadcast_to(lowering_efficiency(coefficient, angle) <= 0, shares.shape[1:])
    lifting = lifting_efficiency(coefficient, angle)
    occurs = {name: one.reserve < 0 for name, one in found.items()}
    anything = np.any([flags for name, flags in occurs.items() if name != "push_needed"], axis=0)
    return {
        "counts": {name: np.count_nonzero(f) for name, f in {**occurs, "any": anything, "holds": held}.items()},
        "classes": {name: np.histogram(np.clip(one.reserve, -1.0, 1.0), BINS)[0] for name, one in found.items()},
        "lowest": {name: (one.reserve.min(), shares[:, np.argmin(one.reserve)]) for name, one in found.items()},
        "lifting": (float(np.min(lifting)), float(np.max(lifting))),
    }


def _probability(results: list[dict[str, Any]], name: str, total: int, random: bool) -> Probability:
    """A share with the interval of Clopper and Pearson, as if the samples were independent.

    Points of a scrambled Sobol sequence scatter less than independent ones, so the interval is on the safe side. A
    sheet with nothing uncertain has a probability of exactly 0 or 1.
    """
    hits = sum(result["counts"][name] for result in results)
    classes = np.sum([result["classes"][name] for result in results], axis=0) if name in results[0]["classes"] else []
    share = hits / total
    if not random:
        return Probability(share, (share, share), np.asarray(classes))
    ends = binomtest(hits, total).proportion_ci(CONFIDENCE, "exact")
    return Probability(share, (float(ends.low), float(ends.high)), np.asarray(classes))


def _indices(sheet: Sheet, entries: Sequence[str], count: int, seed: int) -> tuple[dict, dict]:
    """Sobol indices of the reserve of each mechanism that varies, first order and total."""
    names = [n for n, one in evaluated(sheet, np.full((len(entries), 1), 0.5)).items() if n != "push_needed"]

    def reserve(shares: NDArray[np.float64]) -> NDArray[np.float64]:
        found = evaluated(sheet, shares)
        return np.stack([found[name].reserve for name in names])

    trial = reserve(qmc.Sobol(len(entries), scramble=True, rng=seed).random(64).T)
    varied = [k for k, row in enumerate(trial) if np.ptp(row) > 0]
    if not varied:
        return {}, {}
    if len(entries) == 1:  # which causes all of the spread; SciPy has no answer for a single entry
        alone = {names[k]: {entries[0]: 1.0} for k in varied}
        return alone, alone
    result = sobol_indices(func=lambda x: reserve(x)[varied], n=count, dists=[uniform()] * len(entries), rng=seed)

    def table(indices: NDArray[np.float64]) -> dict[str, dict[str, float]]:
        rows = np.reshape(indices, (len(varied), len(entries)))
        return {names[k]: dict(zip(entries, map(float, row), strict=True)) for k, row in zip(varied, rows, strict=True)}

    return table(result.first_order), table(result.total_order)


def first_shares(sheet: Sheet, lowest: Mapping[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    """Return where the search for the worst case of each mechanism begins: the ``lowest`` sample, or a lower corner.

    A mechanism may need several entries at their ends at once; where it does not occur its reserve may be flat, so that
    no step from a sample leads there. Corners at which the drive cannot move at all are left out.
    """
    size = len(random_entries(sheet))
    if size <= _MOST_BITS:
        corners = (np.arange(2**size) >> np.arange(size)[:, None]) % 2.0
    else:
        corners = np.round(qmc.Sobol(size, scramble=True, rng=size).random(2**_MOST_BITS).T)
    shares = np.concatenate([np.stack(list(lowest.values()), axis=1), corners], axis=1)
    found = worst(sheet, quantities(sheet, draw_of(sheet, shares)))
    rows = {name: np.broadcast_to(found[name].reserve, shares.shape[1:]) for name in lowest}
    return {name: shares[:, np.argmin(np.where(np.isnan(row), np.inf, row))] for name, row in rows.items()}


def worst_shares(sheet: Sheet, name: str, start: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the place (d) of the unit cube where the reserve of a mechanism is lowest, by search from a sample.

    Each entry is first tried at both of its ends, then all are moved together by the method of Nelder and Mead.
    """
    best = np.array(start, dtype=float)
    if not best.size:
        return best

    def reserve(shares: NDArray[np.float64]) -> float:
        return float(evaluated(sheet, np.clip(shares, 0.0, 1.0)[:, None])[name].reserve[0])

    for _ in range(_STARTS):
        before = best.copy()
        for k in range(best.size):
            rows = [np.concatenate([best[:k], [end], best[k + 1 :]]) for end in (best[k], 0.0, 1.0)]
            best = min(rows, key=reserve)
        if np.array_equal(before, best):
            break
    found = minimize(reserve, best, method="Nelder-Mead", bounds=[(0.0, 1.0)] * best.size, options={"maxfev": 400})
    return found.x if found.fun < reserve(best) else best
