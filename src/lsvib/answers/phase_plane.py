"""Phase planes as pieces of a dataset: sampled motions with their events, limit cycles, the lines N = 0 and θ′ = 0.

Functions return variables ``{name: (dimensions, values, attributes)}`` for ``xarray.Dataset``. A phase plane is one
``case`` (a drive) with several ``start`` states. Attractors are found under each ``rule`` of resuming after a seizure;
motions are sampled under the first.
"""

from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from lsvib.answers import attributes as cf
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.model import model_of
from lsvib.drives.names import CLOCK, RULES, Event, MotionMode, Resume
from lsvib.errors import InputError
from lsvib.systems.exact.arithmetic import many_digits

if TYPE_CHECKING:
    from lsvib.dynamics.impulses import Impulses
    from lsvib.systems.attractor import SteadyState
    from lsvib.systems.motion import Motion
else:  # names for annotations: this module loads no engine before a motion is asked for
    Impulses = Motion = SteadyState = Any

WithAttributes = dict[str, tuple[np.ndarray, dict[str, Any]]]  # values and attributes by the name of a variable
ATTRACTOR = "attractor that the motion reaches"
PERIOD = "period of the steady vibration"
AMPLITUDE = "amplitude of the steady vibration, half its peak-to-peak"
GLOBAL_STABILITY = "axial force beyond which steady sliding is globally stable"
RULE = cf.named_index("rule", "resume rule after a seizure", RULES)


def grid_axes(angle: np.ndarray, velocity: np.ndarray) -> cf.Variables:
    """Return the axes of a grid of states: u [rad] and u′ [rad/s]."""
    u, w, words = "grid_u", "grid_w", "deviation on the grid"
    rate = cf.variable(w, velocity, "rad s-1", f"rate of the {words}", r"$\dot u$")
    return {u: cf.variable(u, angle, "rad", words, "$u$"), w: rate}


def curve(name: str, dims: cf.Dims, points: np.ndarray, where: str, **more: str) -> cf.Variables:
    """Return points of the phase plane (..., 2), u [rad] and u′ [rad/s], as two variables; ``where`` they lie."""
    rate = f"rate of the deviation {where}"
    return {
        f"{name}_u": cf.variable(dims, points[..., 0], "rad", f"deviation {where}", "$u$", **more),
        f"{name}_w": cf.variable(dims, points[..., 1], "rad s-1", rate, r"$\dot u$", **more),
    }


def cycle_curves(dims: Sequence[str], cycles: Sequence[SteadyState], count: int, prefix: str = "cycle") -> cf.Variables:
    """Return cycles as curves in the phase plane, dimensions (*dims, sample), NaN where there is none.

    Time [s] from a point of the cycle, angle and velocity, what else the state has, and the contact force; both states
    of each event are among the samples.
    """
    orbit = next((steady.orbit for steady in cycles if steady.orbit is not None), None)
    names = (*(orbit.automaton.states[2:] if orbit else ()), "normal_force")
    table = np.full((len(cycles), 3 + len(names), count), np.nan)
    for rows, steady in zip(table, cycles, strict=True):
        if steady.orbit is not None:
            rows[0], states, modes = sample(steady.orbit, count)
            rows[1:] = *states.T, steady.orbit.automaton.observe("normal_force", states, modes)
    (time, u, w, *others), dims = np.moveaxis(table, 1, 0) if dims else table[0], (*dims, f"{prefix}_sample")
    return {
        f"{prefix}_time": cf.variable(dims, time, "s", "time along the cycle", "$t$"),
        **curve(prefix, dims, np.stack([u, w], axis=-1), "on the limit cycle"),
        **{f"{prefix}_{name}": (dims, x, cf.quantity(name)) for name, x in zip(names, others, strict=True)},
    }


def orbits(motions: Sequence[Motion]) -> cf.Variables:
    """Return limit cycles, a period of each, over ``cycle`` and ``sample``."""
    # So many points that no picture shows corners, and two at least for each arc.
    count = max([400, *(2 * (motion.time.size + 1) for motion in motions)])
    points = np.array([sample(motion, count)[1][:, :2] for motion in motions])
    return curve("cycle", ("cycle", "sample"), points, "on the limit cycle")


def reached(drive: Drive, start: Mapping[str, float], resume: Resume = RULES[0]) -> SteadyState:
    """Return what the motion from u [rad] and w [rad/s], else as in steady sliding, ends in by a resume rule."""
    from lsvib.systems.attractor import steady_state

    return steady_state(automaton_of(drive, resume), model_of(drive).initial_state(drive, start))


def followed(drive: Drive, start: Mapping[str, float], duration: float, resume: Resume = RULES[0]) -> Motion:
    """Return the motion from the same start over a ``duration`` [s]."""
    from lsvib.systems.motion import follow

    return follow(automaton_of(drive, resume), model_of(drive).initial_state(drive, start), duration)


def attractors(dims: cf.Dims, labels: Any, words: str = ATTRACTOR, **more: Any) -> cf.Variable:
    """Return labels of attractors as a variable, int8 with flags."""
    from lsvib.systems.attractor import Attractor

    return cf.flagged(dims, labels, words, Attractor, **more)


def portraits(
    settings: Mapping[str, Any], drives: Sequence[Drive], varied: tuple[str, ...] = (), printed: tuple[str, ...] = ()
) -> xr.Dataset:
    """Compute a phase plane for each drive, a case.

    ``settings``: ``starts``, each with u [rad] and w = u′ [rad/s]; ``duration`` [s] and number of ``samples`` of a
    motion. ``varied``: parameters in which the drives differ; ``printed``: places of the chapter beyond Table 8.1 that
    state parameters. Returns the :func:`lines`, the sampled motions (case, start, sample) with their events (case,
    start, event), what they settle on (case, rule, start), and the limit cycle of the first one (case, cycle_sample).
    Raises ``InputError`` if the samples are too few for the events.
    """
    from lsvib.dynamics.impulses import event_impulses

    starts, duration, samples = (settings[name] for name in ("starts", "duration", "samples"))
    steady = [[[reached(drive, start, rule) for start in starts] for rule in RULES] for drive in drives]
    motions = [[followed(drive, start, duration) for start in starts] for drive in drives]
    happens = [
        [events(motion, Event, event_impulses(drive, motion)) for motion in row]
        for drive, row in zip(drives, motions, strict=True)
    ]
    table = _stacked([[sampled(motion, samples, MotionMode) for motion in row] for row in motions], "sample")
    table["normal_force"][2]["comment"] = cf.WITHOUT_IMPULSES
    table |= _stacked(happens, "event")
    table["event_kind"][2].update(cf.flags(Event, none=True))
    return xr.Dataset(
        lines(drives) | table | _attractors(steady, samples),
        coords={**cf.drive_parameters(drives, along=varied, printed=printed), "rule": RULE},
    ).set_coords("time")


def lines(drives: Sequence[Drive]) -> cf.Variables:
    """Return, along ``case``, the line N = 0 as u = angle + slope · u′ (Q = 0, eq. 8.17), θ′ = 0 as u′ = −Ω, and Γ₊."""
    exact = [coefficients(drive) for drive in drives]
    with many_digits():
        angle, slope = ([float(-c.q_row[k] / c.q_row[0]) for c in exact] for k in (2, 1))
    stop, inertia = [-drive.input_speed for drive in drives], [float(c.gamma[1]) for c in exact]
    of_angle = "deviation at which the contact force vanishes, at zero rate"
    of_stop = "rate of the deviation at which the screw is at rest"
    return {
        "contact_line_angle": cf.variable("case", angle, "rad", of_angle, "$u$"),
        "contact_line_slope": cf.variable("case", slope, "s", "slope du/du' of the line of zero contact force"),
        "stop_velocity": cf.variable("case", stop, "rad s-1", of_stop, r"$-\Omega$"),
        "effective_inertia_plus": cf.variable("case", inertia, "kg m2", "effective inertia of law +", r"$\Gamma_+$"),
    }


def observed(
    motion: Motion, states: np.ndarray, rows: np.ndarray, modes: type[IntEnum], outputs: Iterable[str]
) -> WithAttributes:
    """Return states (k, n) of a motion in some rows of its modes (k), and what is observed there, by name."""
    names = (name for name in motion.automaton.states if name != CLOCK)
    found: WithAttributes = {name: (states[:, k], cf.quantity(name)) for k, name in enumerate(names)}
    codes = motion.automaton.codes[rows].astype(np.int8)
    found["mode"] = codes, cf.attributes("1", "mode of motion", **cf.flags(modes))
    return found | {name: (motion.automaton.observe(name, states, rows), cf.quantity(name)) for name in outputs}


def sampled(motion: Motion, count: int, modes: type[IntEnum]) -> WithAttributes:
    """Return a motion, its contact force and its deflection at the times of :func:`sample`, by name."""
    times, states, rows = sample(motion, count)
    seen = observed(motion, states, rows, modes, ("normal_force", "coupling_deflection"))
    return {"time": (times, cf.attributes("s", "time", "$t$"))} | seen


def events(motion: Motion, kinds: type[IntEnum], impulses: Impulses | None) -> WithAttributes:
    """Return the events of a motion, of some kinds, by name.

    ``impulses`` of a motion that may seize, from :func:`lsvib.dynamics.impulses.event_impulses`, or None.
    """
    found = {
        "event_time": (motion.time, cf.attributes("s", "time of the event")),
        "event_kind": (motion.kind, cf.attributes("1", "kind of the event", **cf.flags(kinds))),
        "event_sign": (motion.sign, cf.SIGNS),
    }
    for when, states in (("before", motion.before), ("after", motion.after)):
        for column, name in enumerate(name for name in motion.automaton.states if name != CLOCK):
            found[f"event_{name}_{when}"] = (states[:, column], cf.quantity(name, when))
    for name, known in () if impulses is None else cf.IMPULSES.items():
        found[f"event_{name}"] = (getattr(impulses, name.removesuffix("_impulse")), known)
    return found


def _stacked(found: Sequence[Sequence[WithAttributes]], dim: str) -> cf.Variables:
    """What is known of motions (case, start) along a dimension; those of few events end in NaN, kind −1 and sign 0."""
    table = cf.Variables()
    for name, (first, about) in found[0][0].items():
        rows = [[one[name][0] for one in row] for row in found]
        longest, empty = max(1, *(x.size for row in rows for x in row)), {"event_kind": -1, "event_sign": 0}
        rows = [[np.append(x, [empty.get(name, np.nan)] * (longest - x.size)) for x in row] for row in rows]
        table[name] = ("case", "start", dim), np.array(rows, dtype=first.dtype), about
    return table


def _attractors(steady: Sequence[Sequence[Sequence[SteadyState]]], samples: int) -> cf.Variables:
    """Return what motions settle on, (case, rule, start), and the limit cycle of the first one, (case, cycle_sample).

    That is of the first start by the first rule. Period and cycle are left out where no motion has one.
    """
    dims = ("case", "rule", "start")

    def table(name: str, dtype: type) -> np.ndarray:
        return np.array([[[getattr(s, name) for s in row] for row in case] for case in steady], dtype=dtype)

    found = {
        "attractor": attractors(dims, table("label", np.int8)),
        "amplitude": cf.variable(dims, table("amplitude", float), "rad", AMPLITUDE),
        "period": cf.variable(dims, table("period", float), "s", PERIOD, "$T$"),
        **cycle_curves(("case",), [case[0][0] for case in steady], samples),
    }
    return {name: own for name, own in found.items() if not np.isnan(own[1]).all()}


def sample(motion: Motion, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sample a motion at ``count`` times, each event twice: in the state before it and in the one after.

    Returns times [s] (count), states (count, n), indices of modes (count). Samples are shared out by duration, with a
    few for the shortest arc; ``InputError`` below two for each arc.
    """
    modes, starts, ends, durations = motion.arcs()
    least = min(17, count // durations.size)  # of an arc between two events
    if least < 2:
        raise InputError(f"samples = {count} is outside the allowed range samples >= {2 * durations.size}.")
    share = np.where(durations > 0, least, 2)
    spare = count - share.sum()
    total = durations.sum()
    share += np.floor(spare * (durations / total if total > 0 else 0 * durations)).astype(int)
    share[np.argmax(durations)] += count - share.sum()
    bounds = np.concatenate([[0.0], motion.time, [motion.end_time]])
    times = np.concatenate([np.linspace(a, b, n) for a, b, n in zip(bounds[:-1], bounds[1:], share, strict=True)])
    states, _ = motion.at(times)
    last = np.cumsum(share) - 1
    states[last - share + 1], states[last] = starts, ends
    return times, states, np.repeat(modes, share)
