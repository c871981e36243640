"""Figure 8.11: effect of the support damping on the sprag–slip cycle, with the line N = 0 for each damping."""

import numpy as np
import xarray as xr

from lsvib.answers import phase_plane
from lsvib.answers.attributes import named
from lsvib.chapter import newton
from lsvib.chapter.checks import Check, each, every, never, some
from lsvib.chapter.common import about
from lsvib.chapter.settings import Damping, PhasePlane, Values, several
from lsvib.drives.drive import Drive
from lsvib.pictures import drawing, style

CAPTION = """\
Sprag–slip cycles of the rigid drive for three levels of support damping c (assumed), each with its line of zero contact
force; triangles point forward in time. The screw slips to the left of the line, where N < 0, and seizes where the
trajectory reaches it: to the right of it, forward slip has no solution.
"""


class Settings(PhasePlane):
    unused = ("support_damping",)

    support_dampings: list[Damping] = several(2, 4, "Support dampings in ascending order [N m s/rad].")


def build(settings: Values) -> xr.Dataset:
    """Compute the phase plane for each damping; ``settings``: see ``Settings``."""
    drives = [Drive.of(settings["drive"]).replace(support_damping=c) for c in settings["support_dampings"]]
    return phase_plane.portraits(settings, drives, ("support_damping",), ("Sect. 8.6", "Sect. 8.6.1")).assign_attrs(
        about(__doc__, "exact event-driven motion and its return map", "Sect. 8.6.1, Fig. 8.11")
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the trend of the amplitude, where seizures start, and that nothing else happens there."""
    amplitude, damping = dataset.amplitude.values, dataset.support_damping.values
    seizes = named(dataset.event_kind, "seizure") & (dataset.event_time > 0)
    slope, offset = dataset.contact_line_slope, dataset.contact_line_angle
    terms = [dataset.event_u_before, -slope * dataset.event_w_before, -offset]
    worst = (abs(sum(terms)) / sum(abs(term) for term in terms)).where(seizes).max()
    impulse = dataset.event_normal_impulse.where(seizes).min()
    pairs = zip(amplitude[:, 0].max(axis=1), damping, strict=True)
    words = [f"{a:.5g} rad at c = {c:g} N m s/rad" for a, c in pairs]
    return [
        *newton.portrait_checks(dataset, "Fig. 8.11"),
        Check.that("fig8_11.sprag_slip", motions=every(named(dataset.attractor, "sprag slip cycle"))),
        Check.that("fig8_11.amplitude", dampings=each(np.diff(damping), ">", 0),
                   steps=each(np.diff(amplitude, axis=0), "<", 0), amplitudes=words,
                   less=1 - amplitude[-1].max() / amplitude[0].max()),
        Check.that("fig8_11.line", seizures=some(seizes), worst=each(worst, "<=", 1e-14)),
        Check.that("fig8_11.seizes", reversals=never(named(dataset.event_kind, "contact reversal")),
                   impulse=each(impulse, ">", 0)),
    ]  # fmt: skip


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw each limit cycle with its own line N = 0, on which its seizure starts."""
    figure = style.new_figure(style.DOUBLE, 3.6)
    axes = figure.add_subplot()
    cases = [dataset.sel(case=index) for index in dataset.case.values]
    colours, lines = (style.BLACK, style.BLUE, style.SKY, "#C9C9C9"), []  # apart in grey, too
    for case, colour in zip(cases, colours, strict=False):
        unit = style.unit(case.support_damping.attrs["units"])[1:-1]
        drawing.draw_cycle(axes, case, colour, name=f"$c$ = {style.number(case.support_damping)} {unit}")
        if "cycle_u" not in case:  # none vibrates
            continue
        u, w, seized = drawing.cycle_of(case)
        lines.append((*drawing.parted(u[:-1], w[:-1], seized[:-1]), colour))
    drawing.mark_origin(axes)
    axes.margins(0.08)
    axes.set_xlim(right=axes.get_xlim()[1] + 0.2 * np.ptp(axes.get_xlim()))  # room for words beyond the lines
    for case, colour in zip(cases, colours, strict=False):
        drawing.draw_lines(axes, case, colour, "$N = 0$, same colour")
    drawing.arrows(axes, lines)
    axes.text(0.38, 0.5, "$N < 0$ left of\neach line: slip", transform=axes.transAxes, ha="center", va="center")
    axes.text(0.98, 0.96, "right of each line\nno solution: seizure", transform=axes.transAxes, ha="right", va="top")
    drawing.label_axes(axes, dataset)
    cycles = [line for line in axes.lines if str(line.get_label()).startswith("$c$")]
    return style.legend(figure, [axes], 3, cycles)
