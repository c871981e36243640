"""The friction law of the threads in the modes of drives with two bodies (:mod:`lsvib.models.two_bodies`)."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from flint import arb

from lsvib.engine.automaton import Mode, Row, Transition
from lsvib.engine.exact.taylor_form import Split
from lsvib.models import sliding
from lsvib.models.mechanics import constant
from lsvib.models.model import DIRECTIONS

if TYPE_CHECKING:
    from lsvib.models.two_bodies import TwoBodies


def under_law(
    model: "TwoBodies", modes: dict[str, Mode], seen: dict[str, dict[str, tuple]]
) -> dict[str, dict[str, Row]]:
    """Put the friction law into the modes that slip, and into what is seen of them; divide that of steady sliding.

    Returns the rows of the observables that count η times, by name and mode.
    """
    probe, none = sliding.probe(model.d), constant(0)
    parts: dict[str, dict[str, Row]] = {
        name: dict.fromkeys(modes, none) for name in ("normal_force", "axial_contact_force")
    }
    for d, q in model.slips:
        name, coefficients = model.slip_name(d, q, 1), (arb(0), probe)
        free, rubbed = (model.solve(d, d * q, 1, mu) for mu in coefficients)
        without, pressed = (model.observables(x, mu) for x, mu in zip((free, rubbed), coefficients, strict=True))
        force = without["normal_force"]
        split = Split.of(free.field, force, rubbed.field, pressed["normal_force"], probe)
        row, guards = sliding.speed_row(d, model.slip, model.d), modes[name].guards
        if math.isfinite(model.fastest):
            model.transitions["beyond"] = Transition(())
            guards += (model.guard(f"beyond_{DIRECTIONS[d]}", (*row[:-1], row[-1] - model.fastest), -1, "beyond"),)
        modes[name] = replace(modes[name], flow=split.mode(row, model.pieces), guards=guards)
        seen[name] = without
        for key, of_mode in parts.items():
            of_mode[name] = split.part(without[key], pressed[key])
    steady = model.slip_name(model.turning, model.steady_law * model.turning, 1)
    if steady in modes:
        sliding.divided(steady, model.events["PASSAGE"], modes, model.transitions, model.surfaces)
        half = f"{steady}_slow"
        seen[half] = seen[steady]
        for of_mode in parts.values():
            of_mode[half] = of_mode[steady]
    return parts
