"""The checks of `contact_stability`: critical masses against eigenvalues, Lemma 8.1 and its converse."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from lsvib.datasets.checks import Check
from lsvib.models.drive import RigidDrive, ThreadsDrive
from lsvib.stability.linear import eigenvalues, routh_hurwitz, threads_model

_LAW = 1  # R Ω > 0
_BESIDE = 1e-6  # relative distance from a critical mass at which LAPACK must see the change
_CLOSE = 0.01  # of a limit, at the stiffest contact
_PARAMETERS = [name for name in RigidDrive.model_fields if name not in ("mass", "axial_force")]


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the critical masses against eigenvalues and the rigid one, Lemma 8.1 and its converse."""
    drive = {name: float(dataset[name]) for name in _PARAMETERS}
    return [
        *_drawn_contact_checks(dataset, drive),
        _sweep_check(dataset),
        *_lemma_checks(dataset),
        *_converse_checks(dataset),
        _soft_contact_check(dataset, drive),
        _sign_check(dataset, drive),
    ]


def _drawn_contact_checks(dataset: xr.Dataset, drive: Mapping[str, float]) -> list[Check]:
    """Check the critical masses of the contacts that are drawn: their order, and that eigenvalues cross there."""
    rigid, own = float(dataset.critical_mass), dataset.critical_mass_with_contact.values
    contacts = dataset.contact_stiffness.values, dataset.contact_damping.values
    sides = [_sides(drive, *values) for values in zip(own, *contacts, strict=True)]
    return [
        Check.holds(
            "With each contact that is drawn steady sliding is lost below the critical mass of the rigid drive, the "
            "sooner the softer the contact",
            "Sect. 8.6.1, Fig. 8.13",
            f"{', '.join(f'{x:.4g}' for x in own)} kg from the stiffest to the softest, rigid {rigid:.5g} kg",
            bool((np.diff(own) < 0).all() and own[0] < rigid),
        ),
        Check.holds(
            f"LAPACK's eigenvalues of these drives cross the imaginary axis there, within {_BESIDE:g} of the mass",
            "eq. 8.7, model of Sect. 5.5",
            f"largest real parts {', '.join(f'{a:.2e} and {b:.2e}' for a, b in sides)} 1/s",
            all(a < 0 < b for a, b in sides),
        ),
    ]


def _sweep_check(dataset: xr.Dataset) -> Check:
    """Check that the curves of the critical mass lie below that of the rigid drive, but for soft contacts."""
    rigid = float(dataset.critical_mass)
    whole, every = dataset.curve_critical_mass_with_contact.values, dataset.stable_at_every_mass.values == 1
    soft = (every | np.isfinite(dataset.stable_again.values)).any(axis=1)
    softest = float(dataset.curve_contact_stiffness.values[soft].max(initial=0.0))
    return Check.holds(
        "Every contact of the sweep loses steady sliding below the critical mass of the rigid drive, but for soft "
        "ones with little damping, which keep it at every mass or regain it at a large one",
        "model of Sect. 5.5",
        f"{int(np.isfinite(whole).sum())} of {whole.size} lose it, the last at {np.nanmax(whole):.6g} kg; "
        f"{int(every.sum())} never do, {int(np.isfinite(dataset.stable_again).sum())} regain it, k_c <= "
        f"{softest:.0e} N/m",
        bool((whole[~every] < rigid).all()) and softest < float(dataset.unstable_contact_stiffness[0]),
    )


def _lemma_checks(dataset: xr.Dataset) -> list[Check]:
    """Check Lemma 8.1 on the larger mass: it is unstable with a stiff contact, and how fast it then grows."""
    heavy = dataset.isel(mass=0)
    beyond = heavy.growth_contact_stiffness > dataset.unstable_contact_stiffness
    grows = heavy.growth_rate > 0
    stiff = heavy.growth_rate.isel(growth_contact_stiffness=-1).values
    scale, last = float(dataset.growth_scale), float(dataset.growth_contact_stiffness[-1])
    half = scale * dataset.growth_contact_damping.values / 2
    ratio = stiff / (half + np.sqrt(half**2 + scale * last))
    return [
        Check.holds(
            "Whatever the contact damping, the larger mass is unstable beyond the contact stiffness of the proof",
            "Lemma 8.1",
            f"{int((grows & beyond).sum())} of {int(beyond.sum())} contacts",
            bool(grows.where(beyond, True).all() and beyond.any("growth_contact_stiffness").all()),
        ),
        Check.holds(
            "At the stiffest contact its growth rate is the positive root of s² = b (c_c s + k_c), b = β |Γ_0| / "
            f"(I m), to {_CLOSE:.0%}, which grows without bound",
            "Lemma 8.1, docs/lemmas.md",
            f"ratios {', '.join(f'{x:.5f}' for x in ratio)} at k_c = {last:.0e} N/m",
            bool((np.abs(ratio - 1) < _CLOSE).all()),
        ),
    ]


def _converse_checks(dataset: xr.Dataset) -> list[Check]:
    """Check on the smaller mass that the converse of Lemma 8.1 needs contact damping, and how much."""
    light = dataset.isel(mass=1)
    elastic = light.growth_rate.isel(growth_contact_damping=0).values
    expected, bound = float(dataset.elastic_growth_limit), float(dataset.least_contact_damping_of_stiff_contact)
    enough = light.growth_contact_damping > light.least_contact_damping
    least = dataset.least_contact_damping.values
    return [
        Check.holds(
            "The converse fails in an elastic contact: the smaller mass, stable when rigid, flutters however stiff",
            "Lemma 8.1, docs/lemmas.md",
            f"growth rate from {elastic.min():.4g} 1/s, at the stiffest contact {elastic[-1]:.5g}, limit "
            f"{expected:.5g} 1/s",
            bool((elastic > 0).all()) and abs(elastic[-1] / expected - 1) < _CLOSE,
        ),
        Check.holds(
            f"With enough contact damping the smaller mass is stable; the least tends to its limit, to {_CLOSE:.0%}",
            "Lemma 8.1, docs/lemmas.md",
            f"{int((enough & (light.growth_rate < 0)).sum())} of {int(enough.sum())} contacts with more; "
            f"{least[-1]:.6g} against {bound:.6g} N s/m",
            bool((light.growth_rate < 0).where(enough, True).all()) and abs(least[-1] / bound - 1) < _CLOSE,
        ),
    ]


def _soft_contact_check(dataset: xr.Dataset, drive: Mapping[str, float]) -> Check:
    """Check the ends of the intervals of smaller dampings at which a soft contact is stable, too."""
    windows, ends = _windows(dataset, drive)
    softer = dataset.growth_contact_stiffness.where(np.isfinite(dataset.window_of_soft_contact[:, 0]))
    return Check.holds(
        "A soft contact has stable dampings below the least one, too: LAPACK's largest real part changes its sign "
        f"at both ends of each such interval, within {_BESIDE:g} of the damping, and is negative in its middle",
        "model of Sect. 5.5, docs/lemmas.md",
        f"{sum(windows)} of {len(windows)} contacts, k_c <= {float(softer.max()):.2e} N/m; "
        f"and at the least damping of {sum(ends)} of {len(ends)}",
        all(windows) and all(ends) and len(windows) > 0,
    )


def _sign_check(dataset: xr.Dataset, drive: Mapping[str, float]) -> Check:
    """Check the signs of the growth rates, which LAPACK computes, against conditions in 50 digits."""
    wrong, compared = _against_signs(dataset, drive)
    claim = "The signs of all growth rates are those of the Routh-Hurwitz conditions in 50 digits"
    return Check.without_exception(claim, "model of Sect. 5.5", wrong, compared, "contacts")


def _sides(drive: Mapping[str, float], mass: float, stiffness: float, damping: float) -> tuple[float, float]:
    """Largest real part [1/s] just below and just above a mass."""
    masses = mass * np.array([1 - _BESIDE, 1 + _BESIDE])
    own = {**drive, "mass": masses, "contact_stiffness": stiffness, "contact_damping": damping}
    below, above = eigenvalues(threads_model(own, _LAW))[:, -1].real
    return float(below), float(above)


def _windows(dataset: xr.Dataset, drive: Mapping[str, float]) -> tuple[list[bool], list[bool]]:
    """For each soft contact, whether its stable dampings are so by LAPACK; for each contact, the same of the least."""
    own = {**drive, "mass": float(dataset.mass[1])}
    beside = np.array([1 - _BESIDE, 1 + _BESIDE])

    def grows(stiffness: float, damping: np.ndarray) -> list[bool]:
        contact = {**own, "contact_stiffness": stiffness, "contact_damping": damping}
        return (eigenvalues(threads_model(contact, _LAW))[:, -1].real > 0).tolist()

    windows, ends = [], []
    for stiffness, (low, high), least in zip(
        *(
            dataset[name].values
            for name in ("growth_contact_stiffness", "window_of_soft_contact", "least_contact_damping")
        ),
        strict=True,
    ):
        ends.append(grows(stiffness, least * beside) == [True, False])
        if np.isfinite(low):
            around = np.concatenate([low * beside, [np.sqrt(low * high)], high * beside])
            windows.append(grows(stiffness, around) == [True, False, False, False, True])
    return windows, ends


def _against_signs(dataset: xr.Dataset, drive: Mapping[str, float]) -> tuple[int, int]:
    """Number of growth rates whose sign is not that of the exact conditions, and of all."""
    wrong = 0
    for m, own in enumerate(dataset.mass.values):
        for i, c in enumerate(dataset.growth_contact_damping.values):
            for j, k in enumerate(dataset.growth_contact_stiffness.values):
                contact = ThreadsDrive.of(drive, mass=own, contact_damping=c, contact_stiffness=k)
                stable = routh_hurwitz(threads_model(contact.exact(), _LAW).polynomial())
                wrong += stable != bool(dataset.growth_rate.values[m, i, j] < 0)
    return wrong, dataset.growth_rate.size
