"""A measured screw: its torque over the speed, the friction law that fits it, and how fast it must turn not to jerk."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.datasets import spans
from lsvib.datasets.attributes import VARIED, axis, parameter, variable
from lsvib.datasets.checks import Check
from lsvib.errors import InputError
from lsvib.figures import settings as of
from lsvib.figures import style
from lsvib.figures.common import BALANCE, about, balance_check
from lsvib.figures.settings import FigureSettings, PositiveSpan, Values
from lsvib.models.drive import Drive

CAPTION = """\
Drive 1 of Mablekos-Alexiou, da Cruz and Bergeles (IEEE Trans. Robotics 37:1252, 2021): a screw of 12 mm with a lead of
2 mm, 0.096 kg hanging from its carriage. (a) Torque of the motor over the speed, means of 500 samples and their
standard deviation, and the fitted law. Friction of threads and bearing are not separable with one load: drawn is the
end with all of it in the threads. (b) What both ends leave over, with the standard error of each mean. (c), (d) What
this law makes of a rigid drive with the published inertias; all drag is friction of the threads here, as only the sum
of the torques decides on stability. (c) Speed up to which vibration that has begun goes on, over the stiffness of the
drive, for three dampings c, the gain of a feedback of speed. Shaded: from 2 rpm, where the screw jerked between 0 and
12 rpm, to 10 rpm, where it turned evenly (10 ± 0.4 rpm). (d) Largest speed of the screw that jerks at 2 rpm. The
controller's gains are not published, which leaves k and c open. Of k the limit (c) says next to nothing. A c of some
10⁻⁴ N m s/rad would explain it; but with it only a spring so soft lets jerks reach 12 rpm that they come less often
than the 2.4 a second that were counted at least. So spring and damper alone do not explain all that was seen: the
controller may do more, the law below 10 rpm rests on the torque of a screw that jerked, and speeds are averages over
some time, so that quick jerks at 10 rpm would not be seen.
"""

TABLES = tuple(sorted((Path(__file__).parents[3] / "examples" / "measured_screw" / "drive1").glob("*.csv")))
RPM = math.pi / 30  # rad/s
LEAD, RADIUS = 2e-3, 5.5e-3  # m
LOAD = -0.096 * 9.80665  # N, travel at positive speed lowers it
JERKS, EVEN = 2 * RPM, 10 * RPM  # rad/s: speeds at which the screw was seen to jerk, and to turn evenly
SAMPLED = 51.2e-3  # s, from one sample of a table to the next
LARGEST_SEEN = 12 * RPM  # rad/s, at 2 rpm outward
PUBLISHED = {"pitch_radius": RADIUS, "lead_angle": math.atan(LEAD / (2 * math.pi * RADIUS)), "screw_inertia": 2.186e-6,
             "mass": 0.180 + 0.096, "axial_force": -LOAD}  # fmt: skip
SOURCE = "IEEE T-RO 37:1252, data of github.com/RViMLab/TRO2021-Dynamic-Modelling"
# Half-sums of both directions [mN m] by commanded speed [rpm], of the same tables apart from lsvib.
HALF_SUMS = {2: 3.1631, 10: 3.0892, 20: 3.0272, 40: 2.9133, 50: 2.9061, 100: 3.0328, 199: 3.5677}
PERTURBED = 5.0  # times the speed: from how far motions start
FASTEST = 100 * RPM  # rad/s; at twice the speed up to which the torque falls nothing vibrates


class Settings(FigureSettings):
    flows: ClassVar = ("taylor",)
    tables: ClassVar = TABLES

    stiffness: PositiveSpan = Field(description="Stiffnesses of the drive, evenly spaced in logarithm [N m/rad].")
    dampings: of.several(of.Damping, 1, 4, "Dampings of the screw by speed feedback [N m s/rad].")


def build(settings: Values) -> xr.Dataset:
    """Fit the friction law, and follow motions of the drive that it makes."""
    from lsvib.dynamics.energy import balance
    from lsvib.fit.dataset import fit_variables
    from lsvib.fit.law import Measured, fitted
    from lsvib.fit.tables import steady_point

    tables = _tables()
    points = sorted(map(steady_point, tables), key=lambda point: point.speed)
    speed, torque = (np.array([getattr(point, name) for point in points]) for name in ("speed", "torque"))
    fit = fitted(Measured(speed, torque, np.full(speed.size, LOAD), RADIUS, PUBLISHED["lead_angle"]))
    variables, coordinates, more = fit_variables(fit, points)
    drive = Drive(**PUBLISHED, **fit.main.drive(), support_damping=0.0)
    stiffness, dampings = spans.logarithmic(settings["stiffness"]), np.array(settings["dampings"])
    dims = ("support_damping", "direction", "coupling_stiffness")
    grid = [(c, sense, k) for c in dampings.tolist() for sense in (-1, 1) for k in stiffness.tolist()]
    shape = (dampings.size, 2, stiffness.size)
    found = np.array([_vibrates_up_to(drive, *place) for place in grid]).reshape(*shape, 2)
    jerks = np.array([_jerks(drive, *place) for place in grid]).reshape(*shape, 2)
    onset = np.array([[_damping_at(drive, sense * at) for sense in (-1, 1)] for at in (JERKS, EVEN)])
    jerking = drive.replace(support_damping=0.5 * onset.min(), input_speed=JERKS)
    variables |= {
        "vibrates_up_to": variable(
            dims, found[..., 0], "rad s-1", "speed up to which vibration that has begun goes on"
        ),
        "unresolved_motions": variable(dims, found[..., 1], "1", "number of motions that did not settle"),
        "largest_speed": variable(dims, jerks[..., 0], "rad s-1", "largest speed of the screw of a drive that jerks"),
        "jerk_frequency": variable(dims, jerks[..., 1], "s-1", "frequency of jerks"),
        "seen_jerk_frequency": variable((), _seen_frequency(tables), "s-1", "frequency of jerks that were seen"),
        "onset_damping": variable(
            ("seen_speed", "direction"), onset, "N m s rad-1", "damping below which steady sliding is unstable"
        ),
        "energy_balance": variable((), balance(jerking, _ends_on(jerking, JERKS).orbit), *BALANCE),
    }
    for name, value in drive:
        if name not in dims:
            variables[name] = ((), value, parameter(name, f"given: published or measured, {SOURCE}"))
    speeds = np.array([JERKS, EVEN])
    variables["input_speed"] = ("seen_speed", speeds, parameter("input_speed", VARIED))
    coordinates |= {
        **axis("support_damping", dampings),
        **axis("coupling_stiffness", stiffness),
        "seen_speed": variable(
            "seen_speed", speeds, "rad s-1", "speed at which the screw was seen to jerk, and to turn evenly"
        ),
    }
    words = about(__doc__, "least squares, and motions by power series", "eqs 8.4, 8.13")
    return xr.Dataset(variables, coordinates, {**words, **more, "data": SOURCE})


def _tables() -> list[Any]:
    from lsvib.fit.tables import read_table

    if not TABLES:
        raise InputError("The tables of figure measured_drive come with a checkout of lsvib only, in examples.")
    factors = (-RPM, -0.0984e-3)  # signs of the motor; per cent of 9.84 mN m
    return [read_table(file, (2, 3), factors, ";") for file in TABLES]


def _seen_frequency(tables: list[Any]) -> float:
    """How often in a second the speed rises beyond twice its mean in the outward table of jerks, at least."""
    (speed,) = (table.speed for table in tables if table.name == "2.csv")
    high = speed > 2 * speed.mean()
    return float(np.count_nonzero(high[1:] & ~high[:-1]) / (speed.size * SAMPLED))


def _ends_on(drive: Drive, speed: float) -> Any:
    """What a motion ends on that starts far from steady sliding at a speed [rad/s]."""
    from lsvib.dynamics.attractor import steady_state
    from lsvib.models.rigid import rigid_automaton

    moved = drive.replace(input_speed=speed)
    return steady_state(rigid_automaton(moved), [0.0, -PERTURBED * speed], max_events=20_000)


def _vibrates_up_to(drive: Drive, damping: float, sense: int, stiffness: float) -> tuple[float, int]:
    """The speed [rad/s] up to which motions end on a cycle, to 2 %, and how many of those tried do not settle.

    NaN if none does at half the speed at which the screw was seen to jerk.
    """
    from lsvib.dynamics.attractor import Attractor

    own = drive.replace(support_damping=damping, coupling_stiffness=stiffness)
    low, high, unresolved = 0.5 * JERKS, FASTEST, 0
    if not _ends_on(own, sense * low).label.name.endswith("CYCLE"):
        return math.nan, 0
    while high > 1.02 * low:
        middle = math.sqrt(low * high)
        label = _ends_on(own, sense * middle).label
        unresolved += label == Attractor.UNRESOLVED
        low, high = (middle, high) if label.name.endswith("CYCLE") else (low, middle)
    return low, unresolved


def _jerks(drive: Drive, damping: float, sense: int, stiffness: float) -> tuple[float, float]:
    """Largest speed [rad/s] and frequency [1/s] of the cycle at the speed of jerks; NaN if there is none."""
    from lsvib.dynamics.attractor import orbit_extremes

    own = drive.replace(support_damping=damping, coupling_stiffness=stiffness)
    end = _ends_on(own, sense * JERKS)
    if end.orbit is None or not end.label.name.endswith("CYCLE"):
        return math.nan, math.nan
    return JERKS + max(sense * x for x in orbit_extremes(end.orbit, np.array([0.0, 1.0, 0.0]))), 1 / end.period


def _damping_at(drive: Drive, speed: float) -> float:
    """The damping below which steady sliding at a speed [rad/s] is unstable [N m s/rad]."""
    from lsvib.stability.threshold import solve_threshold

    return solve_threshold(drive.replace(input_speed=speed), "onset", "support_damping").value


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the points against those computed apart, the law against the points, and both with what was seen."""
    half = dataset.half_sum * 1e3
    found = [
        Check.within(f"Half-sum of the torques of both directions at {rpm} rpm", "means of the tables, apart from ours",
                     value, float(half.values[np.argmin(np.abs(dataset.half_speed.values - rpm * RPM))]), 2e-5, "mN m",
                     "given with five digits")
        for rpm, value in HALF_SUMS.items()
    ]  # fmt: skip
    end = dataset.isel(end=0)
    rms, worst = float(end.residual_rms) * 1e3, float(np.abs(end.residual).max()) * 1e3
    lost = dataset.attrs["not_separable"]
    fitted = dataset.measured_torque.values - end.residual.values
    ratio = fitted / _by_angles(dataset, dataset.measured_speed.values)
    most = dataset.isel(support_damping=-1)
    slow = most.jerk_frequency.values[most.largest_speed.values >= LARGEST_SEEN]
    fall = float(np.abs(dataset.onset_damping.values / _falling(dataset) - 1).max())
    limits = dataset.vibrates_up_to
    undamped = limits.sel(support_damping=0.0).values
    (jerks, even), reach = dataset.onset_damping.values, dataset.largest_speed.sel(support_damping=0.0, direction=1)
    return [
        *found,
        Check.holds("The law leaves at most 0.045 mN m rms of the 32 means, and at most 0.12 mN m of each", "ours",
                    f"{rms:.4f} and {worst:.4f} mN m", rms <= 0.045 and worst <= 0.12),
        Check.exact("Fitted torque over that by tan(φ ± λ) in the place of ξ", "Sect. 5.3", 1.0, ratio),
        Check.holds("Friction of threads and bearing are not separable with one load", "ours", lost,
                    "coulomb" in lost and "viscous" in lost),
        Check.holds("Friction falls with the speed up to some 50 rpm", "means of the tables",
                    f"least at {float(dataset.half_speed[int(np.argmin(half.values))]) / RPM:.0f} rpm, rise "
                    f"{float(end.fitted_stribeck_rise):.3g} ± {float(end.fitted_stribeck_rise_error):.1g}",
                    float(end.fitted_stribeck_rise) > 4 * float(end.fitted_stribeck_rise_error)),
        Check.holds("Over all stiffnesses the speed up to which vibration goes on changes by less than a quarter",
                    "ours", f"{undamped.min() / RPM:.3g} to {undamped.max() / RPM:.3g} rpm",
                    np.ptp(undamped) < 0.25 * undamped.min()),
        Check.holds("Without speed feedback the screw would vibrate at 10 rpm, where it turned evenly", "ours",
                    f"up to {undamped.min() / RPM:.3g} rpm", undamped.min() > EVEN),
        Check.holds("The damping that makes steady sliding stable is the slope at which the torque falls", "eq. 8.13",
                    f"to {fall:.1e}", fall < 1e-6),
        Check.holds("Some speed feedback makes steady sliding stable at 10 rpm and leaves it unstable at 2 rpm", "ours",
                    f"{even.max():.3g} to {jerks.min():.3g} N m s/rad", even.max() < jerks.min()),
        Check.holds("Among the stiffnesses is one at which the jerks at 2 rpm reach the 12 rpm that were seen", "ours",
                    f"{float(reach.min()) / RPM:.3g} to {float(reach.max()) / RPM:.3g} rpm",
                    float(reach.min()) < LARGEST_SEEN < float(reach.max())),
        Check.holds("With feedback for which 10 rpm is even, jerks as large as those seen come less often",
                    "ours", f"{slow.max(initial=0.0):.2g} a second, {float(dataset.seen_jerk_frequency):.2g} seen",
                    slow.size > 0 and slow.max() < dataset.seen_jerk_frequency),
        balance_check("jerks at 2 rpm", dataset),
    ]  # fmt: skip


def _by_angles(dataset: xr.Dataset, speed: np.ndarray) -> np.ndarray:
    """The torque of the first end at speeds [rad/s] by the angle of friction, s r_m W tan(φ ± λ), and drag [N m]."""
    end, angle = {name: float(x[0]) for name, x in dataset.items() if x.dims == ("end",)}, PUBLISHED["lead_angle"]
    sliding = RADIUS * np.abs(speed) / math.cos(angle)
    exponent = json.loads(dataset.attrs["stribeck_exponents"])[0]
    rise = end["fitted_stribeck_rise"] * np.exp(-((sliding / end["fitted_stribeck_speed"]) ** exponent))
    mu = end["fitted_friction_coefficient"] + rise + end["fitted_friction_slope"] * sliding
    drag = end["fitted_coulomb"] * np.sign(speed) + end["fitted_viscous"] * speed + end["fitted_offset"]
    return drag + np.sign(speed) * RADIUS * abs(LOAD) * np.tan(np.arctan(mu) + np.sign(LOAD * speed) * angle)


def _falling(dataset: xr.Dataset) -> np.ndarray:
    """How much the torque falls with the speed at the speeds of :data:`onset_damping` [N m s/rad]."""
    speed = dataset.seen_speed.values[:, None] * dataset.direction.values
    step = 1e-4 * speed
    return -(_by_angles(dataset, speed + step) - _by_angles(dataset, speed - step)) / (2 * step)


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw torque and residuals, the speed up to which vibration goes on, and how fast the screw becomes."""
    figure = style.new_figure(style.DOUBLE, 5.2)
    (torque, residual), (limit, largest) = figure.subplots(2, 2)
    torque_panel(torque, dataset)
    residual_panel(residual, dataset)
    torque.set_title("(a) torque of the motor")
    residual.set_title("(b) measured less fitted")
    dampings = [f"$c$ = {style.number(c)} N m s rad⁻¹" for c in dataset.support_damping.values]
    for axes, name, title in ((limit, "vibrates_up_to", "(c) vibration goes on up to"),
                              (largest, "largest_speed", "(d) largest speed at 2 rpm")):  # fmt: skip
        _over_stiffness(axes, dataset[name])
        axes.set(title=title, xscale="log", yscale="log", ylabel="Speed of the screw [rpm]",
                 xlabel=style.label(dataset.coupling_stiffness, "stiffness of the drive"))  # fmt: skip
    limit.axhspan(JERKS / RPM, EVEN / RPM, color=style.GREY, alpha=0.25, linewidth=0)
    for rpm, words in ((EVEN / RPM, "turned evenly"), (JERKS / RPM, "jerked")):
        limit.text(0.97, rpm * 1.04, words, transform=limit.get_yaxis_transform(), ha="right", va="bottom", fontsize=7)
    first = float(dataset.coupling_stiffness[0])
    for limits, words in zip(dataset.vibrates_up_to, dampings, strict=True):
        limit.text(first, float(limits.max()) / RPM * 1.06, words, fontsize=7.5)
    limit.set_ylim(1.5, 100)
    largest.axhline(LARGEST_SEEN / RPM, **style.PRINTED)
    largest.text(0.97, 1.05 * LARGEST_SEEN / RPM, "seen: 12 rpm", transform=largest.get_yaxis_transform(), ha="right",
                 va="bottom", fontsize=7)  # fmt: skip
    for axes, ticks in ((limit, (2, 5, 10, 20, 50, 100)), (largest, (5, 10, 20, 50, 100))):
        axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.set_yticks([], minor=True)
    largest.legend(loc="upper right", title="colours and order as in (c)", title_fontsize=7, fontsize=7)
    return figure


def _over_stiffness(axes: style.Axes, found: xr.DataArray) -> None:
    """Draw a speed over the stiffness, for each damping and direction."""
    looks = {-1: ("-", "o", "vibration, lifting"), 1: ("--", "s", "vibration, lowering")}
    for row, colour in zip(found, (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE), strict=False):
        for line in row:
            dashes, mark, words = looks[int(line.direction)]
            axes.plot(found.coupling_stiffness, line / RPM, dashes, marker=mark, markersize=2.5, color=colour,
                      linewidth=0.9, label=words if colour == style.BLUE else None)  # fmt: skip


def torque_panel(axes: style.Axes, dataset: xr.Dataset) -> None:
    """Draw the magnitudes of torques over that of the speed, with their scatter, and the law of the first end."""
    laws = np.abs(dataset.law_torque.isel(end=0)) * 1e3
    for sign, colour, mark, words, own in _ways(dataset):
        points = dataset.isel(point=own)
        axes.errorbar(
            np.abs(points.measured_speed) / RPM, np.abs(points.measured_torque) * 1e3, points.torque_scatter * 1e3,
            fmt=mark, color=colour, markersize=3, elinewidth=0.5, label=f"measured, {words}",
        )  # fmt: skip
        label = f"fitted law, {words}"
        for law in laws:
            sense = sign * int(np.sign(law.load_case) or 1)
            if sense in dataset.direction:
                axes.plot(dataset.law_speed / RPM, law.sel(direction=sense), color=colour, linewidth=1, label=label)
                label = ""
    low, high = axes.get_ylim()
    axes.set(
        xlabel="Speed of the screw [rpm]", ylabel="Torque of the motor [mN m]", ylim=(low, high + 0.25 * (high - low))
    )
    axes.legend(fontsize=7, ncols=2, loc="upper left")


def residual_panel(axes: style.Axes, dataset: xr.Dataset) -> None:
    """Draw what the fit leaves over, by end, with the standard error of each mean, over the speed."""
    error = dataset.torque_scatter / np.sqrt(dataset.samples) * 1e3
    for _, colour, mark, words, own in _ways(dataset):
        speed = np.abs(dataset.measured_speed[own]) / RPM
        first, *others = dataset.residual[:, own] * 1e3
        axes.errorbar(speed, first, error[own], fmt=mark, color=colour, markersize=3, elinewidth=0.5, label=words)
        for end in others:
            axes.plot(speed, end, "x", color=colour, markersize=3, label=f"{words}, bearing end")
    axes.axhline(0, color=style.GREY, linewidth=0.6)
    axes.set(xlabel="Speed of the screw [rpm]", ylabel="Torque [mN m]")
    axes.legend(fontsize=7)


def _ways(dataset: xr.Dataset) -> Iterator[tuple[int, str, str, str, np.ndarray]]:
    """Lifting and lowering, as far as measured: sign of speed times load, colour, mark, words, indices of points."""
    for sign, colour, mark, words in ((1, style.VERMILION, "o", "lifting"), (-1, style.BLUE, "s", "lowering")):
        towards = xr.where(dataset.measured_load == 0, 1.0, dataset.measured_load)  # a preloaded nut may have no load
        own = np.flatnonzero(np.sign(dataset.measured_speed * towards) == sign)
        if own.size:
            yield sign, colour, mark, words, own
