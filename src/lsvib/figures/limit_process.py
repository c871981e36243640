"""The limit process: convergence of the drive with compliant threads to the rigid one, on every branch of the rule."""

from collections.abc import Sequence
from enum import IntEnum
from itertools import pairwise, product
from typing import ClassVar

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.datasets import attributes as cf
from lsvib.datasets import phase_plane
from lsvib.datasets.checks import Check
from lsvib.figures import printed_laws, style
from lsvib.figures import settings as of
from lsvib.figures.common import LimitBranch, about, named
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.models.names import RULES

CAPTION = """\
The limit process, k_c = c_c · 1 s⁻¹ → ∞. Each column of (a) and (b) is a branch: drive on top; below, the sign of N in
the impact and the number of the region in which the screw then stands, or a whole cycle. (a) Every motion converges to
the rigid one under the rule contact_sign, not under at_once where the rules part (crosses; where a cross lies low, the
times at rest differ). (b) Fitted orders with their standard errors. See docs/limit_process.md.
"""

_ORDER = 0.8  # of convergence, at least: the first order shows as 0.86 to 0.94 at stiffnesses that are finite
_SADDLE_MULTIPLES = (2.0, 0.5)
_QUANTITIES = {  # dimensions besides the stiffness, units, words
    "motion_distance": (("branch", "rule"), "1", "distance of the motion from the rigid one in the phase plane"),
    "rest_error": (("branch", "rule"), "s", "time at rest less that of the rigid motion"),
    "impulse_error": (("branch",), "1", "relative error of the normal impulse of the impact"),
    "period_error": (("branch", "rule"), "1", "relative error of the period"),
    "stop_time": (("branch",), "s", "time that an impact takes, until the screw first stands"),
}
_ERRORS = {  # colour, words, mark
    "motion_distance": (style.BLUE, "distance", "o"),
    "rest_error": (style.GREEN, "time at rest", "s"),
    "impulse_error": (style.ORANGE, "impulse", "^"),
    "period_error": (style.PURPLE, "period", "D"),
}


class Settings(of.FigureSettings):
    flows: ClassVar = ("modal",)
    unused: ClassVar = ("support_damping", "translation_damping", "axial_force")

    drive: of.DriveChanges
    axial_forces: of.several(of.parameter("axial_force", *of.NotZero), 2, 4, "Axial forces [N], of both signs.")
    support_dampings: of.several(of.Damping, 1, 4, "Support dampings c [N m s/rad], a small and a large one.")
    speed: float = Field(gt=0, le=1e9, description="Screw speed before an impact [rad/s].")
    duration: of.Duration
    start: of.State
    stiffness: of.several(of.parameter("contact_stiffness"), 3, 50, "Contact stiffnesses k_c [N/m], ascending.")
    fit_from: float = Field(gt=0, description="Least stiffness that orders are fitted to [N/m].")


class BranchVerdict(IntEnum):
    """Which rule of resuming the motion follows as the contact stiffens."""

    NEITHER = 0
    CONTACT_SIGN = 1
    AT_ONCE = 2
    BOTH = 3  # the rules agree on the branch, or are not distinguished


def build(settings: of.Values) -> xr.Dataset:
    """Compute the deviations from the rigid drive over the stiffness k_c = c_c · 1 s⁻¹, for each branch.

    Γ₊ < 0, c_x = 0; the pairs of forces and dampings are the drives, ``start`` is that of the cycles.
    """
    from lsvib.figures import stiff_limit
    from lsvib.models.names import Event
    from lsvib.models.rigid import MotionMode

    stiffness, base = np.array(settings["stiffness"], dtype=float), Drive.of(settings["drive"])
    along = "axial_force", "support_damping"
    pairs = product(settings["axial_forces"], settings["support_dampings"])
    drives = [base.replace(**dict(zip(along, pair, strict=True))) for pair in pairs]
    start, speed, duration = settings["start"], settings["speed"], settings["duration"]
    branches = [b for d in drives for b in stiff_limit.branches(d, speed, duration, [start["u"], start["w"]])]
    deviations = _deviations(branches, stiffness, settings["fit_from"])
    sign, region = np.array([(b.impact.sign, b.impact.region) for b in branches], dtype=np.int8).T
    after = [[m.automaton.codes[m.mode[m.kind == Event.SEIZURE][0]] for m in b.rigid] for b in branches]
    differ, follows = [b.differ for b in branches], "what follows the first seizure of the rigid drive"
    return xr.Dataset(
        deviations | _rules_followed(branches, deviations) | _indeterminate(drives[0], stiffness, speed, duration),
        coords={
            **cf.drive_parameters([b.drive for b in branches], "branch", along=along, printed=("Sect. 8.6",)),
            **cf.axis("contact_stiffness", stiffness),
            **cf.axis("contact_damping", stiffness, ("contact_stiffness",)),
            **phase_plane.rule_coordinate(),
            "branch": cf.variable("branch", np.arange(len(branches)), "1", "index of the branch"),
            "impact_sign": ("branch", sign, cf.SIGNS | {"long_name": "sign of the impact, none for a cycle"}),
            "region": cf.flagged("branch", region, "where the screw stands after the impact", stiff_limit.Region),
            "rules_differ": cf.yes_no("branch", differ, "the rigid motion depends on the rule of resuming"),
            "outcome_after_seizure": cf.flagged(("branch", "rule"), after, follows, MotionMode),
            **cf.start_state(start, "of the cycles"),
            "impact_speed": cf.variable((), speed, "rad s-1", "screw speed before a seizure", r"$\dot\theta$"),
            "fit_from": cf.variable((), settings["fit_from"], "N m-1", "least stiffness that orders are fitted to"),
        },
        attrs=about(__doc__, "exact event-driven motion of both models", "Sects 8.2, 8.6; docs/limit_process.md"),
    )


def _deviations(branches: Sequence[LimitBranch], stiffness: np.ndarray, fit_from: float) -> cf.Variables:
    """Deviations from the rigid drive, by branch and contact stiffness [N/m], and the orders of their fall."""
    from lsvib.figures import stiff_limit

    shape = len(branches), stiffness.size
    found = {name: np.full((*shape, len(RULES))[: len(dims) + 1], np.nan) for name, (dims, *_) in _QUANTITIES.items()}
    for (i, branch), (j, k) in product(enumerate(branches), enumerate(stiffness)):
        compliant = branch.drive.replace(contact_stiffness=k, contact_damping=k)
        for name, value in stiff_limit.deviations(branch, compliant).items():
            found[name][i, j] = value
    variables, fitted = {}, stiffness >= fit_from
    for name, (dims, *words) in _QUANTITIES.items():
        variables[name] = cf.variable(("branch", "contact_stiffness", *dims[1:]), found[name], *words)
        order, error = stiff_limit.fitted_order(stiffness[fitted], found[name][:, fitted])
        fit = f"order of the {name.replace('_', ' ')}"
        variables[f"{name}_order"] = cf.variable(dims, order, "1", f"{fit} in one over the stiffness")
        variables[f"{name}_order_error"] = cf.variable(dims, error, "1", f"standard error of the {fit}")
    return variables


def _indeterminate(drive: Drive, stiffness: np.ndarray, speed: float, duration: float) -> cf.Variables:
    """The first event of motions between two solutions, from contact forces of _SADDLE_MULTIPLES times the saddle's.

    Without contact damping N′ = 0 at the start. Of the larger force also the velocity that the chapter's formula says
    the screw has lost when it first stands (Sect. 8.2), and the limit of that formula, over the velocity lost.
    """
    from lsvib.engine.motion import follow
    from lsvib.models.model import automaton_of
    from lsvib.models.names import Event

    c, w = coefficients(drive), speed - drive.input_speed
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    u = -(q_w * w + q_0) / q_u - 0.05  # N < 0 under law − there
    drift, gamma = q_u * u + q_w * w + q_0, float(c.gamma[1])  # W = I P − m r_m tan λ T
    lever, cosine = float(printed_laws.lever(drive, 1)), float(np.cos(drive.lead_angle))
    torque = -drive.coupling_stiffness * (float(c.deflection) + u) - drive.support_damping * speed
    kinds, times = [], []
    for damped, multiple, k in product((1, 0), _SADDLE_MULTIPLES, stiffness):
        contact = drive.replace(contact_stiffness=k, contact_damping=damped * k)
        mismatch = multiple * drift / (lever * gamma) / (k * cosine)
        state = [u, w, 0.0, mismatch] if damped else [u, w, mismatch, 0.0]
        motion = follow(automaton_of(contact), state, duration, max_events=1)
        kinds.append((*motion.kind, -1)[0])
        times.append((*motion.time, np.nan)[0])
    size, dims = (2, len(_SADDLE_MULTIPLES), stiffness.size), ("contact_kind", "multiple", "contact_stiffness")
    kinds, times = np.reshape(kinds, size).astype(np.int8), np.reshape(times, size)
    t, pulse = times[1, 0], np.sqrt(stiffness * cosine * lever * abs(gamma) / (drive.mass * drive.screw_inertia))  # ω̄
    factor = drive.pitch_radius * float(c.xi[1]) * drift / drive.screw_inertia / speed
    growth = factor * (_SADDLE_MULTIPLES[0] - 1) / (2 * gamma) / pulse
    limit = growth * np.exp(pulse * t)
    whole = limit - growth * np.exp(-pulse * t) + (factor / gamma - torque / drive.screw_inertia / speed) * t
    event, words = "first event from a multiple of the contact force of the saddle", "velocity lost by the formula"
    return {
        "indeterminate_event": (dims, kinds, cf.attributes("1", event, **cf.flags(Event, none=True))),
        "indeterminate_time": cf.variable(dims, times, "s", f"time of the {event}"),
        "formula_velocity": cf.variable("contact_stiffness", whole, "1", f"{words} of Sect. 8.2 over that lost"),
        "formula_velocity_limit": cf.variable("contact_stiffness", limit, "1", f"{words} in its limit over that lost"),
    }


def _rules_followed(branches: Sequence[LimitBranch], variables: cf.Variables) -> cf.Variables:
    """The rule that each branch follows, if with the order wanted and all small at the end; the rigid duration."""
    durations = np.array([branch.rigid[0].end_time for branch in branches])
    distance, rest = (variables[name][1][:, -1] for name in ("motion_distance", "rest_error"))
    deviation = np.fmax(distance, np.abs(rest) / durations[:, None])
    follows = (variables["motion_distance_order"][1] >= _ORDER) & (deviation < 1e-3)  # nothing that a picture shows
    follows &= deviation < 10.0 * deviation[..., ::-1]
    verdicts = follows @ [BranchVerdict.CONTACT_SIGN, BranchVerdict.AT_ONCE]
    return {
        "rigid_duration": cf.variable("branch", durations, "s", "duration of the rigid motion, a period for a cycle"),
        "rule_followed": cf.flagged("branch", verdicts, "rule that the motion follows", BranchVerdict),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the orders, the rule that each branch follows, what impacts do, and the chapter's formula of one."""
    told, both = named(dataset.rule_followed, "contact sign"), named(dataset.rule_followed, "both")
    first, differ = dataset.isel(rule=0), dataset.rules_differ.values == 1
    order, *others = (first[f"{name}_order"] for name in _ERRORS)
    impact = ~named(dataset.region, "cycle")
    stops, brief = dataset.stop_time.values[impact], dataset.stop_time_order.values[impact]
    fitted = dataset.contact_stiffness.values >= float(dataset.fit_from)
    numbers = {"order": _ORDER, "stiffest": dataset.contact_stiffness[-1]}
    stiff = dataset.isel(contact_stiffness=fitted)
    seizes, turns = (named(stiff.indeterminate_event, kind) for kind in ("stick", "contact reversal"))
    time = stiff.indeterminate_time.values[:, 0]
    error = np.abs(np.stack([stiff.formula_velocity, stiff.formula_velocity_limit]) - 1)
    converges = {"told": told | both, "distance": first.motion_distance[:, -1], "orders": order}
    quick = (np.diff(stops[:, fitted], axis=-1) < 0).all() and brief.min() >= _ORDER
    ranges = [f"{float(x.min()):.3f} to {float(x.max()):.3f}" for x in others]
    agrees = (np.diff(error) < 0).all() and error[:, -1].max() < 0.05
    return [
        Check.that(
            "limit_process.converges",
            (told | both).all(),
            errors=first.motion_distance_order_error,
            **converges,
            **numbers,
        ),
        Check.that("limit_process.orders", all(x.min() >= _ORDER for x in others), ranges=ranges, order=_ORDER),
        Check.that("limit_process.rules", told[differ].all() and differ.any(), told=told & differ, differ=differ),
        Check.that("limit_process.impact_time", quick, orders=brief, times=stops[:, -1], **numbers),
        Check.everywhere("limit_process.stands", np.isfinite(stops), "impacts"),
        Check.that(
            "limit_process.seizes",
            seizes[:, 0].all() and (np.diff(time) < 0).all(),
            seizes=seizes[:, 0],
            time=time[..., -1],
        ),
        Check.that("limit_process.turns_on", turns[:, 1].all(), turns=~seizes[:, 1]),
        Check.that("limit_process.formula", agrees, whole=error[0, -1], limit=error[1, -1]),
    ]


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw (a) the distances and (b) the orders, each column a branch.

    In (a) the softest contact is on top, the stiffest below; crosses stand where the rules differ.
    """
    from matplotlib import colormaps

    figure, first, branch = style.new_figure(style.DOUBLE, 4.0), dataset.isel(rule=0), dataset.branch
    distance, orders = figure.subplots(2, 1, sharex=True, height_ratios=(1.3, 1))
    stiffness = dataset.contact_stiffness
    shades = colormaps["Blues"](np.linspace(0.15, 1, stiffness.size))
    for value, own, colour in zip(stiffness, first.motion_distance.T, shades, strict=True):
        distance.plot(branch, own, "o", color=colour, mec=style.BLUE, mew=0.4, markersize=3.2,
                      label=f"$k_c$ = {style.number(value)} N m⁻¹")  # fmt: skip
    other = dataset.motion_distance[:, -1, 1].where(dataset.rules_differ == 1)
    words = "stiffest contact against\nthe other rule, at once"
    distance.plot(branch, other, "x", color=style.VERMILION, markersize=4.5, label=words)
    distance.set(yscale="log", ylabel="Distance to the\nrigid motion")
    distance.set_title("(a) distance, each column a branch", pad=25)
    for k, (name, (colour, words, mark)) in enumerate(_ERRORS.items()):
        order, error = (first[f"{name}_{what}"] for what in ("order", "order_error"))
        orders.errorbar(branch + 0.18 * (k - 1.5), order, error, color=colour, fmt=mark, markersize=2.5, linewidth=0.6,
                        label=words)  # fmt: skip
    orders.set(title="(b) fitted orders", ylabel="Order in $1/k_c$")
    _name_branches((distance, orders), dataset)
    return figure


def _name_branches(columns: Sequence[style.Axes], dataset: xr.Dataset) -> None:
    """Sign of the impact and number of the region below each column, the drive above each group, lines between."""
    pairs = zip(dataset.impact_sign.values, dataset.region.values, strict=True)
    names = [f"{'+' if sign > 0 else '−'}{int(region)}" if sign else "cyc." for sign, region in pairs]
    columns[-1].set_xticks(dataset.branch, names, fontsize=6.5, rotation=90)
    columns[-1].set_xlabel(
        "Branch: sign of $N$ in the impact; torque after it 1 above the band of rest, 2 in it with $Q < 0$, "
        "3 with $Q > 0$, 4 below it; cycle",
        fontsize=6.5,
    )
    drives = np.stack([dataset.axial_force.values, dataset.support_damping.values])
    count, changes = dataset.sizes["branch"], np.flatnonzero((np.diff(drives, axis=1) != 0).any(axis=0)) + 1
    for axes in columns:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), handletextpad=0.3, labelspacing=0.25)
        for place in changes:
            axes.axvline(place - 0.5, color=style.GREY, linewidth=0.6)
        axes.set_xlim(-0.7, count - 0.3)
        axes.tick_params(axis="x", length=0)
    for start, stop in pairwise([0, *changes, count]):
        force, damping = (style.number(value) for value in drives[:, start])
        columns[0].text((start + stop - 1) / 2, 1.02, f"$R$ = {force} N\n$c$ = {damping}", ha="center", va="bottom",
                        fontsize=7.5, transform=columns[0].get_xaxis_transform())  # fmt: skip
