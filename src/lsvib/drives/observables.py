"""What is observed of a drive besides its coordinates, a row each: what it is called, and how it follows from a state.

Scenes, datasets, cycles and automata read this table. An observable is an affine function of the state in each mode.
"""

from collections.abc import Callable
from dataclasses import dataclass

from lsvib.drives.mechanism import Mechanism, Solution
from lsvib.systems.exact.arithmetic import Row


@dataclass(frozen=True)
class Observable:
    """A quantity: ``words`` are its long name, unit and symbol, ``row`` gives it in a mode of a mechanism.

    ``rubbed``: whether friction of the threads changes it at a given state; under a friction law such a quantity has a
    share that goes with the coefficient. ``rigid``: whether scenes of rigid drives may ask for it, too. ``carried``:
    whether it counts from where the command has carried it, which scenes add, so that a cycle of it closes.
    """

    words: tuple[str, str, str]
    row: Callable[[Mechanism, Solution], Row]
    rubbed: bool = False
    rigid: bool = True
    carried: bool = False


TABLE = {
    "normal_force": Observable(("normal force of the threads", "N", "$N$"), lambda _, mode: mode.normal, rubbed=True),
    "axial_contact_force": Observable(
        ("axial force that the threads carry", "N", "$n$"), lambda _, mode: mode.contact, rubbed=True, rigid=False
    ),
    "coupling_torque": Observable(("torque of the coupling", "N m", "$T_r$"), lambda m, _: m.coupling_torque),
    "coupling_deflection": Observable(("coupling deflection", "rad", "$z$"), lambda m, _: m.deflection),
    "screw_speed": Observable(("angular speed of the screw", "rad s-1", r"$\dot\theta$"), lambda m, _: m.speed),
    "load_place": Observable(("position of the load", "m", "$x$"), lambda m, _: m.nut_place, carried=True),
    "load_speed": Observable(("speed of the load", "m s-1", r"$\dot x$"), lambda m, _: m.nut_speed),
    "sliding_speed": Observable(("sliding speed of the threads", "m s-1", "$v$"), lambda m, _: m.sliding),
    "friction_torque": Observable(("friction torque of threads and collar", "N m", "$T_f$"), Mechanism.rubbing, True),
}


def rows(mechanism: Mechanism, mode: Solution) -> dict[str, Row]:
    """Return the rows of all observables in a mode."""
    return {name: one.row(mechanism, mode) for name, one in TABLE.items()}
