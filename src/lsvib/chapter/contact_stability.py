"""Critical mass with compliant threads against contact damping and stiffness, and the growth rates of Lemma 8.1."""

from typing import Any

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import spans
from lsvib.answers.attributes import CRITICAL_MASS, Variables, drive_parameters, origin_of, variable, varied, yes_no
from lsvib.chapter import newton, printed_laws
from lsvib.chapter import settings as of
from lsvib.chapter.checks import Check, each, every, near, never
from lsvib.chapter.common import CRITICAL_MASS_WITH_CONTACT, about, critical_mass_with_contact
from lsvib.drives import chapter
from lsvib.drives.drive import Drive
from lsvib.errors import InputError
from lsvib.pictures import style
from lsvib.stability.boundaries import place_values, stable_set
from lsvib.stability.conditions import least_damping_of_stiff_contact, unstable_contact_stiffness
from lsvib.stability.spectrum import eigenvalues, margins, polynomial

CAPTION = """\
Stability of steady sliding with compliant threads (drive of Table 8.1, force in the direction of motion, assumed
contacts): (a) critical mass against contact damping for several contact stiffnesses, with gaps where none exists, and
for the contacts of Figs 8.10 and 8.13; (b) growth rate above the critical mass of the rigid drive, where steady sliding
is unstable beyond the dotted stiffnesses at any damping (Lemma 8.1); (c) growth rate below it, where an elastic contact
is unstable although the rigid drive is stable; (d) stable contact dampings, in two intervals for soft contacts. See
docs/lemmas.md.
"""

_CONTACT = ("contact_stiffness", "contact_damping")
_LARGEST_MASS = 1e9  # kg, the end of the range of the mass
_NEAR = 1e-6  # relative distance from a critical mass at which LAPACK must see the change
_BESIDE = np.array([1 - _NEAR, 1 + _NEAR])
_COLOURS = (style.VERMILION, style.ORANGE, style.BLUE, style.BLACK, style.GREEN, style.PURPLE)
# Where two lines coincide both are seen, and in grey they differ.
_DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (3, 1, 1, 1)), (0, (8, 2)), "-", (0, (5, 1.5)))


class Settings(of.DriveFigure):
    unused = ("mass",)
    engine = ()

    stiffnesses: list[of.Stiffness] = of.several(1, 6, "Contact stiffnesses k_c of the curves [N/m].")
    contact_damping: of.PositiveSpan = Field(description="c_c [N s/m] along the curves, spaced logarithmically.")
    contacts: list[of.Contact] = of.several(2, 5, "Contacts that figures draw, the stiffest first.")
    masses: of.MassPair = Field(description="Masses above and below the critical mass of the rigid drive [kg].")
    stiffness: of.PositiveSpan = Field(description="k_c [N/m] of the growth rates, spaced logarithmically.")
    dampings: list[of.ContactDamping] = of.several(
        2, 5, "Contact dampings of the growth rates, the first zero [N s/m]."
    )


def build(settings: of.Values) -> xr.Dataset:
    """Compute critical masses over the contact, and growth rates over its stiffness; c_x = 0, R Ω > 0."""
    drive = Drive.of(chapter.PARTS["threads"] | settings["drive"])
    rigid, (heavy, light) = [*place_values(drive, "kinematic_constraint", "mass"), 0.0][0], settings["masses"]
    if not light < rigid < heavy:
        raise InputError(f"masses = {[heavy, light]} do not lie above and below the critical mass of the rigid drive.")
    along, stiffness = (spans.logarithmic(settings[name]) for name in ("contact_damping", "stiffness"))
    curves, dampings = np.array(settings["stiffnesses"], float), np.array(settings["dampings"], float)
    contacts = [drive.replace(**contact) for contact in settings["contacts"]]
    critical = [critical_mass_with_contact(d) for d in contacts]
    return xr.Dataset(
        _curves(drive, curves, along)
        | {"critical_mass_with_contact": variable("contact", critical, *CRITICAL_MASS_WITH_CONTACT)}
        | _growth_rates(drive, heavy, light, dampings, stiffness),
        coords={
            **varied(curve_contact_stiffness=curves, curve_contact_damping=along),
            **drive_parameters(
                contacts,
                "contact",
                along=_CONTACT,
                axes=("mass",),
                printed=("Sect. 8.6", "Sect. 8.6.1"),
                no_effect=("axial_force", "input_speed"),
            ),
            **varied("mass", origin_of("mass", [heavy, light], ("Sect. 8.6.1",)), mass=[heavy, light]),
            **varied(growth_contact_damping=dampings, growth_contact_stiffness=stiffness),
            "critical_mass": ((), rigid, CRITICAL_MASS),
        },
        attrs=about(
            __doc__,
            "characteristic polynomial in rational numbers, eigenvalues by LAPACK",
            "Lemma 8.1, Sects 8.2, 8.6.1; docs/lemmas.md",
            comment="R Omega > 0",
        ),
    )


def _curves(drive: Drive, curves: np.ndarray, along: np.ndarray) -> Variables:
    """Masses between which steady sliding is stable, over contact stiffness k_c [N/m] and damping c_c [N s/m]."""
    contacts = [[drive.replace(contact_stiffness=float(k), contact_damping=float(c)) for c in along] for k in curves]
    found = [[stable_set(contact, "mass").intervals for contact in row] for row in contacts]  # type: ignore[union-attr]
    grid = np.array([[float(stable[0][1]) if stable else np.nan for stable in row] for row in found])
    again = np.array([[float(stable[1][0]) if len(stable) > 1 else np.nan for stable in row] for row in found])
    dims, whole = ("curve_contact_stiffness", "curve_contact_damping"), grid >= _LARGEST_MASS
    words, lost = "mass above which steady sliding is stable again, if any", ~whole & np.isfinite(grid)
    return {
        "curve_critical_mass_with_contact": variable(dims, np.where(lost, grid, np.nan), *CRITICAL_MASS_WITH_CONTACT),
        "stable_again": variable(dims, again, "kg", words),
        "stable_at_every_mass": yes_no(dims, whole, "steady sliding is stable at every mass"),
    }


def _growth_rates(drive: Drive, heavy: float, light: float, dampings: np.ndarray, stiffness: np.ndarray) -> Variables:
    """Growth rates of two masses [kg] over the contact stiffness, and where Lemma 8.1 and damping decide."""
    drives = [[drive.replace(mass=m, contact_damping=c) for c in dampings] for m in (heavy, light)]
    growth = [[_largest_real_part(dict(d), contact_stiffness=stiffness) for d in row] for row in drives]
    stable = [stable_set(drive.replace(mass=light, contact_stiffness=k), "contact_damping") for k in stiffness]
    dampings_of = [[(float(a), float(b)) for a, b in found.intervals] for found in stable]  # type: ignore[union-attr]
    window = np.array([row[0] if len(row) > 1 else (np.nan, np.nan) for row in dampings_of])
    above = [unstable_contact_stiffness(d) for d in drives[0]]
    limit = least_damping_of_stiff_contact(drive.replace(mass=light))
    damping, stiff = "growth_contact_damping", "growth_contact_stiffness"
    largest, proved = "largest real part of the eigenvalues", "contact stiffness beyond which Lemma 8.1 is proved"
    enough = "contact damping above which the smaller mass is always stable"
    fewer = "ends of an interval of smaller contact dampings at which it is also stable"
    of_stiff = "limit of the least contact damping for a stiff contact"
    return {
        "growth_rate": variable(("mass", damping, stiff), growth, "s-1", largest, r"max Re $s$"),
        "unstable_contact_stiffness": variable(damping, above, "N m-1", proved, "$k_c$"),
        "least_contact_damping": variable(stiff, [row[-1][0] for row in dampings_of], "N s m-1", enough, "$c_c$"),
        "least_contact_damping_of_stiff_contact": variable((), limit, "N s m-1", of_stiff, "$c_c$"),
        "window_of_soft_contact": variable((stiff, "end"), window, "N s m-1", fewer, "$c_c$"),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the critical masses against eigenvalues and the rigid one, Lemma 8.1 and its converse."""
    drive, exceptions = newton.parameters(dataset), []
    for one in dataset.growth_rate.stack(contact=dataset.growth_rate.dims).transpose("contact"):
        m, c, k = one.contact.item()
        exceptions.append(_surely_stable(drive, mass=m, contact_damping=c, contact_stiffness=k) != bool(one < 0))
    return [
        *_critical_mass_checks(dataset, drive),
        *_lemma_checks(dataset, drive),
        Check.that("contact_stability.signs", exceptions=never(exceptions)),
    ]


def _surely_stable(drive: of.Values, **contact: float) -> bool:
    """Whether steady sliding is stable, by the Routh-Hurwitz conditions in 50 digits."""
    return all(x > 0 for x in margins(polynomial(Drive.of(drive, **contact).exact(), law=1), neutral=False))


def crossing(drive: of.Values, mass: np.ndarray, contacts: of.Values) -> np.ndarray:
    """Return LAPACK's largest real parts [1/s] just below and above masses [kg] (..., 2), each with its contact."""
    beside = {name: np.asarray(value)[..., None] for name, value in contacts.items()}
    return _largest_real_part(drive, mass=np.asarray(mass)[..., None] * _BESIDE, **beside)


def _critical_mass_checks(dataset: xr.Dataset, drive: of.Values) -> list[Check]:
    """Check the critical masses of the contacts that are drawn, and that all but soft ones lie below the rigid one.

    By LAPACK these masses, and the ends of the intervals of dampings at which a contact is stable, of soft ones two.
    """
    rigid, own = float(dataset.critical_mass), dataset.critical_mass_with_contact.values
    sides = crossing(drive, own, {name: dataset[name].values for name in _CONTACT})
    told = {"sides": [f"{a:.2e} and {b:.2e}" for a, b in sides], "beside": _NEAR}
    masses, every_mass = dataset.curve_critical_mass_with_contact, dataset.stable_at_every_mass.values == 1
    lost, again = np.isfinite(masses).values, np.isfinite(dataset.stable_again.values)
    softest = float(dataset.curve_contact_stiffness.values[(every_mass | again).any(axis=1)].max(initial=0.0))
    contacts = np.meshgrid(*(dataset[f"curve_{name}"].values for name in _CONTACT), indexing="ij")
    loses, regains = (
        crossing(drive, found.values[where], dict(zip(_CONTACT, (x[where] for x in contacts), strict=True))) > 0
        for found, where in ((masses, lost), (dataset.stable_again, again))
    )
    swept = {"lost": lost, "masses": masses, "every": every_mass, "again": again, "softest": softest}

    stiffness, least = dataset.growth_contact_stiffness.values, dataset.least_contact_damping.values[:, None]
    soft = np.isfinite(dataset.window_of_soft_contact.values).all(axis=1)
    low, high = np.split(dataset.window_of_soft_contact.values[soft], 2, axis=1)

    def grows(k: np.ndarray, dampings: np.ndarray) -> np.ndarray:
        light = {**drive, "mass": float(dataset.mass[1])}
        return _largest_real_part(light, contact_stiffness=k[:, None], contact_damping=dampings) > 0

    around = np.hstack([low * _BESIDE, np.sqrt(low * high), high * _BESIDE])
    both = {"softest": stiffness[soft].max(initial=0.0), "beside": _NEAR}
    return [
        Check.that("contact_stability.drawn", steps=each(np.diff(own), "<", 0), stiffest=each(own[0], "<", rigid),
                   closed_form=near(rigid, printed_laws.critical_mass(dataset), 1e-12), masses=own, rigid=rigid),
        Check.that("contact_stability.crossing", crossings=every((sides > 0) == [False, True]), **told),
        Check.that("contact_stability.sweep", below=each(masses.values[~every_mass], "<", rigid),
                   soft=each(softest, "<", dataset.unstable_contact_stiffness[0]),
                   crossings=every(loses == [False, True]), crossings_back=every(regains == [True, False]), **swept),
        Check.that("contact_stability.soft", ends=every(grows(stiffness, least * _BESIDE) == [True, False]),
                   windows=every(grows(stiffness[soft], around) == [True, False, False, False, True]), **both),
    ]  # fmt: skip


def _lemma_checks(dataset: xr.Dataset, drive: of.Values) -> list[Check]:
    """Check Lemma 8.1 on the larger mass, and on the smaller one that its converse needs contact damping.

    The larger is unstable with a stiff contact; how fast it then grows. How much damping the smaller one needs.
    """
    heavy, light = dataset.growth_rate
    inertia_of_heavy, inertia_of_light = (printed_laws.inertia(dataset.isel(mass=k), 1) for k in (0, 1))
    beyond = (dataset.growth_contact_stiffness > dataset.unstable_contact_stiffness).transpose(*heavy.dims)
    beta = np.cos(dataset.lead_angle) * printed_laws.lever(dataset, 1)
    scale = float(-beta * inertia_of_heavy / (dataset.screw_inertia * dataset.mass[0]))
    last = float(dataset.growth_contact_stiffness[-1])
    half = scale * dataset.growth_contact_damping.values / 2
    ratio = heavy.values[:, -1] / (half + np.sqrt(half**2 + scale * last))
    contacts = {**drive, "mass": float(dataset.mass[0]), "contact_damping": dataset.growth_contact_damping.values}
    places = (0.0, dataset.unstable_contact_stiffness.values)
    none, left = (polynomial({**contacts, "contact_stiffness": k}, law=1)[2] for k in places)
    limit = float(dataset.support_damping / 2 * (1 / inertia_of_light - 1 / dataset.screw_inertia))
    elastic, least = light.values[0], dataset.least_contact_damping
    bound, enough = dataset.least_contact_damping_of_stiff_contact, dataset.growth_contact_damping > least
    stiff = {"mass": float(dataset.mass[1]), "contact_stiffness": 1e14}
    sides = [_surely_stable(drive, contact_damping=float(bound) * part, **stiff) for part in (0.999, 1.001)]
    return [
        Check.that("contact_stability.proof", part=each(abs(left / none), "<", 1e-9)),
        Check.that("contact_stability.unstable", contacts=each(heavy.values[beyond.values], ">", 0), from_on=places[1],
                   dampings=every(beyond.any("growth_contact_stiffness")), mass=dataset.mass[0]),
        Check.that("contact_stability.growth", ratio=near(ratio, 1, 0.01), ratios=ratio, stiffest=last,
                   rise=each(np.diff(heavy.values[:, -3:]), ">", 0), mass=dataset.mass[0]),
        Check.that("contact_stability.elastic", least=each(elastic, ">", 0), last=near(elastic[-1], limit, 0.01),
                   rate=elastic, limit=limit, mass=dataset.mass[1]),
        Check.that("contact_stability.damped", contacts=each(light.values[enough.values], "<", 0),
                   limit=near(least[-1], bound, 0.01), stiff_contacts=every(np.array(sides) == [False, True]),
                   least=least, bound=bound, mass=dataset.mass[1]),
    ]  # fmt: skip


def _largest_real_part(drive: of.Values, **values: Any) -> np.ndarray:
    """Largest real part [1/s] of LAPACK's eigenvalues, for arrays of parameters."""
    return eigenvalues({**drive, **values}, law=1)[..., -1].real


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw (a) the critical mass, (b, c) the growth rate of both masses and (d) the least contact damping.

    Beyond the dotted stiffnesses of (b), one for each damping, the proof of Lemma 8.1 holds.
    """
    figure = style.new_figure(style.DOUBLE, 6.2)
    mass, heavy, light, least = figure.subplots(2, 2).ravel()
    rigid, damping = float(dataset.critical_mass), dataset.curve_contact_damping
    for curve, colour, dashes in zip(dataset.curve_critical_mass_with_contact, _COLOURS, _DASHES, strict=False):
        name = f"$k_c$ = {style.number(curve.curve_contact_stiffness)} N m⁻¹"
        mass.plot(damping, curve, color=colour, linestyle=dashes, label=name)
    mass.plot(dataset.contact_damping, dataset.critical_mass_with_contact, "o", color=style.PURPLE, zorder=4,
              label="contacts of Figs 8.10, 8.13")  # fmt: skip
    for one in dataset.critical_mass_with_contact:
        place = float(one.contact_damping), float(one)
        mass.annotate(f"{float(one):.2f} kg", place, (0, -12), textcoords="offset points", fontsize=6.5)
    mass.axhline(rigid, color=style.GREY, linewidth=0.9, linestyle="--", label=f"rigid contact: {rigid:.3f} kg")
    style.frame(mass, "(a) critical mass; unstable above", damping, "Critical mass $m_\\mathrm{cr}$ [kg]",
                xscale="log", ylim=(0, 2 * rigid))  # fmt: skip
    mass.legend(loc="upper left")
    for axes, letter, rates in zip((heavy, light), "bc", dataset.growth_rate, strict=True):
        stiffness, sign = rates.growth_contact_stiffness, ">" if float(rates.mass) > rigid else "<"
        axes.set_yscale("symlog", linthresh=10.0)
        for curve, colour, dashes in zip(rates, _COLOURS, _DASHES, strict=False):
            name = f"$c_c$ = {style.number(curve.growth_contact_damping)} N s m⁻¹"
            axes.plot(stiffness, curve, color=colour, linestyle=dashes, label=name)
        axes.axhline(0, color=style.BLACK, linewidth=0.5)
        title = f"({letter}) growth rate, $m$ = {style.number(rates.mass)} kg {sign} rigid $m_\\mathrm{{cr}}$"
        style.frame(axes, title, stiffness, "Largest real part [s⁻¹], stable below 0", xscale="log")
    for value, colour in zip(dataset.unstable_contact_stiffness.values, _COLOURS, strict=False):
        heavy.axvline(value, color=colour, linewidth=0.9, linestyle=":")
    words = "colours as in (c);\nbeyond dotted line:\nunstable by\nLemma 8.1"
    heavy.text(0.03, 0.7, words, fontsize=6.5, transform=heavy.transAxes)
    light.legend(loc="lower left")
    _least(least, dataset)
    return figure


def _least(axes: style.Axes, dataset: xr.Dataset) -> None:
    stiffness, least = dataset.growth_contact_stiffness, dataset.least_contact_damping
    top, shade = 100 * float(least.max()), dict[str, Any](color=style.SKY, alpha=0.3, linewidth=0)
    low, high = dataset.window_of_soft_contact.values.T
    axes.fill_between(stiffness, least, top, **shade)
    axes.fill_between(stiffness, low, high, **shade)
    for end in (least, low, high):
        axes.plot(stiffness, end, color=style.BLUE)
    limit = float(dataset.least_contact_damping_of_stiff_contact)
    axes.axhline(limit, color=style.GREY, linewidth=0.9, linestyle="--", label=f"stiff limit: {limit:.5g} N s m⁻¹")
    axes.legend(loc="lower right")
    axes.text(0.6, 0.92, "stable", transform=axes.transAxes, va="center")
    axes.text(0.6, 0.45, "unstable", transform=axes.transAxes, va="center")
    title = f"(d) contact damping at which $m$ = {style.number(dataset.mass[1])} kg is stable"
    style.frame(axes, title, stiffness, dataset.contact_damping, xscale="log", yscale="log", ylim=(None, top))
