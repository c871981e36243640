"""Figure 8.13: with softer contacts the motion is smoother and the coupling deflection turns positive during sprag."""

import numpy as np
import xarray as xr

from lsvib.answers import phase_plane
from lsvib.answers.attributes import drive_parameters, named, start_state, variable
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, each, every, near
from lsvib.chapter.common import CRITICAL_MASS_WITH_CONTACT, about, critical_mass_with_contact
from lsvib.chapter.contact_stability import crossing
from lsvib.chapter.settings import Contact, DriveFigure, Samples, State, Values, several
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.pictures import drawing, style

CAPTION = """\
Softer contacts (assumed values): (a) cycles, (b) coupling deflection. The drives have the same mass, 11 kg, but exceed
their thresholds by different amounts: steady sliding is lost at 9.65, 7.44 and 3.77 kg with these contacts, at 10.11 kg
with a rigid one (see contact_stability).
"""

_CONTACT = ("contact_stiffness", "contact_damping")
_COLOURS = (style.BLUE, style.ORANGE, style.VERMILION, style.GREEN)
_DASHES = ("-", (0, (5, 1.5)), (0, (3, 1, 1, 1)), (0, (1, 1)))


class Settings(DriveFigure):
    engine = ("planar", "modal")
    contacts: list[Contact] = several(2, 4, "Contacts whose cycles are drawn, the stiffest first.")
    start: State
    samples: Samples


def build(settings: Values) -> xr.Dataset:
    """Compute the cycles of a few contacts."""
    drive, start = Drive.of(settings["drive"], **dict.fromkeys(_CONTACT)), settings["start"]
    contacts = [drive.replace(**contact) for contact in settings["contacts"]]
    cycles = [phase_plane.reached(contact, start) for contact in contacts]
    steady, critical = float(coefficients(drive).deflection), [critical_mass_with_contact(c) for c in contacts]
    return xr.Dataset(
        phase_plane.cycle_curves(("contact",), cycles, settings["samples"])
        | phase_plane.cycle_curves((), [phase_plane.reached(drive, start)], settings["samples"], "rigid_cycle")
        | {"attractor": phase_plane.attractors("contact", [cycle.label for cycle in cycles])}
        | {"period": variable("contact", [cycle.period for cycle in cycles], "s", phase_plane.PERIOD, "$T$")},
        coords={
            **drive_parameters(contacts, "contact", along=_CONTACT, printed=("Sect. 8.6", "Sect. 8.6.1")),
            **start_state(start, "of the motions whose cycles are found, with a seated contact"),
            "critical_mass_with_contact": variable("contact", critical, *CRITICAL_MASS_WITH_CONTACT),
            "steady_deflection": variable((), steady, "rad", "coupling deflection in steady sliding", "$z_0$"),
        },
        attrs=about(__doc__, "exact event-driven motion with four states", "Sect. 8.6.1, Fig. 8.13"),
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that softer contacts give smoother cycles, and that with the softest the deflection turns positive."""
    critical, mass = dataset.critical_mass_with_contact.values, float(dataset.mass)
    cycles = newton.cycle_motion(dataset)
    z, speed = cycles.u + dataset.steady_deflection, cycles.w + cycles.input_speed
    force, sense = cycles.normal_force, np.sign(speed.where(speed != 0, speed.shift(sample=1)))  # of what stops: before
    push = sense * np.sign(force) * cycles.friction_coefficient * np.cos(cycles.lead_angle) - np.sin(cycles.lead_angle)
    torque = -cycles.coupling_stiffness * z - cycles.support_damping * speed - cycles.pitch_radius * force * push
    fastest = abs(torque / cycles.screw_inertia).where(abs(sense) == 1).max("sample").values  # θ″
    largest, jams = z.max("sample").values, (speed > 0) & (force > 0)  # under law +
    sprag = float(z.where(jams)[-1].max())
    crosses = crossing(newton.parameters(dataset), critical, {name: dataset[name].values for name in _CONTACT})
    place, steady = "Sect. 8.6.1, Fig. 8.13", printed_laws.steady_deflection(dataset)
    return [
        newton.cycle_check(dataset, place, period=dataset.period),
        newton.cycle_check(dataset, place, "rigid_cycle"),
        Check.that("fig8_13.repeats", cycles=every(named(dataset.attractor, "sprag slip cycle"))),
        Check.that("fig8_13.critical_mass", largest=each(critical, "<", mass), steps=each(np.diff(critical), "<", 0),
                   crossings=every((crosses > 0) == [False, True]), mass=mass, critical=critical),
        Check.that("fig8_13.smoother", steps=each(np.diff(fastest), "<", 0),
                   times=1e6 * float(dataset.input_speed) / fastest),
        Check.that("fig8_13.positive", softest=each(largest[-1], ">", 0), stiffer=each(largest[:-1], "<", 0),
                   steady_deflection=near(dataset.steady_deflection, steady, 1e-12), largest=largest),
        Check.that("fig8_13.during_sprag", sprag=each(sprag, ">", 0), gap=each(abs(sprag - largest[-1]), "<=", 1e-12),
                   whole=largest[-1]),
    ]  # fmt: skip


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw (a) the cycles and (b) z over a period, which lasts from one standstill of the screw to the next."""
    figure = style.new_figure(style.DOUBLE, 3.4)
    plane, deflection = figure.subplots(1, 2)
    cycles: list[drawing.DrawnLine] = []
    steady = float(dataset.steady_deflection)
    contacts = (dataset.isel(contact=k) for k in dataset.contact.values)
    for one, colour, dashes in zip(contacts, _COLOURS, _DASHES, strict=False):
        stiffness, damping = (style.number(float(one[name])) for name in _CONTACT)
        critical = f"$m_\\mathrm{{cr}}$ = {float(one.critical_mass_with_contact):.2f} kg"
        time, angle = one.cycle_time.values, one.cycle_u.values
        cycles.append((angle, one.cycle_w.values, colour))
        plane.plot(*cycles[-1][:2], color=colour, linestyle=dashes,
                   label=f"$k_c$ = {stiffness} N m⁻¹, $c_c$ = {damping} N s m⁻¹, {critical}")  # fmt: skip
        lowest = np.argmin(angle)
        turned = np.concatenate([time[lowest:] - time[lowest], time[:lowest] + time[-1] - time[lowest]])
        deflection.plot(turned / float(one.period), np.roll(angle, -lowest) + steady, color=colour, linestyle=dashes)
    plane.plot(dataset.rigid_cycle_u, dataset.rigid_cycle_w, color=style.BLACK, linewidth=0.9,
               linestyle=(0, (4, 2)), label="rigid drive")  # fmt: skip
    plane.axvline(-steady, color=style.GREEN, linewidth=0.9, linestyle=":", label="$z = 0$")
    plane.locator_params(axis="x", nbins=5)
    drawing.mark_origin(plane)
    plane.margins(0.06)
    drawing.arrows(plane, cycles)
    labels = style.label(dataset.cycle_u, "deviation"), style.label(dataset.cycle_w, "rate")
    style.frame(plane, "(a) phase plane", *labels)
    deflection.axhline(0, color=style.GREEN, linewidth=0.9, linestyle=":")
    words = "Time since the minimum of $z$ / period", "Coupling deflection $z$ [rad]"
    style.frame(deflection, "(b) coupling deflection over a period", *words, xlim=(0, 1))
    return style.legend(figure, [plane, deflection], 2)
