"""The limit process: convergence of the drive with compliant threads to the rigid one, on every branch of the rule."""

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Any

import numpy as np
import xarray as xr

from lsvib.contact import stiff_limit
from lsvib.contact.stiff_limit import BranchFamily, ImpactOutcome, LimitBranch, Region
from lsvib.datasets import phase_plane
from lsvib.datasets.attributes import (
    SIGNS,
    VARIED,
    attributes,
    axis,
    drive_parameters,
    flagged,
    parameter,
    start_state,
    variable,
    yes_no,
)
from lsvib.datasets.checks import Check
from lsvib.models.drive import RigidDrive
from lsvib.models.model import RULES

_CONVERGED = 1e-3  # deviation at the stiffest contact, relative to the motion: nothing that a picture shows
_ORDER = 0.8  # of convergence, at least: the first order shows as 0.86 to 0.94 at stiffnesses that are finite
_FAR = 0.01  # deviation that a limit which is not the rigid drive leaves: ten times what counts as converged
_APART = 10.0  # so many times smaller a deviation tells one rule from the other
_QUANTITIES = {
    "motion_distance": ("1", "distance of the motion from the rigid one in the phase plane"),
    "rest_error": ("s", "time at rest less that of the rigid motion"),
    "impulse_error": ("1", "relative error of the normal impulse of the impact"),
    "period_error": ("1", "relative error of the period"),
    "rests": ("1", "number of rests"),
    "stop_time": ("s", "time that an impact takes, until the screw first stands"),
}
_BY_RULE = ("motion_distance", "rest_error", "period_error")


class BranchVerdict(IntEnum):
    """Which rule of resuming the motion follows as the contact stiffens."""

    NEITHER = 0
    CONTACT_SIGN = 1
    AT_ONCE = 2
    BOTH = 3  # the rules agree on the branch, or are not distinguished


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the deviations from the rigid drive over the stiffness, for each family of contacts and each branch.

    ``settings``: see ``Settings``; Γ₊ < 0, c_x = 0; the pairs of forces and dampings are the drives, ``start`` is that
    of the cycles, ``duration`` that of the motions after impacts. Raises ``InputError``.
    """
    stiffness = np.array(settings["stiffness"], dtype=float)
    base = RigidDrive.of(settings["drive"])
    drives = [
        base.replace(axial_force=r, support_damping=c)
        for r in settings["axial_forces"]
        for c in settings["support_dampings"]
    ]
    start, speed, ratio = settings["start"], settings["speed"], settings["damping_ratio"]
    branches = [
        branch
        for drive in drives
        for branch in stiff_limit.branches(drive, speed, settings["duration"], [start["u"], start["w"]])
    ]
    stiffened = [[stiff_limit.stiffened(drives[0], family, k, ratio) for k in stiffness] for family in BranchFamily]
    damping = [[drive.contact_damping for drive in row] for row in stiffened]
    deviations = _deviations(branches, stiffness, ratio, settings["fit_from"])
    return xr.Dataset(
        deviations
        | {
            "rebound_force": variable(
                ("family", "contact_stiffness"),
                [[stiff_limit.rebound_force(drive, speed) for drive in row] for row in stiffened],
                "N",
                "force with which the contact throws the nut back",
            )
        }
        | _rules_followed(branches, deviations),
        coords={
            "family": flagged("family", BranchFamily, "how the damping of the contact grows", BranchFamily),
            **axis("contact_stiffness", stiffness),
            "contact_damping": (("family", "contact_stiffness"), damping, parameter("contact_damping", VARIED)),
            **phase_plane.rule_coordinate(),
            **_branch_coordinates(branches),
            **drive_parameters(
                [b.drive for b in branches], "branch", along=("axial_force", "support_damping"), printed=("Sect. 8.6",)
            ),
            **start_state(start, "of the cycles"),
            "impact_speed": variable((), speed, "rad s-1", "screw speed before a seizure", r"$\dot\theta$"),
            "nut_damping_ratio": variable((), ratio, "1", "damping ratio of the nut", r"$\zeta$"),
            "fit_from": variable((), settings["fit_from"], "N m-1", "least stiffness that orders are fitted to"),
        },
        attrs={
            "title": "The limit process: convergence of compliant threads to the rigid drive",
            "source": "lsvib, exact event-driven motion of both models",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sects 8.2, 8.6; docs/limit_process.md",
        },
    )


def _deviations(
    branches: Sequence[LimitBranch], stiffness: np.ndarray, ratio: float, fit_from: float
) -> phase_plane.Variables:
    """Deviations from the rigid drive, by family, branch and contact stiffness [N/m], and the orders of their fall.

    ``ratio``: the damping ratio [1] of its family; ``fit_from`` [N/m]: the least stiffness that orders are fitted to.
    """
    size = (len(BranchFamily), len(branches), stiffness.size)
    found = {name: np.full((*size, len(RULES)) if name in _BY_RULE else size, np.nan) for name in _QUANTITIES}
    for family in BranchFamily:
        for j, k in enumerate(stiffness):
            for i, branch in enumerate(branches):
                compliant = stiff_limit.stiffened(branch.drive, family, k, ratio)
                for name, value in stiff_limit.deviations(branch, compliant).items():
                    found[name][family, i, j] = value
    variables = {name: variable(_dims(name), found[name], *_QUANTITIES[name]) for name in _QUANTITIES}
    fitted = stiffness >= fit_from
    for name in ("motion_distance", "rest_error", "impulse_error", "period_error", "stop_time"):
        variables |= _orders(name, stiffness[fitted], found[name][:, :, fitted])
    return variables


def _rules_followed(branches: Sequence[LimitBranch], deviations: phase_plane.Variables) -> phase_plane.Variables:
    """The rule of resuming that the motions on each branch follow, and how long its rigid motion lasts."""
    durations = np.array([branch.rigid[0].end_time for branch in branches])
    return {
        "rigid_duration": variable("branch", durations, "s", "duration of the rigid motion, a period for a cycle"),
        "rule_followed": flagged(
            ("family", "branch"),
            _verdicts(branches, deviations, durations),
            "rule that the motion follows",
            BranchVerdict,
        ),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the orders in the viscous limit, the rule that each branch follows, and that the elastic limit differs."""
    viscous, ratio, elastic = (dataset.sel(family=int(family)) for family in BranchFamily)
    impact = dataset.region.values != Region.CYCLE
    return [
        *_viscous_checks(viscous),
        _stop_time_check(dataset, impact),
        *_elastic_checks(elastic, viscous, impact),
        _damping_ratio_check(ratio, viscous, impact),
    ]


def _viscous_checks(viscous: xr.Dataset) -> list[Check]:
    """Check that contacts whose damping grows with their stiffness tend to the rigid drive, and by which rule."""
    follows = np.isin(viscous.rule_followed.values, [BranchVerdict.CONTACT_SIGN, BranchVerdict.BOTH])
    order = viscous.motion_distance_order.values[:, 0]
    closest = viscous.motion_distance.values[:, -1, 0].max()
    differ = viscous.rules_differ.values == 1
    told = viscous.rule_followed.values == BranchVerdict.CONTACT_SIGN
    others = {
        name: viscous[f"{name}_order"].values[..., 0] if name in _BY_RULE else viscous[f"{name}_order"].values
        for name in ("rest_error", "impulse_error", "period_error")
    }
    return [
        Check.holds(
            "Viscous limit: on every branch the motion converges to the rigid one under the rule contact_sign, its "
            f"distance with an order of at least {_ORDER:g}",
            "Sect. 8.2, rule of resuming",
            f"{int(follows.sum())} of {follows.size} branches, distance at most "
            f"{closest:.1e} at k_c = c_c = {float(viscous.contact_stiffness[-1]):.0e}, "
            f"orders {order.min():.3f} to {order.max():.3f}, standard errors up to "
            f"{viscous.motion_distance_order_error.values[:, 0].max():.3f}",
            bool(follows.all()),
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
            f"{int((told & differ).sum())} of {int(differ.sum())} branches; distance or rest under at_once stays",
            bool(told[differ].all() and differ.any()),
        ),
    ]


def _stop_time_check(dataset: xr.Dataset, impact: np.ndarray) -> Check:
    """Check that impacts, the branches ``impact``, become instants as the contact stiffens in any of the three ways."""
    stops = dataset.stop_time.values[:, impact]
    brief = dataset.stop_time_order.sel(family=int(BranchFamily.VISCOUS)).values[impact]
    fitted = dataset.contact_stiffness.values >= float(dataset.fit_from)
    return Check.holds(
        "The time that an impact takes tends to zero: it falls from each fitted stiffness to the next in every "
        f"family, in the viscous limit with an order of at least {_ORDER:g}",
        "Sect. 8.2",
        f"viscous orders {brief.min():.3f} to {brief.max():.3f}; at most "
        f"{', '.join(f'{x:.1e}' for x in stops[..., -1].max(axis=1))} s by family at k_c = "
        f"{float(dataset.contact_stiffness[-1]):.0e} N/m",
        bool((np.diff(stops[..., fitted], axis=-1) < 0).all() and brief.min() >= _ORDER),
    )


def _elastic_checks(elastic: xr.Dataset, viscous: xr.Dataset, impact: np.ndarray) -> list[Check]:
    """Check that contacts without damping tend to no rigid motion, and rest in another way after an impact."""
    lost = int((elastic.rule_followed.values == BranchVerdict.NEITHER).sum())
    nearest = float(np.nanmin(elastic.motion_distance.values[:, -1, 0]))
    rests, rigid_rests = elastic.rests.values[:, -1], viscous.rests.values[:, -1]
    return [
        Check.holds(
            "Elastic limit: on no branch does the motion converge to the rigid one under either rule",
            "limit process",
            f"{lost} of {impact.size} branches follow neither; distance at least {nearest:.2g}",
            lost == impact.size,
        ),
        Check.holds(
            "Elastic limit: after an impact the rest is a chain of short rests",
            "limit process",
            f"at k_c = {float(elastic.contact_stiffness[-1]):.0e} N/m {int(rests[impact].min())} to "
            f"{int(rests[impact].max())} rests, in the viscous limit at most {int(rigid_rests[impact].max())}",
            bool((rests[impact] > rigid_rests[impact]).all()),
        ),
    ]


def _damping_ratio_check(ratio: xr.Dataset, viscous: xr.Dataset, impact: np.ndarray) -> Check:
    """Check that contacts with a fixed damping ratio of the nut throw it back, so that they do not converge either."""
    excess, slow = ratio.impulse_error.values[impact, -1], ratio.motion_distance_order.values[:, 0]
    far = ratio.motion_distance.values[:, -1, 0]
    return Check.holds(
        "Fixed damping ratio: even an overdamped contact throws the nut back: the impulse stays too large, and the "
        "distance falls slowly or not at all",
        "limit process",
        f"zeta = {float(ratio.nut_damping_ratio):g}: impulse too large by {excess.min():.1%} to "
        f"{excess.max():.1%}, distance at least {far.min():.2g}, orders {slow.min():.2f} to "
        f"{slow.max():.2f}; force of the rebound {float(ratio.rebound_force[-1]):.3g} N, in the viscous limit "
        f"{float(viscous.rebound_force[-1]):.1e} N",
        bool((excess > _FAR).all() and (far > _FAR).all() and slow.max() < _ORDER),
    )


def _dims(name: str) -> tuple[str, ...]:
    return (
        ("family", "branch", "contact_stiffness", "rule")
        if name in _BY_RULE
        else ("family", "branch", "contact_stiffness")
    )


def _orders(name: str, stiffness: np.ndarray, errors: np.ndarray) -> phase_plane.Variables:
    fits = np.apply_along_axis(lambda error: stiff_limit.fitted_order(stiffness, error), 2, errors)
    dims = tuple(dim for dim in _dims(name) if dim != "contact_stiffness")
    words = name.replace("_", " ")
    return {
        f"{name}_order": variable(dims, fits[:, :, 0], "1", f"order of the {words} in one over the stiffness"),
        f"{name}_order_error": variable(dims, fits[:, :, 1], "1", f"standard error of the order of the {words}"),
    }


def _verdicts(branches: Sequence[LimitBranch], variables: phase_plane.Variables, durations: np.ndarray) -> np.ndarray:
    """A rule is followed if the distance falls with the order wanted and all is small at the end; the nearer wins."""
    distance, rest = variables["motion_distance"][1][:, :, -1], variables["rest_error"][1][:, :, -1]
    deviation = np.fmax(distance, np.abs(rest) / durations[:, None])
    follows = (variables["motion_distance_order"][1] >= _ORDER) & (deviation < _CONVERGED)
    follows &= deviation < _APART * deviation[..., ::-1]
    agree = np.array([not branch.differ for branch in branches])
    follows[:, agree, 1] = follows[:, agree, 0]
    return (follows[..., 0] * BranchVerdict.CONTACT_SIGN + follows[..., 1] * BranchVerdict.AT_ONCE).astype(np.int8)


def _branch_coordinates(branches: Sequence[LimitBranch]) -> phase_plane.Variables:
    hits = [b.impact for b in branches]
    signs = {key: SIGNS[key] for key in ("flag_values", "flag_meanings")}
    sign = np.array([0 if hit is None else hit.sign for hit in hits], dtype=np.int8)
    region = [Region.CYCLE if hit is None else hit.region for hit in hits]
    after = [[stiff_limit.outcome(motion) for motion in b.rigid] for b in branches]
    differ = [b.differ for b in branches]
    return {
        "branch": variable("branch", np.arange(len(branches)), "1", "index of the branch"),
        "impact_sign": ("branch", sign, attributes("1", "sign of the impact, none for a cycle", **signs)),
        "region": flagged("branch", region, "where the screw stands after the impact", Region),
        "rules_differ": yes_no("branch", differ, "the rigid motion depends on the rule of resuming"),
        "outcome_after_seizure": flagged(
            ("branch", "rule"), after, "what follows the first seizure of the rigid drive", ImpactOutcome
        ),
    }
