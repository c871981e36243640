"""The limit process: convergence of the drive with compliant threads to the rigid one, on every branch of the rule."""

from collections.abc import Sequence
from enum import IntEnum
from itertools import pairwise, product
from typing import ClassVar

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.datasets import phase_plane
from lsvib.datasets.attributes import (
    SIGNS,
    Variables,
    attributes,
    axis,
    drive_parameters,
    flagged,
    flags_or_none,
    start_state,
    variable,
    yes_no,
)
from lsvib.datasets.checks import Check
from lsvib.figures import printed_laws, style
from lsvib.figures import settings as of
from lsvib.figures.common import LimitBranch, about, flag_names, named
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.models.names import RULES

CAPTION = """\
The limit process. Each column of (a) to (c) is a branch: drive on top; below, the sign of N in the impact and the
number of the region in which the screw then stands, or a whole cycle. (a) In the viscous limit, k_c = c_c · 1 s⁻¹,
every motion converges to the rigid one under the rule contact_sign, not under at_once where the rules part (crosses;
where a cross lies low, the times at rest differ). (b) Fitted orders with their standard errors. (c) No convergence in
the elastic limit, slow or none with a fixed damping ratio. (d) All errors in the viscous limit, median and range of the
branches; (e) number of rests, colours of (c); (f) the force of the rebound, which must stay below the size of R. See
docs/limit_process.md.
"""

_ORDER = 0.8  # of convergence, at least: the first order shows as 0.86 to 0.94 at stiffnesses that are finite
_SADDLE_MULTIPLES = (2.0, 0.5)
_QUANTITIES = {
    "motion_distance": ("1", "distance of the motion from the rigid one in the phase plane"),
    "rest_error": ("s", "time at rest less that of the rigid motion"),
    "impulse_error": ("1", "relative error of the normal impulse of the impact"),
    "period_error": ("1", "relative error of the period"),
    "rests": ("1", "number of rests"),
    "stop_time": ("s", "time that an impact takes, until the screw first stands"),
}
_BY_RULE = ("motion_distance", "rest_error", "period_error")
_ERRORS = {  # colour, words, mark
    "motion_distance": (style.BLUE, "distance", "o"),
    "rest_error": (style.GREEN, "time at rest", "s"),
    "impulse_error": (style.ORANGE, "impulse", "^"),
    "period_error": (style.PURPLE, "period", "D"),
}
_VISCOUS = "viscous"
_FAMILIES = {_VISCOUS: (style.BLUE, "o"), "damping ratio": (style.SKY, "s"), "elastic": (style.GREY, "D")}


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
    damping_ratio: float = Field(gt=0, le=1000, description="Damping ratio of the nut in its family [1].")


class BranchVerdict(IntEnum):
    """Which rule of resuming the motion follows as the contact stiffens."""

    NEITHER = 0
    CONTACT_SIGN = 1
    AT_ONCE = 2
    BOTH = 3  # the rules agree on the branch, or are not distinguished


def build(settings: of.Values) -> xr.Dataset:
    """Compute the deviations from the rigid drive over the stiffness, for each family of contacts and each branch.

    Γ₊ < 0, c_x = 0; the pairs of forces and dampings are the drives, ``start`` is that of the cycles.
    """
    from lsvib.contact import stiff_limit
    from lsvib.contact.stiff_limit import BranchFamily

    stiffness, base = np.array(settings["stiffness"], dtype=float), Drive.of(settings["drive"])
    pairs = [(r, c) for r in settings["axial_forces"] for c in settings["support_dampings"]]
    drives = [base.replace(axial_force=r, support_damping=c) for r, c in pairs]
    start, speed, ratio = settings["start"], settings["speed"], settings["damping_ratio"]
    state = [start["u"], start["w"]]
    branches = [b for d in drives for b in stiff_limit.branches(d, speed, settings["duration"], state)]
    stiffened = [[stiff_limit.stiffened(drives[0], family, k, ratio) for k in stiffness] for family in BranchFamily]
    damping = [[drive.contact_damping for drive in row] for row in stiffened]
    rebound = [[stiff_limit.rebound_force(drive, speed) for drive in row] for row in stiffened]
    dims, thrown = ("family", "contact_stiffness"), "force with which the contact throws the nut back"
    deviations = _deviations(branches, stiffness, ratio, settings["fit_from"])
    varied = ("axial_force", "support_damping")
    return xr.Dataset(
        deviations
        | {"rebound_force": variable(dims, rebound, "N", thrown)}
        | _rules_followed(branches, deviations)
        | _indeterminate(drives[0], stiffness, speed, settings["duration"]),
        coords={
            **drive_parameters([b.drive for b in branches], "branch", along=varied, printed=("Sect. 8.6",)),
            "family": flagged("family", BranchFamily, "how the damping of the contact grows", BranchFamily),
            **axis("contact_stiffness", stiffness),
            **axis("contact_damping", damping, dims),
            **phase_plane.rule_coordinate(),
            **_branch_coordinates(branches),
            **start_state(start, "of the cycles"),
            "impact_speed": variable((), speed, "rad s-1", "screw speed before a seizure", r"$\dot\theta$"),
            "nut_damping_ratio": variable((), ratio, "1", "damping ratio of the nut", r"$\zeta$"),
            "fit_from": variable((), settings["fit_from"], "N m-1", "least stiffness that orders are fitted to"),
        },
        attrs=about(__doc__, "exact event-driven motion of both models", "Sects 8.2, 8.6; docs/limit_process.md"),
    )


def _deviations(branches: Sequence[LimitBranch], stiffness: np.ndarray, ratio: float, fit_from: float) -> Variables:
    """Deviations from the rigid drive, by family, branch and contact stiffness [N/m], and the orders of their fall."""
    from lsvib.contact import stiff_limit
    from lsvib.contact.stiff_limit import BranchFamily

    size = (len(BranchFamily), len(branches), stiffness.size)
    found = {name: np.full((*size, len(RULES)) if name in _BY_RULE else size, np.nan) for name in _QUANTITIES}
    for family, (i, branch), (j, k) in product(BranchFamily, enumerate(branches), enumerate(stiffness)):
        compliant = stiff_limit.stiffened(branch.drive, family, k, ratio)
        for name, value in stiff_limit.deviations(branch, compliant).items():
            found[name][family, i, j] = value
    variables, fitted = {}, stiffness >= fit_from
    for name, values in found.items():
        dims, words = ("family", "branch", *(["rule"] if name in _BY_RULE else [])), name.replace("_", " ")
        variables[name] = variable((*dims[:2], "contact_stiffness", *dims[2:]), values, *_QUANTITIES[name])
        if name == "rests":
            continue
        fits = np.apply_along_axis(lambda error: stiff_limit.fitted_order(stiffness[fitted], error), 2,
                                   values[:, :, fitted])  # fmt: skip
        order, error = f"order of the {words} in one over the stiffness", f"standard error of the order of the {words}"
        variables[f"{name}_order"] = variable(dims, fits[:, :, 0], "1", order)
        variables[f"{name}_order_error"] = variable(dims, fits[:, :, 1], "1", error)
    return variables


def _indeterminate(drive: Drive, stiffness: np.ndarray, speed: float, duration: float) -> Variables:
    """The first event of motions between two solutions, from contact forces of _SADDLE_MULTIPLES times the saddle's.

    Without contact damping N′ = 0 at the start. Of the larger force also the velocity that the chapter's formula says
    the screw has lost when it first stands (Sect. 8.2), and the limit of that formula, over the velocity lost.
    """
    from lsvib.contact.stiff_limit import BranchFamily, stiffened
    from lsvib.engine.motion import follow
    from lsvib.models.model import automaton_of
    from lsvib.models.names import Event

    c, w = coefficients(drive), speed - drive.input_speed
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    u = -(q_w * w + q_0) / q_u - 0.05  # N < 0 under law − there
    drift, gamma, xi = q_u * u + q_w * w + q_0, float(c.gamma[1]), float(c.xi[1])  # W = I P − m r_m tan λ T
    lever, cosine = float(printed_laws.lever(drive, 1)), float(np.cos(drive.lead_angle))
    torque = -drive.coupling_stiffness * (float(c.deflection) + u) - drive.support_damping * speed
    kinds, times, lost = [], [], []
    for family, multiple, k in product((BranchFamily.VISCOUS, BranchFamily.ELASTIC), _SADDLE_MULTIPLES, stiffness):
        contact, force = stiffened(drive, family, k, 0.0), multiple * drift / (lever * gamma)
        rate = force / (contact.contact_damping * cosine) if contact.contact_damping else 0.0
        state = [u, w, 0.0 if rate else force / (k * cosine), rate]
        motion = follow(automaton_of(contact), state, duration)
        kinds.append(motion.kind[0] if motion.kind.size else -1)
        times.append(motion.time[0] if motion.kind.size else np.nan)
        pulse = np.sqrt(k * cosine * lever * abs(gamma) / (drive.mass * drive.screw_inertia))  # ω̄ of (8.9)
        factor, t = -drive.pitch_radius * xi * drift / drive.screw_inertia, times[-1]
        a = (multiple - 1) / (2 * gamma)
        whole = a / pulse * (np.exp(pulse * t) - np.exp(-pulse * t)) + t / gamma
        change = torque * t / drive.screw_inertia + factor * whole, factor * a * np.exp(pulse * t) / pulse
        lost.append(-np.array(change) / speed)
    size, dims = (2, len(_SADDLE_MULTIPLES), stiffness.size), ("contact_kind", "multiple", "contact_stiffness")
    kinds, times = np.reshape(kinds, size).astype(np.int8), np.reshape(times, size)
    own = np.reshape(lost, (*size, 2))[1, 0]  # without contact damping, from the larger force
    event, words = "first event from a multiple of the contact force of the saddle", "velocity lost by the formula"
    return {
        "indeterminate_event": (dims, kinds, attributes("1", event, **flags_or_none(Event))),
        "indeterminate_time": variable(dims, times, "s", f"time of the {event}"),
        "formula_velocity": variable("contact_stiffness", own[:, 0], "1", f"{words} of Sect. 8.2 over that lost"),
        "formula_velocity_limit": variable("contact_stiffness", own[:, 1], "1", f"{words} in its limit over that lost"),
    }


def _rules_followed(branches: Sequence[LimitBranch], variables: Variables) -> Variables:
    """The rule that each branch follows, if with the order wanted and all small at the end; the rigid duration."""
    durations = np.array([branch.rigid[0].end_time for branch in branches])
    distance, rest = (variables[name][1][:, :, -1] for name in ("motion_distance", "rest_error"))
    deviation = np.fmax(distance, np.abs(rest) / durations[:, None])
    follows = (variables["motion_distance_order"][1] >= _ORDER) & (deviation < 1e-3)  # nothing that a picture shows
    follows &= deviation < 10.0 * deviation[..., ::-1]
    agree = np.array([not branch.differ for branch in branches])
    follows[:, agree, 1] = follows[:, agree, 0]
    verdicts, dims = follows @ [BranchVerdict.CONTACT_SIGN, BranchVerdict.AT_ONCE], ("family", "branch")
    return {
        "rigid_duration": variable("branch", durations, "s", "duration of the rigid motion, a period for a cycle"),
        "rule_followed": flagged(dims, verdicts, "rule that the motion follows", BranchVerdict),
    }


def _branch_coordinates(branches: Sequence[LimitBranch]) -> Variables:
    from lsvib.contact import stiff_limit
    from lsvib.contact.stiff_limit import ImpactOutcome, Region

    hits = [b.impact for b in branches]
    sign = np.array([0 if hit is None else hit.sign for hit in hits], dtype=np.int8)
    region = [Region.CYCLE if hit is None else hit.region for hit in hits]
    after, dims = [[stiff_limit.outcome(motion) for motion in b.rigid] for b in branches], ("branch", "rule")
    differ, words = [b.differ for b in branches], "what follows the first seizure of the rigid drive"
    return {
        "branch": variable("branch", np.arange(len(branches)), "1", "index of the branch"),
        "impact_sign": ("branch", sign, SIGNS | {"long_name": "sign of the impact, none for a cycle"}),
        "region": flagged("branch", region, "where the screw stands after the impact", Region),
        "rules_differ": yes_no("branch", differ, "the rigid motion depends on the rule of resuming"),
        "outcome_after_seizure": flagged(dims, after, words, ImpactOutcome),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the orders in the viscous limit, the rule that each branch follows, and that the elastic limit differs."""
    viscous, ratio, elastic = _families(dataset).values()
    return [
        *_viscous_checks(dataset, viscous),
        *_other_checks(elastic, ratio, viscous),
        *_outcome_checks(dataset, viscous),
    ]


def _families(dataset: xr.Dataset) -> dict[str, xr.Dataset]:
    return {name: dataset.sel(family=value) for value, name in flag_names(dataset.family).items()}


def _viscous_checks(dataset: xr.Dataset, viscous: xr.Dataset) -> list[Check]:
    """Check that contacts whose damping grows with their stiffness tend to the rigid drive, and by which rule."""
    told, both = named(viscous.rule_followed, "contact sign"), named(viscous.rule_followed, "both")
    order, error = viscous.motion_distance_order.values[:, 0], viscous.motion_distance_order_error.values[:, 0]
    closest, differ = viscous.motion_distance.values[:, -1, 0].max(), viscous.rules_differ.values == 1
    others = {name: _by_first_rule(viscous[f"{name}_order"]).values for name in list(_ERRORS)[1:]}
    impact, fitted = ~named(dataset.region, "cycle"), dataset.contact_stiffness.values >= float(dataset.fit_from)
    stops, brief = dataset.stop_time.values[:, impact], viscous.stop_time_order.values[impact]
    return [
        Check.holds(
            "Viscous limit: on every branch the motion converges to the rigid one under the rule contact_sign, its "
            f"distance with an order of at least {_ORDER:g}",
            "Sect. 8.2, rule of resuming",
            f"{(told | both).sum()} of {told.size} branches, distance at most "
            f"{closest:.1e} at k_c = c_c = {float(viscous.contact_stiffness[-1]):.0e}, "
            f"orders {order.min():.3f} to {order.max():.3f}, standard errors up to {error.max():.3f}",
            (told | both).all(),
        ),
        Check.holds(
            f"Viscous limit: the errors of rest, impulse and period fall with an order of at least {_ORDER:g}, too",
            "limit process",
            "; ".join(f"{name.split('_')[0]} {np.nanmin(x):.3f} to {np.nanmax(x):.3f}" for name, x in others.items()),
            all(np.nanmin(x) >= _ORDER for x in others.values()),
        ),
        Check.holds(
            "Viscous limit: where the two rules of resuming part, contact_sign is followed and at_once is not",
            "Sect. 8.6, rule of resuming",
            f"{(told & differ).sum()} of {differ.sum()} branches; distance or rest under at_once stays",
            told[differ].all() and differ.any(),
        ),
        Check.holds(
            "The time that an impact takes tends to zero: it falls from each fitted stiffness to the next in every "
            f"family, in the viscous limit with an order of at least {_ORDER:g}",
            "Sect. 8.2",
            f"viscous orders {brief.min():.3f} to {brief.max():.3f}; at most "
            f"{', '.join(f'{x:.1e}' for x in stops[..., -1].max(axis=1))} s by family at k_c = "
            f"{float(dataset.contact_stiffness[-1]):.0e} N/m",
            (np.diff(stops[..., fitted], axis=-1) < 0).all() and brief.min() >= _ORDER,
        ),
    ]


def _other_checks(elastic: xr.Dataset, ratio: xr.Dataset, viscous: xr.Dataset) -> list[Check]:
    """Check that contacts without damping, or with a fixed damping ratio of the nut, tend to no rigid motion."""
    impact = ~named(viscous.region, "cycle")
    lost, nearest = named(elastic.rule_followed, "neither"), float(np.nanmin(elastic.motion_distance.values[:, -1, 0]))
    rests, rigid_rests = elastic.rests.values[impact, -1], viscous.rests.values[impact, -1]
    excess, slow = ratio.impulse_error.values[impact, -1], ratio.motion_distance_order.values[:, 0]
    far = ratio.motion_distance.values[:, -1, 0]
    return [
        Check.holds(
            "Elastic limit: on no branch does the motion converge to the rigid one under either rule",
            "limit process",
            f"{lost.sum()} of {lost.size} branches follow neither; distance at least {nearest:.2g}",
            lost.all(),
        ),
        Check.holds(
            "Elastic limit: after an impact the rest is a chain of short rests",
            "limit process",
            f"at k_c = {float(elastic.contact_stiffness[-1]):.0e} N/m {int(rests.min())} to "
            f"{int(rests.max())} rests, in the viscous limit at most {int(rigid_rests.max())}",
            (rests > rigid_rests).all(),
        ),
        Check.holds(
            "Fixed damping ratio: even an overdamped contact throws the nut back: the impulse stays too large, and the "
            "distance falls slowly or not at all",
            "limit process",
            f"zeta = {float(ratio.nut_damping_ratio):g}: impulse too large by {excess.min():.1%} to "
            f"{excess.max():.1%}, distance at least {far.min():.2g}, orders {slow.min():.2f} to "
            f"{slow.max():.2f}; force of the rebound {float(ratio.rebound_force[-1]):.3g} N, in the viscous limit "
            f"{float(viscous.rebound_force[-1]):.1e} N",
            (excess > 0.01).all() and (far > 0.01).all() and slow.max() < _ORDER,
        ),
    ]


def _outcome_checks(dataset: xr.Dataset, viscous: xr.Dataset) -> list[Check]:
    """Check that impacts stop the screw in both paradoxes, and the chapter's formula of the velocity lost."""
    stops = viscous.stop_time.values[~named(dataset.region, "cycle")]
    stiff = dataset.isel(contact_stiffness=dataset.contact_stiffness.values >= float(dataset.fit_from))
    stands, time = named(stiff.indeterminate_event, "stick"), stiff.indeterminate_time.values[:, 0]
    error = np.abs(np.stack([stiff.formula_velocity, stiff.formula_velocity_limit]) - 1)
    return [
        Check.everywhere(
            "From every state without a solution the impact of a compliant contact brings the screw to a stand",
            "Sect. 8.2",
            np.isfinite(stops),
            "impacts",
        ),
        Check.holds(
            "Between two solutions, too, N > 0 grows until the screw stands, the sooner the stiffer the contact, if N "
            "is beyond the saddle",
            "Sects 8.2, 8.9",
            f"{stands[:, 0].sum()} of {stands[:, 0].size} contacts, {time[..., -1].max():.1e} s with the stiffest",
            stands[:, 0].all() and (np.diff(time) < 0).all(),
        ),
        Check.holds(
            "Short of the saddle the contact changes over to law − while the screw turns on",
            "Sect. 8.2, Fig. 8.1",
            f"{(~stands[:, 1]).sum()} of {stands[:, 1].size} contacts",
            named(stiff.indeterminate_event, "contact reversal")[:, 1].all(),
        ),
        Check.holds(
            "The velocity lost in an impact tends to that of the chapter's formula, and of its limit κ e^(ω̄ Δt) / ω̄",
            "Sect. 8.2",
            f"off by {error[0, -1]:.1e} and {error[1, -1]:.1e} with the stiffest contact",
            (np.diff(error) < 0).all() and error[:, -1].max() < 0.05,
        ),
    ]


def _by_first_rule(values: xr.DataArray) -> xr.DataArray:
    return values.isel(rule=0) if "rule" in values.dims else values


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw (a) the viscous limit, (b) its orders and (c) the others branch by branch; (d) to (f) over the stiffness."""
    figure = style.new_figure(style.DOUBLE, 8.6)
    branches, curves = figure.subfigures(2, 1, height_ratios=(2.7, 1))
    columns = branches.subplots(3, 1, sharex=True, height_ratios=(1.4, 1, 1))
    panels, families = curves.subplots(1, 3), _families(dataset)
    _distances(columns[0], families[_VISCOUS])
    _orders(columns[1], families[_VISCOUS])
    _others(columns[2], families)
    for axes in columns:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), handletextpad=0.3)
    _name_branches(columns, dataset)
    _errors(panels[0], families[_VISCOUS])
    _rests(panels[1], families)
    _rebound(panels[2], families)
    for axes in panels:
        axes.set(xscale="log", yscale="log", xlabel="Contact stiffness $k_c$ [N m⁻¹]")
        axes.set_xlim(float(dataset.contact_stiffness[0]), float(dataset.contact_stiffness[-1]))
    return figure


def _distances(axes: style.Axes, viscous: xr.Dataset) -> None:
    """A column for each branch: the softest contact on top, the stiffest below; crosses where the rules differ."""
    from matplotlib import colormaps

    shades = colormaps["Blues"](np.linspace(0.15, 1, viscous.sizes["contact_stiffness"]))
    for stiffness, distance, colour in zip(viscous.contact_stiffness, viscous.motion_distance[..., 0].T, shades,
                                           strict=True):  # fmt: skip
        axes.plot(viscous.branch, distance, "o", color=colour, mec=style.BLUE, mew=0.4, markersize=3.2,
                  label=f"$k_c$ = {style.number(stiffness)} N m⁻¹")  # fmt: skip
    differ = viscous.rules_differ == 1
    axes.plot(viscous.branch[differ], viscous.motion_distance[:, -1, 1][differ], "x", color=style.VERMILION,
              markersize=4.5, label="stiffest contact against\nthe other rule, at once")  # fmt: skip
    axes.set(yscale="log", ylabel="Distance to the\nrigid motion")
    axes.set_title("(a) viscous limit, each column a branch", pad=25)


def _orders(axes: style.Axes, viscous: xr.Dataset) -> None:
    """Fitted orders with their standard errors, branch by branch."""
    for k, (name, (colour, words, mark)) in enumerate(_ERRORS.items()):
        order, error = (_by_first_rule(viscous[f"{name}_{what}"]) for what in ("order", "order_error"))
        axes.errorbar(viscous.branch + 0.18 * (k - 1.5), order, error, color=colour, fmt=mark, markersize=2.5,
                      linewidth=0.6, label=words)  # fmt: skip
    axes.set(title="(b) viscous limit, fitted orders", ylabel="Order in $1/k_c$")


def _others(axes: style.Axes, families: dict[str, xr.Dataset]) -> None:
    """Distances at the stiffest contact in the three families."""
    for name, (colour, mark) in _FAMILIES.items():
        words, family = name.replace("damping", "fixed damping"), families[name]
        axes.plot(family.branch, family.motion_distance[:, -1, 0], mark, color=colour, markersize=3.2, label=words)
    stiffest = style.number(families[_VISCOUS].contact_stiffness[-1])
    axes.set(yscale="log", title=f"(c) three limits at $k_c$ = {stiffest} N m⁻¹")
    axes.set_ylabel("Distance to the\nrigid motion")


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
        for place in changes:
            axes.axvline(place - 0.5, color=style.GREY, linewidth=0.6)
        axes.set_xlim(-0.7, count - 0.3)
        axes.tick_params(axis="x", length=0)
    for start, stop in pairwise([0, *changes, count]):
        force, damping = (style.number(value) for value in drives[:, start])
        columns[0].text((start + stop - 1) / 2, 1.02, f"$R$ = {force} N\n$c$ = {damping}", ha="center", va="bottom",
                        fontsize=7.5, transform=columns[0].get_xaxis_transform())  # fmt: skip


def _errors(axes: style.Axes, viscous: xr.Dataset) -> None:
    """Range over the branches of each error, and a triangle of order one."""
    for name, (colour, _, mark) in _ERRORS.items():
        values = np.abs(_by_first_rule(viscous[name]))
        values = values / viscous.rigid_duration if name == "rest_error" else values
        values = values.where(values > 0)
        low, middle, high = values.min("branch"), values.median("branch"), values.max("branch")
        axes.fill_between(viscous.contact_stiffness, low, high, color=colour, alpha=0.18, linewidth=0)
        axes.plot(viscous.contact_stiffness, middle, mark + "-", color=colour, linewidth=1.0, markersize=2.5)
    right = float(viscous.contact_stiffness[-1]) / 2
    left = right / 100
    axes.plot([left, right], [1, 0.01], color=style.BLACK, linewidth=0.7, zorder=3)
    axes.text(left, 1, "order 1 ", ha="right", va="center", fontsize=6.5)
    axes.set(title="(d) viscous limit: median, range", ylabel="Relative error")
    axes.text(0.04, 0.04, "colours and marks of (b)", fontsize=6.5, transform=axes.transAxes)


def _rests(axes: style.Axes, families: dict[str, xr.Dataset]) -> None:
    """Range over the branches of the number of rests after an impact."""
    for name, (colour, mark) in reversed(_FAMILIES.items()):
        stiffness, rests = families[name].contact_stiffness, families[name].rests[families[name].impact_sign != 0]
        ends = rests.where(rests > 0).min("branch"), rests.where(rests > 0).max("branch")
        axes.fill_between(stiffness, *ends, color=colour, alpha=0.18, linewidth=0)
        for end in ends:
            axes.plot(stiffness, end, mark + "-", color=colour, linewidth=0.8, markersize=2.5)
    axes.set(title="(e) rests after an impact: range", ylabel="Number of rests")


def _rebound(axes: style.Axes, families: dict[str, xr.Dataset]) -> None:
    for name in ("damping ratio", _VISCOUS):
        family, (colour, mark) = families[name], _FAMILIES[name]
        axes.plot(family.contact_stiffness, family.rebound_force, mark + "-", color=colour, markersize=2.5)
    forces = np.unique(np.abs(families[_VISCOUS].axial_force.values))
    for force in forces:
        axes.axhline(force, color=style.BLACK, linewidth=0.7, linestyle=":")
    words = " and ".join(f"{force:g}" for force in forces)
    axes.annotate(f"$|R|$ = {words} N", (0.03, forces[-1]), (0, 3), xycoords=axes.get_yaxis_transform(),
                  textcoords="offset points", fontsize=6.5)  # fmt: skip
    axes.set(title="(f) force of the rebound", ylabel="Force [N]")
