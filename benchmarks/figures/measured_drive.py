"""A measured screw: the friction law of the steady files, and what the jerks in the others reveal about its drive."""

import json
import math
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import spans
from lsvib.answers.attributes import VARIED, named_index, parameter, variable, varied
from lsvib.chapter.checks import Check, Clause, each, every, near
from lsvib.chapter.common import about
from lsvib.chapter.settings import FigureSettings, PositiveSpan, Values
from lsvib.drives.drive import Drive
from lsvib.errors import InputError
from lsvib.pictures import style
from lsvib.pictures.torque import RPM, residual_panel, torque_panel
from lsvib.words import plain

CAPTION = """\
Drive 1 of Mablekos-Alexiou, da Cruz and Bergeles (IEEE Trans. Robotics 37:1252, 2021): a 12 mm screw with a lead of 2
mm and 0.096 kg hanging from its carriage. (a) Motor torque over speed: mean and standard deviation of the 500 samples
of each steady file, and the fitted law with all friction in the threads. (b) Two seconds of the files at 2 rpm, which
jerk, and the cycle of the model. (c) Speed above which the model runs steadily from rest, against the damping c of
command and bearing; the shaded dampings explain which files jerk and which are steady. (d) Residuals of the means, with
their standard errors.
Explained: the torque climbs as if through a spring of 0.0215 N m/rad. With as much friction in the bearing as possible,
2.37 mN m sliding and 3.17 static, and a damping of 1.23 × 10⁻⁴ N m s/rad, the model jerks as often as the screw in both
directions, to 1 %, with the same torque, to 0.03 mN m, and the same swing, to 3 %. Static friction and damping are
fitted to period and torque averaged over both directions; the breakaway torque gives 3.24 ± 0.07. With the excess over
sliding friction in the threads, the model would jerk every 0.37 s lowering and 0.44 s lifting. Recorded speeds up to 15
rpm are averages, over about 50 ms, of slips at more than 30. Not explained: with that damping, the dotted line in (c),
the model runs steadily above 32 rpm, while the screw was steady at 10, which takes at least 2.5 × 10⁻⁴ if it was
started from rest. Static friction that grows with the time at rest, 0.37 s at 2 rpm and less at 10, might explain both.
While the torque climbs, the motor turns at 1 rpm, half the commanded speed, so it winds up something compliant.
Jerks differ from tooth to tooth, and at 10 rpm the torque swings once per turn, by 7 % lifting and 14 % lowering:
friction depends on position.
"""

ENDS = ("threads", "bearing")  # where the fit puts friction at rest above that of sliding: in all, or in the bearing
FOLDER = Path(__file__).parents[2] / "examples" / "measured_screw" / "drive1"
TABLES = tuple(sorted(FOLDER.glob("*.csv")))
LEAD, RADIUS = 2e-3, 5.5e-3  # m
LOAD = -0.096 * 9.80665  # N, travel at positive speed lowers it
SLOW, EVEN = 2 * RPM, 10 * RPM  # rad/s: speeds at which the screw jerked, and from which on it turned evenly
SLOW_FILES, EVEN_FILES = {-1: "n2.csv", 1: "2.csv"}, {-1: "n10.csv", 1: "10.csv"}  # by the direction of turning
PUBLISHED = {"pitch_radius": RADIUS, "lead_angle": math.atan(LEAD / (2 * math.pi * RADIUS)), "screw_inertia": 2.186e-6,
             "mass": 0.180 + 0.096, "axial_force": -LOAD}  # fmt: skip
SOURCE = "IEEE T-RO 37:1252, data of github.com/RViMLab/TRO2021-Dynamic-Modelling"
# Half-sums of both directions [mN m] by commanded speed [rpm], of the same tables apart from lsvib.
HALF_SUMS = {10: 3.0892, 20: 3.0272, 40: 2.9133, 50: 2.9061, 100: 3.0328, 199: 3.5677}
SAMPLING = 0.128  # s, of these files
RECORD_TIMES, MODEL_TIMES = np.arange(16) * SAMPLING, np.linspace(0.0, 15 * SAMPLING, 600)  # that are drawn
TOP = 0.98  # quantile of the recorded speed that stands for its largest values
_SIGNED = (-RPM, -0.0984e-3)  # signs of the motor, rpm; per cent of 9.84 mN m
_ROWS = {  # of each direction: further dimensions, unit and words
    "jerk_period": ((), "s", "period of the jerks in the record"),
    "jerk_period_error": ((), "s", "standard error of the period"),
    "jerk_stiffness": ((), "N m rad-1", "stiffness from the ramps of the torque"),
    "averaging": ((), "s", "averaging time of the record, from its share of samples above 3 rpm"),
    "model_period": ((), "s", "period of the model, with the excess static friction in the bearing"),
    "threads_period": ((), "s", "period of a model with the excess static friction in the threads"),
    "largest_speed": ((), "rad s-1", "largest speed of the model"),
    "energy_balance": ((), "1", "sum of all work over one period of the cycle, relative to the largest term"),
    "standing_speed": ((), "rad s-1", "median of the recorded speed"),
    "turn_swing": ((), "1", "once-per-turn amplitude of the torque at 10 rpm, relative to its mean"),
    "swing": (("source",), "N m", "standard deviation of the torque about its slow change"),
    "recorded_top": (("source",), "rad s-1", "averaged speed below which 98 % of the samples lie"),
    "mean_torque": (("source",), "N m", "mean torque in the direction of turning"),
    "recorded_torque": (("record_time",), "N m", "recorded torque in the direction of turning"),
    "model_torque": (("model_time",), "N m", "torque of the model in the direction of turning, averaged"),
}
_FITTED = {"stribeck_rise": "stribeck_rise", "stribeck_speed": "stribeck_speed", "bearing_friction": "coulomb"}


class Settings(FigureSettings):
    engine: ClassVar = ("planar", "taylor")
    tables: ClassVar = TABLES

    dampings: PositiveSpan = Field(description="Dampings between command and screw [N m s/rad].")


def build(settings: Values) -> xr.Dataset:
    """Fit the law of the files that are even, and follow the drive that this law and the jerks make."""
    from lsvib.sheets.torque.dataset import fit_variables
    from lsvib.sheets.torque.law import fitted
    from lsvib.sheets.torque.measured import Measured
    from lsvib.sheets.torque.records import look
    from lsvib.sheets.torque.stick_slip import breaking, explained
    from lsvib.sheets.torque.tables import read_table, steady_point

    factors = (*_SIGNED, 1e-3)  # ms
    tables = {file.name: read_table(file, (2, 3, 1), factors, ";") for file in TABLES}
    records: dict[str, Any] = {name: look(table) for name, table in tables.items()}
    points = [steady_point(table) for name, table in tables.items() if records[name].kind == "even"]
    points.sort(key=lambda point: point.speed)
    speed, torque = (np.array([getattr(point, name) for point in points]) for name in ("speed", "torque"))
    jerks = {sense: (tables[name], records[name]) for sense, name in SLOW_FILES.items()}
    torn, loose = breaking((sense, LOAD, record) for sense, (_, record) in jerks.items())
    loads, under = (np.full(speed.size, LOAD), RADIUS, PUBLISHED["lead_angle"]), (LOAD, PUBLISHED["mass"])
    measured = Measured(speed, torque, *loads, np.array(torn), loose=loose)
    fit = fitted(measured)
    found = {(sense * SLOW, *under): record for sense, (_, record) in jerks.items()}
    even = [((one.speed, *under), 0.0) for one in points]
    threads, told = (explained(measured, fit.ends[end], found, even, PUBLISHED["screw_inertia"]) for end in ENDS)
    if not (threads and threads.periods and told and told.periods and told.damping and told.by_periods):
        raise InputError("The model of figure measured_drive has no cycle where the screw jerked.")
    law = fit.ends[ENDS[1]]
    viscous, offset = (law.values[name] for name in ("viscous", "offset"))
    begin = Drive(
        **PUBLISHED, **law.drive(), **law.bearing(), coupling_stiffness=told.stiffness[0],
        support_damping=told.by_periods + viscous,
    )  # fmt: skip
    drive, cycles = _explaining(begin, jerks, viscous, offset)
    rows = [
        _beside(cycles[sense], sense, *jerks[sense])
        | {"turn_swing": _once_a_turn(tables[EVEN_FILES[sense]]), "threads_period": period[1]}
        for sense, period in zip(jerks, threads.periods, strict=True)
    ]
    own = drive.support_damping
    dampings = np.unique([*spans.even(settings["dampings"]), own])
    limits = [_even_speeds(drive, sense, dampings) for sense in jerks]
    variables, coordinates, more = fit_variables(fit, points)
    variables |= {
        name: variable(("direction", *dims), [row[name] for row in rows], unit, words)
        for name, (dims, unit, words) in _ROWS.items()
    }
    over, from_it = ("direction", "support_damping"), "speed above which the model runs steadily from rest"
    both = "least and largest damping, the bearing's included, that explain which files jerk"
    variables |= {
        "even_speed": variable(over, limits, "rad s-1", from_it),
        "explaining_damping": variable("bound", np.array(told.damping) + viscous, "N m s rad-1", both),
        "jerking_damping": variable((), own, "N m s rad-1", "damping of the model that jerks as often as the screw"),
        "input_speed": ("direction", [sense * SLOW for sense in jerks], parameter("input_speed", VARIED)),
        **{
            name: ((), value, parameter(name, f"given: published, measured or fitted, {SOURCE}"))
            for name, value in drive
            if name not in ("input_speed", "support_damping")
        },
    }
    coordinates |= {
        **varied(support_damping=dampings),
        "record_time": variable("record_time", RECORD_TIMES, "s", "time of the record", "$t$"),
        "model_time": variable("model_time", MODEL_TIMES, "s", "time of the model", "$t$"),
        "source": named_index("source", "source of the number", ["record", "model"]),
        "bound": named_index("bound", "end of the interval that explains all files", ["least", "largest"]),
    }
    words = about(__doc__, "least squares, and motions by power series", "eqs 8.4, 8.13")
    return xr.Dataset(variables, coordinates, {**words, **more})


def _even_speeds(drive: Drive, sense: int, dampings: np.ndarray) -> np.ndarray:
    """Speeds [rad/s] from which on a drive runs evenly once started, to 1e-3, by its damping; infinite if from none."""
    from lsvib.drives.many import ManyDrives
    from lsvib.dynamics.sweep import all_endings
    from lsvib.systems.attractor import Attractor

    def evenly(speeds: np.ndarray) -> np.ndarray:
        """Whether it ends in steady sliding, by its damping."""
        drives = ManyDrives({**dict(drive), "support_damping": dampings, "input_speed": sense * speeds})
        found = all_endings(drives, None).attractor
        if Attractor.UNRESOLVED in found:
            raise InputError("measured_drive: it is not known of a motion from rest what it ends in.")
        return np.asarray(found == Attractor.STEADY_SLIDING)

    jerks, even = (np.full(dampings.size, factor * EVEN) for factor in (1e-2, 100.0))
    while (even > 1.001 * jerks).any():
        there = evenly(middle := np.sqrt(jerks * even))
        jerks, even = np.where(there, jerks, middle), np.where(there, middle, even)
    return np.where(evenly(even), even, np.inf)


def _explaining(
    drive: Drive, jerks: dict[int, tuple[Any, Any]], viscous: float, offset: float
) -> tuple[Drive, dict[int, "_Cycle"]]:
    """The drive whose damping and static friction of the bearing give period and torque of both records in the mean."""

    def changed(x: np.ndarray) -> Drive:
        return drive.replace(support_damping=float(x[0]) * 1e-4, bearing_static_friction=float(x[1]) * 1e-3)

    def cycles(own: Drive) -> dict[int, _Cycle]:
        """Those of both directions."""
        return {sense: _cycle(own.replace(input_speed=sense * SLOW), viscous, sense * offset) for sense in jerks}

    def off(x: np.ndarray) -> np.ndarray:
        """Of the periods, in logarithm, and of the torques [mN m]."""
        found = cycles(changed(x))
        periods = (math.log(found[sense].period / record.period[0]) for sense, (_, record) in jerks.items())
        torques = (_mean(found[sense]) - sense * table.torque.mean() for sense, (table, _) in jerks.items())
        return np.array([sum(periods), 1e3 * sum(torques)])

    x = np.array([drive.support_damping * 1e4, drive.bearing_static_friction * 1e3])
    for _ in range(20):  # steps of Newton's method; the fit's own numbers are near
        if np.abs(here := off(x)).max() < 1e-9:
            return changed(x), cycles(changed(x))
        slopes = np.column_stack([(off(x + step) - here) / 1e-4 for step in 1e-4 * np.eye(2)])
        x = x - np.linalg.solve(slopes, here)
    raise InputError("No model of figure measured_drive has the period and the torque of the records.")


def _beside(cycle: "_Cycle", sense: int, table: Any, record: Any) -> dict[str, Any]:
    """A record of jerks beside the cycle of the model, sampled alike, its speed averaged.

    Speeds are recorded in whole rpm. A swing is the standard deviation about means over 31 samples, ten jerks. The
    torque falls within 0.03 s as recorded, as that of the model does, so it is not averaged.
    """

    def fast_share(speed: np.ndarray) -> float:
        return float(np.mean(np.round(speed / RPM) > 3))

    def swing(torque: np.ndarray) -> float:
        return float(np.std((torque - np.convolve(torque, np.full(31, 1 / 31), "same"))[15:-15]))

    recorded, torque = sense * table.speed, sense * table.torque
    windows = np.linspace(0.02, 0.15, 131)
    window = float(min(windows, key=lambda one: abs(fast_share(cycle.speed(table.time, one)) - fast_share(recorded))))
    speed, model = cycle.speed(table.time, window), cycle.torque(table.time)
    shown = torque[: RECORD_TIMES.size]
    starts = np.linspace(0, cycle.period, 200, endpoint=False)
    start = min(starts, key=lambda at: np.var(cycle.torque(RECORD_TIMES + at) - shown))
    return {
        "jerk_period": record.period[0], "jerk_period_error": record.period[1], "jerk_stiffness": record.stiffness[0],
        "averaging": window, "model_period": cycle.period, "largest_speed": cycle.speeds.max(),
        "energy_balance": cycle.balanced, "standing_speed": np.median(recorded),
        "swing": [swing(torque), swing(model)], "recorded_top": [np.quantile(one, TOP) for one in (recorded, speed)],
        "mean_torque": [torque.mean(), _mean(cycle)], "recorded_torque": shown,
        "model_torque": cycle.torque(MODEL_TIMES + start),
    }  # fmt: skip


class _Cycle(NamedTuple):
    """A cycle over its ``times`` [s]: speeds [rad/s] and torques of the motor [N m], and the balance of its works."""

    times: np.ndarray
    speeds: np.ndarray
    torques: np.ndarray
    balanced: float

    @property
    def period(self) -> float:
        return float(self.times[-1])

    def torque(self, at: np.ndarray) -> np.ndarray:
        """At some times."""
        return np.asarray(np.interp(at % self.period, self.times, self.torques))

    def speed(self, at: np.ndarray, window: float) -> np.ndarray:
        """Averaged over a window before some times."""
        sums = np.append(0.0, np.cumsum(np.diff(self.times) * 0.5 * (self.speeds[1:] + self.speeds[:-1])))
        now, before = (
            sums[-1] * (one // self.period) + np.interp(one % self.period, self.times, sums)
            for one in (at, at - window)
        )
        return np.asarray((now - before) / window)


def _mean(cycle: _Cycle) -> float:
    """The mean torque of the motor [N m]."""
    return float(np.trapezoid(cycle.torques, cycle.times)) / cycle.period


def _cycle(drive: Drive, viscous: float, offset: float) -> _Cycle:
    """The cycle of a drive with ``viscous`` drag of the bearing [N m s/rad], and an ``offset`` of the torque [N m].

    The torque of the motor is that of spring and damper to the command, which leaves drag of the bearing to the screw.
    """
    from lsvib.dynamics.impulses import work
    from lsvib.stability.starting import end_from_rest

    if (orbit := end_from_rest(drive).orbit) is None:
        raise InputError("The model of figure measured_drive has no cycle where the screw jerked.")
    times = np.linspace(0, orbit.end_time, 4001)
    spring, turning = (orbit.automaton.observe(name, *orbit.at(times)) for name in ("coupling_torque", "screw_speed"))
    sense = math.copysign(1.0, drive.input_speed)
    torque = sense * spring - (drive.support_damping - viscous) * sense * turning + offset
    return _Cycle(times, sense * turning, torque, work(drive, orbit).balance)


def _once_a_turn(table: Any) -> float:
    """The amplitude of the torque of a file at the frequency of the turn, beside a straight line, over its mean [1]."""
    angle = float(table.speed.mean()) * table.time
    columns = np.column_stack([np.ones(angle.size), angle, np.cos(angle), np.sin(angle)])
    found = np.linalg.lstsq(columns, table.torque, rcond=None)[0]
    return float(np.hypot(*found[2:]) / abs(table.torque.mean()))


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the points against those computed apart, the law against the points, and the model against the records."""
    half, torque = dataset.half_sum * 1e3, dataset.measured_torque.values
    halves = {rpm: float(half.values[np.argmin(np.abs(dataset.half_speed.values - rpm * RPM))]) for rpm in HALF_SUMS}
    back, out = torque[: half.size][::-1], torque[half.size :]
    end, residual = dataset.isel(end=0), dataset.residual
    rms, worst = np.sqrt((residual**2).mean("point")), float(np.abs(end.residual).max()) * 1e3
    lost, ways = json.loads(dataset.attrs["not_separable"]), ("back", "outward")
    pairs = "; ".join(" and ".join(map(plain, pair)) for pair in lost)
    (low, high), direction = dataset.explaining_damping.values, dataset.direction
    swing = np.abs(dataset.swing[:, 1] / dataset.swing[:, 0] - 1).max()
    period = np.abs(dataset.model_period / dataset.jerk_period - 1).max()
    off_mean = np.abs(dataset.mean_torque[:, 1] - dataset.mean_torque[:, 0]).values * 1e3
    lowering, lifting = dataset.threads_period.values[[1, 0]]
    held, (by_torque, unsure) = float(dataset.bearing_static_friction), (
        float(dataset[f"fitted_bearing_static_friction{more}"][-1]) for more in ("", "_error")
    )  # fmt: skip
    c = float(dataset.jerking_damping)
    up_to = float(dataset.even_speed.sel(support_damping=c, method="nearest").max()) / RPM
    jerks, stiffness, turns = (dataset[name].values for name in ("jerk_period", "jerk_stiffness", "turn_swing"))
    rise, off = float(end.fitted_stribeck_rise), float(end.fitted_stribeck_rise_error)
    least = float(dataset.half_speed[int(np.argmin(half.values))]) / RPM
    stands = float(dataset.standing_speed.mean()) / RPM
    faster = float((dataset.recorded_top[:, 1] / dataset.recorded_top[:, 0]).min())
    fitted, curve = (_by_angles(dataset, x) for x in (dataset.measured_speed, direction * dataset.law_speed))
    law = {name: near(dataset[name], dataset[f"fitted_{of}"][1], 1e-12) for name, of in _FITTED.items()}
    return [
        *(Check.of("measured_drive.half_sum", halves[rpm], expected=x, rpm=rpm) for rpm, x in HALF_SUMS.items()),
        _tables_check(dataset),
        Check.that("measured_drive.halves", sums=near(half / 1e3, (out - back) / 2, 1e-9),
                   differences=near(dataset.half_difference, (out + back) / 2, 1e-9),
                   speeds=near(dataset.half_speed, dataset.measured_speed.values[half.size :], 1e-12)),
        Check.that("measured_drive.law", rms=each(rms[0] * 1e3, "<=", 0.045), worst=each(worst, "<=", 0.12),
                   stated_rms=near(dataset.residual_rms, rms, 1e-9)),
        Check.of("measured_drive.angles", (dataset.measured_torque - residual) / fitted, expected=1.0),
        Check.that("measured_drive.curve", law=near(dataset.law_torque, curve, 1e-12),
                   loads=near(dataset.measured_load, dataset.load_case[0], 1e-12),
                   load=near(-dataset.axial_force, dataset.load_case[0], 1e-12)),
        Check.that("measured_drive.separable", pairs=pairs,
                   names=every([any(x in pair for pair in lost) for x in ("coulomb", "viscous")])),
        Check.that("measured_drive.falls", rise=each(rise, ">", 4 * off), least=least, off=off),
        *(Check.of("measured_drive.frequency", 1 / x, way=way) for way, x in zip(ways, jerks, strict=True)),
        *(Check.of("measured_drive.stiffness", x, way=way) for way, x in zip(ways, stiffness, strict=True)),
        Check.that("measured_drive.drive", **law, stiffest=each(dataset.coupling_stiffness, "<=", stiffness.max()),
                   softest=each(dataset.coupling_stiffness, ">=", stiffness.min()),
                   speed=near(dataset.input_speed, direction * SLOW, 1e-12)),
        Check.that("measured_drive.damping", low=each(low, ">", 0), high=each(high, ">", low)),
        Check.that("measured_drive.period", period=each(period, "<", 0.01)),
        Check.that("measured_drive.swing", swing=each(swing, "<", 0.05)),
        Check.that("measured_drive.mean", largest=each(off_mean, "<", 0.05), off=off_mean),
        Check.that("measured_drive.model", **_model_clauses(dataset)),
        Check.that("measured_drive.static", apart=each(abs(held - by_torque) / unsure, "<", 2), model=held * 1e3,
                   torque=by_torque * 1e3),
        Check.that("measured_drive.climb", slow=each(stands, ">", 0.8), stands=each(stands, "<", 1.2),
                   faster=each(faster, ">", 1.2)),
        Check.that("measured_drive.share", ratio=each(lifting / lowering, ">", 1.08), lifting=lifting,
                   lowering=lowering),
        Check.that("measured_drive.even", damping=each(c, "<", low / 1.5), up_to=each(up_to, ">", 2 * EVEN / RPM),
                   dampings=every(np.isin(c, dataset.support_damping)), c=c, low=low),
        Check.that("measured_drive.turn", least=each(turns, ">", 0.05), most=each(turns, "<", 0.15), turns=turns),
        Check.that("measured_drive.balance", worst=each(np.abs(dataset.energy_balance), "<", 1e-10)),
    ]  # fmt: skip


def _tables_check(dataset: xr.Dataset) -> Check:
    """Check the points, and the records that are drawn, against the tables as numpy reads them."""
    names, clauses, read = json.loads(dataset.attrs["point_names"]), {}, {}
    for name in (*names, *SLOW_FILES.values()):
        rows = np.genfromtxt(FOLDER / name, delimiter=";", skip_header=12)
        read[name] = rows[np.isfinite(rows).all(axis=1)] * (1e-3, *_SIGNED)  # but for the heading
    points = [[*x.mean(axis=0), *x.std(axis=0, ddof=1)] for x in (read[name][:, 1:] for name in names)]
    kinds = ("measured_speed", "measured_torque", "speed_scatter", "torque_scatter")
    for name, column in zip(kinds, np.transpose(points), strict=True):
        clauses[name] = near(dataset[name], column, 1e-9)
    for row, (word, sense) in enumerate((("back", -1), ("outward", 1))):
        one, (time, speed, torque) = dataset.isel(direction=row), read[SLOW_FILES[sense]].T
        clauses[f"record_{word}"] = near(one.recorded_torque, sense * torque[: one.sizes["record_time"]], 1e-9)
        clauses[f"mean_{word}"] = near(one.mean_torque[0], (sense * torque).mean(), 1e-9)
        clauses[f"median_{word}"] = near(one.standing_speed, np.median(sense * speed), 1e-9)
        clauses[f"times_{word}"] = each(np.abs(one.record_time - time[: one.sizes["record_time"]]), "<", 1e-9)
    return Check.that("measured_drive.tables", **clauses)


def _model_clauses(dataset: xr.Dataset) -> dict[str, Clause]:
    """That the torque of the model that is drawn repeats after its period, and has its mean over some of them."""
    clauses = {}
    for word, one in zip(("back", "outward"), (dataset.isel(direction=k) for k in (0, 1)), strict=True):
        period, time, torque = float(one.model_period), one.model_time.values, one.model_torque.values
        last = period * (time[-1] // period)
        times = np.linspace(0, last, 20_001)
        drawn = np.interp(times, time, torque)
        clauses[f"mean_{word}"] = near(drawn.mean(), one.mean_torque[1], 2e-3)
        again = np.interp(times[times < last - period] + period, time, torque)
        clauses[f"repeats_{word}"] = each(np.abs(again - drawn[: again.size]).mean() / torque.mean(), "<", 2e-3)
    return clauses


def _by_angles(dataset: xr.Dataset, speed: xr.DataArray) -> xr.DataArray:
    """The torque of each end at some speeds, s r_m W tan(φ ± λ), φ = arctan μ, and drag [N m]."""
    sliding, sense = dataset.pitch_radius * abs(speed) / np.cos(dataset.lead_angle), np.sign(speed)
    exponent = xr.DataArray(json.loads(dataset.attrs["stribeck_exponents"]), dims="end")
    fade = np.exp(-((sliding / dataset.fitted_stribeck_speed) ** exponent))
    mu = dataset.fitted_friction_coefficient + dataset.fitted_stribeck_rise * fade
    angle = np.arctan(mu + dataset.fitted_friction_slope * sliding)
    drag = dataset.fitted_coulomb * sense + dataset.fitted_viscous * speed + dataset.fitted_offset
    tangents = np.tan(angle + sense * np.sign(dataset.load_case[0]) * dataset.lead_angle)
    return drag + sense * dataset.pitch_radius * abs(dataset.load_case[0]) * tangents


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the law, the records of jerks beside the model, the speed from which on it is even, and residuals.

    The dotted line is the damping with which the model has the period of the screw.
    """
    figure = style.new_figure(style.DOUBLE, 5.2)
    (torque, record), (limit, residual) = figure.subplots(2, 2)
    torque_panel(torque, dataset)
    residual_panel(residual, dataset.isel(end=[0]))
    low, high = dataset.explaining_damping.values
    limit.axvspan(low, high, color=style.GREY, alpha=0.25, linewidth=0)
    looks = ((style.VERMILION, "o", "-", "lifting"), (style.BLUE, "s", "--", "lowering"))
    for row, (colour, mark, dashes, words) in enumerate(looks):
        own = dataset.isel(direction=row)
        record.plot(dataset.record_time, own.recorded_torque * 1e3, mark, color=colour, markersize=3,
                    label=f"record, {words}")  # fmt: skip
        record.plot(dataset.model_time, own.model_torque * 1e3, dashes, color=colour, linewidth=0.9,
                    label=f"model, {words}")  # fmt: skip
        kept = own.even_speed.where((own.even_speed > 0) & np.isfinite(own.even_speed))
        limit.plot(dataset.support_damping, kept / RPM, dashes, color=colour, label=f"limit, {words}")
    bottom, top = record.get_ylim()
    record.set(xlabel="Time [s]", ylabel="Motor torque [mN m]", ylim=(bottom, top + 0.3 * (top - bottom)))
    record.legend(fontsize=7, ncols=2, loc="upper left", columnspacing=0.8, handletextpad=0.3)
    as_often = float(dataset.jerking_damping)
    limit.axvline(as_often, color="black", linestyle=":", linewidth=0.9)
    limit.annotate("same jerk period", (as_often, 1.2), xytext=(4, 0), textcoords="offset points", fontsize=7)
    at = math.sqrt(low * high)
    for rpm, mark, words in ((SLOW / RPM, "v", "jerked"), (EVEN / RPM, "^", "was steady")):
        limit.plot(at, rpm, mark, color="black", markersize=4)
        limit.annotate(words, (at, rpm), xytext=(6, 0), textcoords="offset points", va="center", fontsize=7)
    limit.set(yscale="log", ylabel="Screw speed [rpm]", ylim=(1, 100),
              xlabel=style.label(dataset.support_damping, "damping of command and bearing"))  # fmt: skip
    ticks = [1e-4, 2e-4, 3e-4, 4e-4]
    limit.set_xticks(ticks, [style.number(tick) for tick in ticks])
    limit.set_yticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"])
    limit.set_yticks([], minor=True)
    limit.legend(fontsize=7, loc="upper right", title="above: runs steadily", title_fontsize=7)
    titles = "(a) motor torque", "(b) jerks at 2 rpm", "(c) lowest steady speed", "(d) measured − fitted"
    for axes, title in zip((torque, record, limit, residual), titles, strict=True):
        axes.set_title(title)
    return figure
