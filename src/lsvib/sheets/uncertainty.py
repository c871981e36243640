"""Probability of each mechanism over the uncertain entries of a sheet, by quasi-Monte Carlo; what causes the spread.

The samples are points of one scrambled Sobol sequence.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.errors import InputError
from lsvib.sheets.draw import Draw
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.window import OperatingWindow, count_of, worst

MOST = 2**12  # of corners, and of drives for an index of Sobol
MOST_RESERVES = 2**20  # of Sobol indices, about a second
ASKED = 128  # drives whose basins are asked, some 5 ms a corner of the window,
ASKED_CORNERS = 512  # of all of them
Array = NDArray[np.float64]
# Lowest reserve [1] of a mechanism within the uncertainties, and the place (d) of the unit cube that has it.
WorstCase = tuple[float, Array]


@dataclass(frozen=True)
class Probability:
    """How often a mechanism occurs: ``value`` [1] and its confidence ``interval`` [1]; None where it is not known."""

    value: Any  # float
    interval: Any  # tuple of floats


@dataclass(frozen=True)
class Uncertainty:
    """What the samples say: their number, ``points`` (d, n) of the unit cube, ``probability`` by mechanism, ``any``.

    ``sobol``: total Sobol indices [1] by mechanism and entry, absent where a reserve does not vary.
    ``cases``: the worst case of each mechanism, none if nothing is uncertain; ``upset``: the shares (d) of the sample
    that tolerates the smallest perturbation, None if all that were asked tolerate any. ``holds``: how often the thread
    is self-locking, and ``lifting`` the lowest and highest lifting efficiency [1] of the samples.
    """

    samples: int
    points: Array
    probability: dict[str, Probability]
    any: Probability
    sobol: dict[str, dict[str, float]]
    cases: dict[str, WorstCase]
    upset: Array | None
    holds: Probability
    lifting: tuple[float, float]


def evaluated(sheet: Sheet, shares: Array) -> dict[str, Array]:
    """Return the lowest reserve (n) [1] of each mechanism over the window for points (d, n) of the unit cube.

    Raises ``InputError`` if the friction of one of them is so strong that the drive cannot move at all.
    """
    alone = not sheet.random  # then it is the drive at the middle values, with its own points of the window
    found = worst(Draw.of(sheet, shares), between=alone)
    reserves = {name: np.broadcast_to(one.reserve, shares.shape[1:]) for name, one in found.items()}
    if any(np.isnan(reserve).any() for reserve in reserves.values()):
        raise InputError(
            "the friction coefficient reaches cot(lead angle), where the threads jam at any torque; narrow the "
            "range of friction or of the lead of the thread."
        )
    return reserves


def study(sheet: Sheet, samples: int, seed: int) -> Uncertainty:
    """Sample the uncertain entries of a sheet; ``samples``: a power of two; ``seed``: of the scrambling.

    Raises ``InputError`` in one sentence.
    """
    from scipy.stats import qmc  # type: ignore[import-untyped]

    entries, points = sheet.random, np.zeros((0, 1))
    if entries:
        points = qmc.Sobol(len(entries), scramble=True, rng=seed).random(samples).T
    found = evaluated(sheet, points)
    varied = [name for name, reserve in found.items() if name != "after_perturbation" and np.ptp(reserve) > 0]
    pair = Draw.of(sheet, points).efficiencies
    lifting, lowering = (np.broadcast_to(one, points.shape[1:]) for one in pair)
    unstable = np.any([reserve < 0 for name, reserve in found.items() if name != "after_perturbation"], axis=0)
    chances = {name: _probability(reserve < 0) for name, reserve in found.items()}
    chances["after_perturbation"], upset = _perturbed(sheet, points, found["after_perturbation"])
    return Uncertainty(
        samples=points.shape[1],
        points=points,
        probability=chances,
        any=_probability(unstable),
        sobol=_indices(sheet, entries, varied, min(samples, MOST), seed) if varied else {},
        cases=_worst_cases(sheet, [points[:, np.argmin(reserve)] for reserve in found.values()]) if entries else {},
        upset=upset,
        holds=_probability(lowering <= 0),
        lifting=(float(lifting.min()), float(lifting.max())),
    )


def _probability(hits: NDArray[np.bool_]) -> Probability:
    """A share with the interval of Clopper and Pearson (docs/assess.md); 0 or 1 if nothing is uncertain."""
    count = int(np.count_nonzero(hits))
    share = count / hits.size
    interval = _ends(count, hits.size, 0.95) if hits.size > 1 else (share, share)
    return Probability(share, interval)


def _ends(hits: int, count: int, level: float = 0.975) -> tuple[float, float]:
    """The interval of Clopper and Pearson of a share."""
    from scipy.stats import binomtest

    ends = binomtest(hits, count).proportion_ci(level, "exact")
    return float(ends.low), float(ends.high)


def _perturbed(sheet: Sheet, points: Array, reserve: Array) -> tuple[Probability, Array | None]:
    """How often a perturbation starts vibration, and the shares of the drive that the smallest one upsets.

    By the basins of the first drives that may vibrate: those with a negative reserve. The interval is that of the
    share of these times that of the upset among them, each of 97.5 %; drives that are not known widen it.
    """
    if not sheet.closed:
        return Probability(None, None), None
    candidates = np.flatnonzero(reserve < 0)
    if not candidates.size:
        return _probability(reserve < 0), None
    most = min(ASKED, max(ASKED_CORNERS // count_of(Draw.of(sheet)), 16))
    answers = [(k, *OperatingWindow(Draw.of(sheet, points[:, k])).most_perturbed) for k in candidates[:most]]
    hits, asked = sum(answer is True for _, answer, *_ in answers), len(answers)
    unknown = sum(answer is None for _, answer, *_ in answers)
    value = candidates.size / reserve.size * hits / (asked - unknown) if unknown < asked else None
    first = points[:, min(answers, key=lambda answer: answer[2])[0]] if hits else None
    if reserve.size == 1:
        return Probability(value, None if value is None else (value, value)), first
    among, share = (_ends(hits, asked)[0], _ends(hits + unknown, asked)[1]), _ends(candidates.size, reserve.size)
    return Probability(value, (among[0] * share[0], among[1] * share[1])), first


def _indices(sheet: Sheet, entries: list[str], names: list[str], count: int, seed: int) -> dict[str, dict[str, float]]:
    """Total Sobol indices of the reserves of some mechanisms: shares of the spread that entries cause, with others.

    ``count``: how many drives each is taken from; it is fewer where the window has many points.
    """
    from scipy.stats import sobol_indices, uniform

    if len(entries) == 1:  # which causes all of the spread; SciPy has no answer for a single entry
        return {name: {entries[0]: 1.0} for name in names}
    points = count_of(Draw.of(sheet)) * (len(entries) + 2)
    while count * points > MOST_RESERVES and count > 64:
        count //= 2

    def reserve(shares: Array) -> Array:
        found = evaluated(sheet, shares)
        return np.stack([found[name] for name in names])

    result = sobol_indices(func=reserve, n=count, dists=[uniform()] * len(entries), rng=seed)
    rows = np.reshape(result.total_order, (len(names), -1)).tolist()
    return {name: dict(zip(entries, row, strict=True)) for name, row in zip(names, rows, strict=True)}


def ends(sheet: Sheet, most: int = MOST) -> Array:
    """Return the corners (d, n) of the unit cube of the uncertain entries, ``most`` of them, a power of two."""
    size = len(sheet.random)
    if 2**size <= most:
        return np.asarray((np.arange(2**size) >> np.arange(size)[:, None]) % 2, dtype=float)
    from scipy.stats import qmc

    return np.asarray(np.round(qmc.Sobol(size, scramble=True, rng=size).random(most).T))


def _worst_cases(sheet: Sheet, lowest: list[Array]) -> dict[str, WorstCase]:
    """The worst case of each mechanism within the uncertainties.

    It is the ``lowest`` sample or a lower corner of the unit cube: a mechanism may need several entries at their ends
    at once. Corners at which the drive cannot move at all are left out. A search from there on found a lower reserve
    for one in 100 worst cases of drives such as catalogues offer, and another sign for none.
    """
    shares = np.concatenate([np.stack(lowest, axis=1), ends(sheet)], axis=1)
    found = {}
    for name, one in worst(Draw.of(sheet, shares)).items():
        reserve = np.broadcast_to(one.reserve, shares.shape[1:])
        k = np.nanargmin(reserve)
        found[name] = float(reserve[k]), shares[:, k]
    return found
