r"""The friction law that measured torques follow, by least squares (:mod:`lsvib.sheets.torque.measured`).

*What the data tell apart* is read off the Jacobian of the torques by all unknown numbers, each in its natural size,
over the scatter of the residuals. Its singular values are the inverse standard errors of combinations of the numbers.
With one load T_b acts as the constant of friction, and b as its slope, so that only the sums are determined; then two
ends are fitted, all of a sum in the threads, and as much as can be in the bearing. A law that is cut off at zero has a
kink, which no drag of a bearing has, and the two would seem to be told apart. So none is cut off: up to the highest
measured speed a slope takes at most nine tenths of the constant, far more than measured laws fall by.

*At rest* both hold up to s T = s T₀ + T_s − s r_m W ξ_±(μ_s), in which μ_s and T_s do the same again. One load in both
directions leaves their sum; two loads tell them, or else the excess over sliding is in the threads at one end and in
the bearing at the other.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lsvib.drives.mechanics import holding_coefficient
from lsvib.errors import InputError
from lsvib.sheets.torque.measured import (
    BREAKAWAY,
    LOSS,
    OF_RISE,
    PARAMETERS,
    Measured,
    Solution,
    load_of_directions,
)
from lsvib.sheets.torque.starts import Array, Number

PAIRS = (("friction_coefficient", "coulomb"), ("friction_slope", "viscous"))  # of the threads, and of the bearing
DETERMINED = 0.1  # of the typical torque: largest standard error of what counts as determined
LARGEST_STATIC = 3.0  # coefficient, as in a data sheet
ROUNDS = 3  # of the robust fit, each with the scatter that the last one left
SURE = 10.0  # of Schwarz's criterion: a law that is worse by more is ruled out by the points (odds of 150 to 1)
AT_ZERO = 1e-9  # in natural sizes: a number that the search left so close to its bound is zero
SLOWEST, WEAKEST = 1e-9, 1e-12  # rad/s, N m: below it no screw is measured
FALL = 0.9  # of the constant of friction, by which a slope may lower it at most up to the highest measured speed


@dataclass(frozen=True)
class Fit:
    """What measured torques say: ``ends`` by name, ``threads`` and ``bearing``, or one, ``fit``, if all is determined.

    ``not_separable``: pairs of numbers of which only the sum of their torques is known. ``singular_values`` of the
    scaled Jacobian by the ``unknown`` numbers. ``rise_seen``: whether friction rises towards slow sliding. ``rival``:
    the law with the other exponent, where the points do not tell which of both it is.
    """

    measured: Measured
    ends: dict[str, Solution]
    not_separable: tuple[tuple[str, str], ...]
    unknown: tuple[str, ...]
    singular_values: Array
    rise_seen: bool
    rival: Solution | None = None

    @property
    def main(self) -> Solution:
        """The first end, all that the bearing may have being in the threads."""
        return next(iter(self.ends.values()))


def fitted(measured: Measured, given: Mapping[str, float] | None = None) -> Fit:
    """Fit the friction law of the threads and the drag of the bearing by least squares with a robust loss.

    ``given``: numbers that are known, by names of :data:`PARAMETERS` or ``stribeck_exponent`` (1 or 2; else the one
    that fits better). A rise is fitted if it is worth its two numbers by Schwarz's criterion. The zero of the torque is
    fitted where both directions were measured, else it is taken to be right. Raises ``InputError``.
    """
    if not measured.speed.size:
        raise InputError("the measurements have no point at which the screw turns.")
    known = dict(given or {})
    alike = np.unique(measured.load).size < 2 and "offset" not in known
    if measured.directions == 1:
        known.setdefault("offset", 0.0)
    if known.get("stribeck_rise") == 0:
        known["stribeck_speed"] = measured.sizes["stribeck_speed"]
    _enough(measured, known)
    exponents = [known.pop("stribeck_exponent")] if "stribeck_exponent" in known else [1.0, 2.0]
    flat = {"stribeck_rise": 0.0, "stribeck_speed": measured.sizes["stribeck_speed"]}
    laws = [{**known, "stribeck_exponent": exponent} for exponent in exponents]
    if not known.keys() & set(OF_RISE):
        laws.append({**known, **flat, "stribeck_exponent": exponents[0]})
    solved = [(law, _first_end(measured, law, alike)) for law in laws]
    # A rise whose error is as large as it is known by nothing: it fades below the slowest speed.
    seen = [one for one in solved if one[1][0].errors.get("stribeck_rise", 0.0) <= one[1][0].values["stribeck_rise"]]
    solved = seen or solved
    fixed, (first, singular, lost) = min(solved, key=lambda one: _schwarz(one[1][0]))
    rising = [one for law, (one, *_) in solved if one is not first and law.get("stribeck_rise") != 0]
    near = [one for one in rising if _schwarz(one) - _schwarz(first) < SURE and fixed.get("stribeck_rise") != 0]
    # Without a constant in the threads, a rise that hardly fades would be one; and what a slope falls by is theirs.
    least = {"friction_slope": 0.0, "friction_coefficient": 0.0}
    if PAIRS[1] not in lost:
        top = float(measured.sliding(measured.speeds[-1]))
        least["friction_coefficient"] = max(0.0, -first.values["friction_slope"] * top / FALL)
    fading = {**fixed, "stribeck_speed": first.values["stribeck_speed"], **{name: least[name] for name, _ in lost}}
    ends = {"bearing": _solved(measured, fading)} if lost else {}
    if lost and first.scatter > LOSS * ends["bearing"].scatter:  # so small a load makes no such torque in the threads
        first, ends, lost = ends["bearing"], {}, ()
    found = {name: _with_static(measured, ends.get(name, first), name) for name in ("threads", "bearing")}
    static = any(end.static for end in found.values())
    apart = _apart(measured, first) if static and not lost else {}
    if static and (lost or apart is None):
        lost = (*lost, BREAKAWAY)
    if not lost:
        found = {"fit": replace(found["threads"], static=apart or {})}
    _same_sign(measured, found)
    unknown = tuple(name for name in PARAMETERS if name not in fixed)
    return Fit(measured, found, lost, unknown, singular, bool(fixed.get("stribeck_rise", 1.0)), next(iter(near), None))


def law_of_curve(speeds: Array, coefficients: Array) -> dict[str, float]:
    """Fit the friction law to coefficients over sliding speeds [m/s], above zero; its parameters in six digits.

    Of four speeds the law has a rise or a slope, what fits better. Raises ``InputError`` for fewer.
    """
    # The torque of a screw of 1 m without lead under 1 N is the coefficient.
    measured = Measured(speeds, coefficients, np.ones(speeds.size), pitch_radius=1.0, lead_angle=1e-15)
    count, drag = measured.speeds.size, dict.fromkeys(("coulomb", "viscous", "offset"), 0.0)
    if count < 4:
        raise InputError(
            "friction.curve needs points at four sliding speeds or more, each 5 % above the last; of fewer give "
            "friction.coefficient and friction.slope."
        )
    without = ("stribeck_rise", "friction_slope") if count == 4 else ("offset",)
    found = min((fitted(measured, {**drag, name: 0.0}).main for name in without), key=lambda found: found.rms).values
    law = {name: float(f"{round(found[name], 9):.6g}") for name in ("friction_coefficient", *OF_RISE, "friction_slope")}
    return law | {"stribeck_exponent": int(found["stribeck_exponent"])}


def _enough(measured: Measured, known: Mapping[str, float]) -> None:
    """Refuse fewer speeds than the law has unknown numbers, and fewer points than there are in all."""
    if (slowest := float(np.abs(measured.speed).min())) < SLOWEST:
        raise InputError(f"the measurements have a speed of {slowest:.3g} rad/s; at least {SLOWEST:g} rad/s is needed.")
    if (typical := float(np.median(np.abs(measured.torque)))) < WEAKEST:
        raise InputError(
            f"half of the measured torques are not above {typical:.3g} N m, and at least {WEAKEST:g} N m is needed; "
            "check column, unit and factor of measurements.torque."
        )
    top, most = float(measured.sliding(measured.speeds[-1])), 0.5 / math.tan(measured.lead_angle)
    if known.get("friction_slope", 0.0) * top < -FALL * known.get("friction_coefficient", most):
        raise InputError(
            "friction.slope lets friction fall below a tenth of its coefficient up to the highest measured sliding "
            f"speed; the allowed range is friction.slope >= -{FALL:g} friction.coefficient / ({top:.3g} m/s)."
        )
    unknown = [name for name in PARAMETERS if name not in known]
    if not unknown:
        raise InputError("nothing is left to fit; give less of friction, bearing and offset.")
    over_speed = {next((a for a, b in PAIRS if name == b), name) for name in unknown} - {"offset"}
    speeds = measured.speeds.size
    if speeds < len(over_speed):
        raise InputError(
            f"the measurements have {speeds} speed{'s' * (speeds > 1)} for the {len(over_speed)} unknown numbers of "
            "the friction law over the speed; measure at more speeds, or give some of friction.stribeck_rise (0 for "
            "none), friction.slope and bearing.viscous."
        )
    if measured.speed.size <= len(unknown):
        raise InputError(f"the measurements have {measured.speed.size} points for {len(unknown)} unknown numbers.")


def _solved(measured: Measured, fixed: Mapping[str, float]) -> Solution:
    """Fit the numbers that are not fixed: first with squares, then with outliers weighed down."""
    try:
        from scipy.optimize import least_squares  # type: ignore[import-untyped]
    except ModuleNotFoundError:
        raise InputError("A fit needs scipy, which is not installed: pip install 'lsvib[assess]'.") from None

    sizes, speeds = measured.sizes, measured.sliding(measured.speeds)
    free = tuple(name for name in PARAMETERS if name not in fixed)
    scale, (low, high) = np.array([sizes[name] for name in free]), _bounds(measured, fixed, free)
    size, above = sizes["coulomb"], np.eye(len(free))
    if {"friction_coefficient", "friction_slope"} <= set(free):
        # In place of the slope the search has what it is above the steepest fall, which the constant decides.
        above[free.index("friction_slope"), free.index("friction_coefficient")] = -FALL
    numbers = scale[:, None] * above

    def misfit(x: Array) -> Array:
        """Residuals in units of ``size``."""
        values = {**fixed, **dict(zip(free, numbers @ x, strict=True))}
        return (measured.torque - measured.model(values)) / size

    def run(start: Array, **loss: Any) -> Any:
        return least_squares(misfit, start, bounds=(low, high), **loss)

    half = {"friction_coefficient": 0.5, "stribeck_rise": 0.1, "coulomb": 0.5}
    starts = []
    for at in np.geomspace(speeds[0], speeds[-1], 7)[1:-1:2] if "stribeck_speed" in free else (0.0,):
        guess = {**half, "stribeck_speed": at / sizes["stribeck_speed"]}
        starts.append(np.clip(np.linalg.solve(above, [guess.get(name, 0.0) for name in free]), low, high))
    found = min((run(start) for start in starts), key=lambda found: found.cost)
    for _ in range(ROUNDS):
        spread = max(1.4826 * float(np.median(np.abs(found.fun))), 1e-12)
        found = run(found.x, loss="soft_l1", f_scale=LOSS * spread)
    inverse = np.linalg.pinv(found.jac)  # weighed, so that the Jacobian's square is the curvature of the loss
    covariance = numbers @ (inverse @ inverse.T) @ numbers.T
    moved = numbers @ (inverse @ np.broadcast_to(measured.unsure / size * measured.rate, measured.speed.shape))
    settled = numbers @ np.where(np.abs(found.x) < AT_ZERO, 0.0, found.x)
    values = {**fixed, **dict(zip(free, settled.tolist(), strict=True))}
    alone = Solution(values, free, covariance, found.fun * size)
    return replace(alone, covariance=covariance * (alone.scatter / size) ** 2 + np.outer(moved, moved))


def _bounds(measured: Measured, fixed: Mapping[str, float], free: Sequence[str]) -> tuple[Array, Array]:
    """Return the least and the largest free numbers in natural sizes; of a slope beside a constant, above its least."""
    steepest = -FALL / float(measured.sliding(measured.speeds[-1]))
    low, high = dict.fromkeys(free, 0.0), dict.fromkeys(free, math.inf)
    low["offset"] = -math.inf
    low["stribeck_speed"], high["stribeck_speed"] = measured.fading
    # The sum of both is below cot λ, where lifting jams.
    high["friction_coefficient"] = high["stribeck_rise"] = 0.5 / math.tan(measured.lead_angle)
    if "friction_slope" in fixed:
        low["friction_coefficient"] = max(0.0, fixed["friction_slope"] / steepest)
    if "friction_coefficient" in fixed:
        low["friction_slope"] = steepest * fixed["friction_coefficient"]
    sizes = measured.sizes
    least, largest = (np.array([ends[name] / sizes[name] for name in free]) for ends in (low, high))
    return least, largest


def _first_end(
    measured: Measured, law: Mapping[str, float], alike: bool
) -> tuple[Solution, Array, tuple[tuple[str, str], ...]]:
    """Fit a law, all that the bearing may share being in the threads; with what :func:`_undetermined` returns."""
    whole = _solved(measured, law)
    singular, lost = _undetermined(measured, whole, alike)
    return _solved(measured, {**law, **{bearing: 0.0 for _, bearing in lost}}) if lost else whole, singular, lost


def _schwarz(solution: Solution) -> float:
    """Schwarz's criterion: what a model must fit better for each more of its numbers."""
    n, numbers = solution.residual.size, len(solution.free)
    mean_square = solution.scatter**2 * max(n - numbers, 1) / n
    return float(n * np.log(mean_square + np.finfo(float).tiny) + numbers * np.log(n))


def _undetermined(measured: Measured, at: Solution, alike: bool) -> tuple[Array, tuple[tuple[str, str], ...]]:
    """Return the singular values of the scaled Jacobian, and the pairs of which only the sum is determined.

    ``alike``: whether one load, and a zero of the torque that nobody gave, leave nothing else of both pairs: what
    then tells them is of second order in friction, so that a fit far from the truth takes it for more than it is.
    """
    free, sizes = at.free, measured.sizes
    columns = []
    for name in free:
        step = 1e-4 * sizes[name]
        ends = [{**at.values, name: at.values[name] + s * step} for s in (1, -1)]
        up, down = (measured.model(end) for end in ends)
        columns.append((up - down) / 2e-4)
    noise = max(at.scatter, 1e-9 * sizes["coulomb"])
    _, singular, rows = np.linalg.svd(np.array(columns).T / noise, full_matrices=False)
    lost: list[tuple[str, str]] = []
    for pair in PAIRS:
        if set(pair) <= set(free):
            split = np.zeros(len(free))
            split[[free.index(name) for name in pair]] = 1, -1
            error = np.linalg.norm((rows @ split / 2) / np.maximum(singular, 1e-150))  # whose square is a double
            if alike or error > DETERMINED or lost:  # how steep a slope may fall rests on the constant
                lost.append(pair)
    return singular, tuple(lost)


def _held(measured: Measured, solution: Solution) -> tuple[Array, ...]:
    """Return torque [N m] in its direction, that, load and coefficient of breakaways that threads explain.

    The coefficient is that with a bearing that holds what it has in sliding.
    """
    sense, torque, load = measured.breakaway.T
    held, tangent = sense * (torque - solution.values["offset"]), math.tan(measured.lead_angle)
    force, relieved, law = measured.pressed(sense, load)
    borne = (held - solution.values["coulomb"]) / measured.pitch_radius
    every = np.asarray(holding_coefficient(borne, force, relieved, tangent, law))
    sure = (every >= 0) & (every <= min(LARGEST_STATIC, 0.99 / tangent))
    return held[sure], sense[sure], load[sure], every[sure]


def _with_static(measured: Measured, solution: Solution, end: str) -> Solution:
    """Add static friction, the median of what breakaway torques make, where it is above that of slow sliding.

    All that is above is in the ``bearing`` at its end, else in the threads.
    """
    (held, sense, load, every), bearing = _held(measured, solution), end == "bearing"
    absurd = len(measured.breakaway) - held.size
    if not held.size:
        return replace(solution, absurd=absurd)
    slow, coulomb = _sliding(solution)
    found = held - measured.threads(slow, sense, load) if bearing else every
    middle = float(np.median(found))
    # Of normally distributed values: of the median, by the median deviation from it. One torque has no scatter.
    error = 1.2533 * 1.4826 * float(np.median(np.abs(found - middle))) / math.sqrt(found.size)
    # The torques may all be off by a part; the coefficient is nearly in proportion to them.
    error = math.hypot(measured.loose * float(np.median(held) if bearing else middle), error)
    known = (middle, error if error or found.size > 1 else math.nan)
    above = middle > (coulomb if bearing else slow)
    return replace(solution, static={BREAKAWAY[bearing]: known} if above else {}, absurd=absurd)


def _sliding(solution: Solution) -> tuple[float, float]:
    """Friction of slow sliding: the coefficient of the threads, and the torque of the bearing [N m]."""
    return solution.values["friction_coefficient"] + solution.values["stribeck_rise"], solution.values["coulomb"]


def _apart(measured: Measured, solution: Solution) -> dict[str, Number] | None:
    """Return static friction of threads and bearing by least squares; None where only the sum is determined.

    Torques are as far off, relative, as they scatter, or by their stated error if that is more, and by that of their
    zero.
    """
    (held, sense, load, every), least = _held(measured, solution), _sliding(solution)
    if held.size < 2:
        return None
    at = np.array([float(np.median(every)), least[1]])
    for _ in range(2 * ROUNDS):  # of Newton's method; a torque is nearly linear in the coefficient
        step = 1e-4 * at[0]
        less, now, more = (measured.threads(at[0] + k * step, sense, load) for k in (-1, 0, 1))
        columns = np.column_stack([(more - less) / (2 * step), np.ones(held.size)]) / held[:, None]
        off = (held - now - at[1]) / held
        inverse = np.linalg.pinv(columns, rcond=1e-9)
        at = at + inverse @ off
    scatter = math.sqrt(float(off @ off) / (off.size - 2)) if off.size > 2 else 0.0
    noise = max(scatter, measured.loose)
    zero = inverse @ (sense / held) * solution.errors.get("offset", 0.0)
    error = np.sqrt((inverse**2).sum(axis=1) * noise**2 + zero**2)
    told = np.linalg.matrix_rank(columns, tol=1e-9 * columns[:, 0].max()) == 2 and noise > 0
    if not told or error[1] > DETERMINED * measured.sizes["coulomb"]:
        return None
    if (at < least).any():  # all that is above sliding is in the other one
        return _with_static(measured, solution, "bearing" if at[0] < least[0] else "threads").static
    return {name: (float(x), float(dx)) for name, x, dx in zip(BREAKAWAY, at, error, strict=True)}


def _same_sign(measured: Measured, ends: Mapping[str, Solution]) -> None:
    """Refuse a load whose sign is not that of the direction in which the screw turns harder."""
    for solution in ends.values():
        more = load_of_directions(measured, solution)
        if more is None or np.sign(measured.load + more).sum() * np.sign(measured.load).sum() >= 0:
            return
    raise InputError(
        "the screw turns harder in the direction in which the given load would help; change the sign of the load or of "
        "measurements.speed.factor and measurements.torque.factor."
    )
