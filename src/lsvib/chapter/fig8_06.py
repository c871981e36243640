"""Figure 8.6: amplitude against the axial force under negative damping, with three phase portraits.

Also the coefficients that Sect. 8.5.1 prints, for both readings of the mass: it states m = 1 kg, but prints the
effective inertias of m = 8 kg.
"""

from typing import Annotated, Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lsvib.answers import phase_plane, spans
from lsvib.answers.analysis import analyse, value
from lsvib.answers.attributes import counted, flagged, named, start_state, variable, varied, yes_no
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, each, every, near, never, quantity
from lsvib.chapter.common import about, printed, spread
from lsvib.chapter.settings import MassPair, PhasePlane, Span, State, Values, parameter, several
from lsvib.drives import chapter
from lsvib.drives.chapter import claims
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.names import MotionMode
from lsvib.pictures import drawing, style
from lsvib.words import plain

CAPTION = """\
Amplitude of the steady vibration against axial force R; below, phase portraits at three forces (insets in the chapter),
which circles mark on the curve. Vibration sets in at the onset force; the screw first stops at the stick force, and the
cycle no longer reaches N = 0 beyond the detach force.
"""

_THRESHOLDS = {"onset_force": "onset", "stick_force": "stick", "detach_force": "detach"}  # with words in the picture
_REGIMES = {  # what the drive does: colour, words, dashes
    "no vibration": (style.GREY, "no vibration", (0, (1, 0.5))),
    "pure slip": (style.BLUE, "pure-slip cycle", "-"),
    "stick slip with contact reversal": (style.ORANGE, "stick–slip, reaches $N = 0$", "-"),
    "stick slip": (style.WINE, "stick–slip, $N > 0$", (0, (2, 0.6))),
}
_INSETS = ("fig8_06.decays", "fig8_06.slips", "fig8_06.sticks")  # below the onset force, between, above the stick force
_REACHED = ("steady sliding", "other cycle", "stick slip cycle")
_READ = [f"effective_{kind}_{sign}" for kind in ("inertia", "damping") for sign in ("minus", "plus")]
_OF = {name: name.replace("_force", "_axial_force") for name in (*_READ, *_THRESHOLDS)}  # names in the analysis


class Settings(PhasePlane):
    unused = ("axial_force",)

    axial_force: Span = Field(description="R [N].")
    start: State
    insets: list[Annotated[float, parameter("axial_force")]] = several(1, 3, "Axial forces of the inset portraits [N].")
    mass_readings: MassPair = Field(
        description="Mass as stated, and mass to which the printed effective inertias belong [kg]."
    )

    @model_validator(mode="after")
    def _mass_is_read(self) -> Self:
        """Check that the mass of the drive is one of the two readings."""
        if self.drive.mass not in self.mass_readings:
            words = " and ".join(f"{mass:g}" for mass in self.mass_readings)
            raise PydanticCustomError("of_the_whole", f"has mass = {self.drive.mass:g}, none of mass_readings: {words}")
        return self


def analysis(settings: Values) -> xr.Dataset:
    """Analyse the drive for both readings of its mass: effective inertias and dampings, the three forces."""
    readings = [Drive.of(settings["drive"]).replace(mass=float(mass)) for mass in settings["mass_readings"]]
    forces = [(name, "axial_force") for name in ("onset", "stick", "detach")]
    return analyse(readings, forces, ("mass",), ("Sect. 8.5.1",))


def build(settings: Values, analysis: xr.Dataset) -> xr.Dataset:
    """Compute the amplitude curve between the thresholds of the analysis, and the inset portraits."""
    from lsvib.answers.sweep import product_of
    from lsvib.dynamics.sweep import Behaviour, behaviours

    drive = Drive.of(settings["drive"])
    masses = settings["mass_readings"]
    values = {name: value(analysis[_OF[name]], masses.index(drive.mass)) for name in _THRESHOLDS}
    # Also at a relative distance of 1e-9 on either side of a threshold.
    beside = [value * (1 + sign * 1e-9) for value in values.values() for sign in (-1, 1)]
    known = (spans.even(settings["axial_force"]), settings["insets"], list(values.values()), beside)
    forces = np.unique(np.concatenate(known))
    tangent = float(drive.exact().tan_lead)
    frictions = np.append(tangent * np.array([0.99, 1.01]), drive.friction_coefficient)
    drives = [drive.replace(axial_force=float(force)) for force in forces]
    steady = [phase_plane.reached(d, settings["start"]) for d in drives]
    insets = [drive.replace(axial_force=float(force)) for force in settings["insets"]]
    words = {name: name.replace("_", " ") for name in _THRESHOLDS}
    planes = phase_plane.portraits(settings, insets, ("axial_force",), ("Sect. 8.5.1", "Fig. 8.6")).assign_coords(
        {
            **varied(swept_axial_force=forces, swept_friction_coefficient=frictions, reading_mass=masses),
            **start_state(settings["start"], "of the motions whose steady vibration swept_amplitude describes"),
            **{name: variable((), value, "N", words[name], "$R$") for name, value in values.items()},
            **{f"printed_{n}": printed(chapter.THRESHOLDS[n], words[n]) for n in _THRESHOLDS},
        }
    )
    readings = {
        f"reading_{name}": ("reading_mass", analysis[of].values, analysis[of].attrs) for name, of in _OF.items()
    }
    holding = []
    for own in (insets[-1].replace(friction_coefficient=float(x)) for x in frictions):  # from θ′ = 0 and z = 0
        motion = phase_plane.followed(own, {"u": -float(coefficients(own).deflection), "w": -own.input_speed}, 1e-9)
        holding.append(motion.automaton.codes[motion.arcs()[0][0]] == MotionMode.REST)
    said = "the screw, at rest with an untwisted coupling, stays at rest under the largest force of a portrait"
    holds = {"holds_without_torque": yes_no("swept_friction_coefficient", holding, said)}
    _, kinds = behaviours(product_of(drives[0], {"axial_force": forces.tolist()}))
    dim, slowest = "swept_axial_force", [s.extremes(np.array([0, 1.0, 0]))[0] for s in steady]
    curve = {
        "swept_amplitude": variable(dim, [s.amplitude for s in steady], "rad", phase_plane.AMPLITUDE),
        "smallest_velocity": variable(dim, slowest, "rad s-1", "smallest rate of the deviation", r"$\dot u$"),
        "regime": flagged(dim, kinds, "what the drive does", Behaviour),
    }
    return planes.assign(curve | readings | holds).assign_attrs(
        about(__doc__, "exact event-driven motion and its return map", "Sect. 8.5.1, Fig. 8.6")
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the thresholds, the shape of the curve, where its regime changes, the insets and the coefficients.

    What the motions of a portrait reach is what the chapter says of a force, by its own printed limits.
    """
    friction, tangent = dataset.swept_friction_coefficient.values, float(np.tan(dataset.lead_angle))
    holds, force = dataset.holds_without_torque.values == 1, dataset.axial_force.values
    limits = [claims()[id].value for id in ("fig8_06.onset_force", "fig8_06.stick_force")]
    line = dataset.contact_line_angle.values[force > limits[0]]
    insets = []
    for found, inset in zip(dataset.attractor, force, strict=True):
        id, kind = (row[np.searchsorted(limits, inset)] for row in (_INSETS, _REACHED))
        told = {"names": sorted(map(plain, counted(found))), "starts": dataset.sizes["start"], "force": inset}
        insets.append(Check.that(id, motions=every(named(found, kind)), **told))
    return [
        *newton.portrait_checks(dataset, "Fig. 8.6"),
        Check.of("fig8_06.lead_tangent", tangent),
        Check.that("fig8_06.self_locking", frictions=every(holds == (friction > tangent)),
                   own_friction=every(friction[holds][-1:] == dataset.friction_coefficient.values),
                   friction=friction[holds], tangent=tangent),
        Check.that("fig8_06.line", distances=each(np.diff(np.abs(line)), ">", 0),
                   lines_on_one_side=every(np.sign(line) == np.sign(line[:1])), line=np.abs(line)),
        *(Check.of(chapter.THRESHOLDS[name], dataset[name]) for name in _THRESHOLDS),
        newton.touching_check(dataset.isel(case=0), 1, dataset.detach_force, "Detach force"),
        *_curve_checks(dataset),
        *insets,
        *_reading_checks(dataset),
    ]  # fmt: skip


def _curve_checks(dataset: xr.Dataset) -> list[Check]:
    """Check the amplitude between the thresholds, and that the regime changes there and nowhere else."""
    onset, stick, detach = limits = [float(dataset[name]) for name in _THRESHOLDS]
    slowest = dataset.smallest_velocity.values
    force, amplitude = dataset.swept_axial_force, dataset.swept_amplitude
    below, slips, beyond = force < onset, ((force > onset) & (force < stick)).values, force > detach
    none, slip, last = (amplitude.values[where] for where in (below, slips, beyond))
    net = printed_laws.net_force(dataset.assign_coords(axial_force=force)).values[slips]
    slope = slip[-1:] / net[-1:]
    off = abs(slip - slope * net) / slip[-1:]
    # At a threshold itself both neighbours' names are right: the cycle touches there.
    right = np.choose(np.digitize(force, sorted(limits)), [named(dataset.regime, name) for name in _REGIMES])
    judged = ~np.isin(force, limits)
    stops = (slowest <= dataset.stop_velocity.values[0]) == (force > stick).values
    insets = amplitude.sel(swept_axial_force=dataset.axial_force)
    return [
        Check.that("fig8_06.below_onset", forces=every(none == 0), below=none),
        Check.that("fig8_06.straight", slope=each(slope, ">", 0), off=each(off, "<", 1e-9)),
        Check.that("fig8_06.constant", least=each(last, ">", 0), spread=each(spread(last), "<", 1e-12), last=last),
        Check.that("fig8_06.portraits", motions=every(abs(insets - dataset.amplitude) <= 1e-9 * insets)),
        Check.that("fig8_06.regimes", exceptions=never(~right[judged])),
        Check.that("fig8_06.rest", forces=every(stops[judged]), slowest=slowest),
    ]


def _reading_checks(dataset: xr.Dataset) -> list[Check]:
    """Check the printed values: C± do not depend on the mass; Γ± as printed do not belong to the stated one."""
    stated = float(dataset.mass)
    other = float(dataset.reading_mass.values[dataset.reading_mass.values != stated][0])
    ours, theirs = (dataset.sel(reading_mass=mass) for mass in (stated, other))
    stands = {"inertia_minus": "fig8_06.inertia_minus", "inertia_plus": "fig8_06.inertia_plus"}
    inertias = {id: float(ours[f"reading_effective_{name}"]) for name, id in stands.items()}
    wrong = [abs(x / claims()[id].value - 1) > 0.1 for id, x in inertias.items()]
    forces = {chapter.THRESHOLDS[name]: float(theirs[f"reading_{name}"]) for name in ("stick_force", "detach_force")}
    off = [not abs(force / claims()[id].value - 1) <= 0.02 for id, force in forces.items()]
    read = f"as printed, taken for m = {other:g} kg (for the stated m = {stated:g} kg it is"
    p = dataset.assign_coords(mass=dataset.reading_mass)
    laws = {
        name: near(dataset[f"reading_{name}"], getattr(printed_laws, name.split("_")[1])(p, sign), 1e-12)
        for name, sign in zip(_READ, (-1, 1, -1, 1), strict=True)
    }
    drag = p.pitch_radius * np.tan(p.lead_angle) * p.translation_damping * p.input_speed  # R where N_0 = 0
    return [
        Check.of("fig8_06.damping_minus", ours.reading_effective_damping_minus),
        Check.of("fig8_06.damping_plus", ours.reading_effective_damping_plus),
        *(
            Check.of(id, theirs[f"reading_effective_{name}"], note=f"{read} {inertias[id]:.3g} kg m²)")
            for name, id in stands.items()
        ),
        Check.that("fig8_06.readings", **laws, onset=near(dataset.reading_onset_force, drag, 1e-12),
                   thresholds=every([float(ours[f"reading_{name}"]) == float(dataset[name]) for name in _THRESHOLDS])),
        Check.that("fig8_06.stated_mass", inertias_apart=every(wrong), mass=stated, inertias=[*inertias.values()]),
        Check.that("fig8_06.other_mass", forces_apart=every(off), mass=other,
                   forces=[quantity(x, "N") for x in forces.values()]),
    ]  # fmt: skip


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the amplitude curve by regimes, the three thresholds, and below the portraits, so that they hide nothing."""
    figure, cases = style.new_figure(style.DOUBLE, 5.2), dataset.case.values.tolist()
    panels = figure.subplot_mosaic([["curve"] * len(cases), cases], height_ratios=(1.2, 1))
    axes = panels["curve"]
    forces, amplitude = dataset.swept_axial_force, dataset.swept_amplitude
    for name, (colour, words, dashes) in _REGIMES.items():
        inside = named(dataset.regime, name)
        axes.plot(forces[inside], amplitude[inside], color=colour, linewidth=2.2, linestyle=dashes, label=words)
    top = 1.12 * float(amplitude.max())
    words = ", ".join(f"{float(dataset[f'printed_{name}']):g}" for name in _THRESHOLDS)
    for name, word in _THRESHOLDS.items():
        force = float(dataset[name])
        axes.axvline(force, color=style.GREY, linewidth=0.8, linestyle=":", zorder=0, label="computed")
        axes.axvline(float(dataset[f"printed_{name}"]), **style.PRINTED, zorder=0, label=f"printed: {words} N")
        axes.text(force, 1.01 * top, f"{word} {force:.2f} N", ha="center", va="bottom")
    axes.set(xlabel=style.label(forces), xlim=forces[[0, -1]], ylim=(-0.02 * top, top))
    axes.set_ylabel(style.label(amplitude, "amplitude of $u$"))
    # xarray's own interpolation needs scipy, which the package does not.
    curve = np.interp(dataset.axial_force, forces, amplitude, np.nan, np.nan)
    axes.plot(dataset.axial_force, curve, "o", color="white", mec=style.BLACK, markersize=4.5, zorder=4,
              label="force of a phase portrait")  # fmt: skip
    for index in cases:
        portrait, case = panels[index], dataset.sel(case=index)
        drawing.phase_plane(portrait, case, [0.8] * case.sizes["start"], 0.2)
        drawing.draw_lines(portrait, case)
        drawing.label_axes(portrait, case, f"$R$ = {style.number(case.axial_force)} N")
        portrait.locator_params(axis="x", nbins=4)
    portraits = [panels[k] for k in cases], [dataset.sel(case=k) for k in cases]
    return drawing.guide(style.legend(figure, [*panels.values()], 4), *portraits)
