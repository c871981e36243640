"""What scenes and the command line know of the drives with a second body: axial support and rotating nut."""

from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import Any

import numpy as np

from lsvib.drives.linear_parts import LinearParts, Polynomial
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.registry import Model, seizures_only_by_contact
from lsvib.drives.second_body.body_powers import TwoBodyPowers
from lsvib.engine.automaton import Automaton


def two_body_model(
    name: str,
    drive: type[RigidParameters],
    make: Callable[..., Automaton],
    modes: type[IntEnum],
    events: type[IntEnum],
    second: tuple[str, str],
    quantities: Mapping[str, tuple[str, str, str]],
    characteristic: Callable[[Mapping[str, Any], LinearParts], Polynomial],
    powers: type[TwoBodyPowers],
    equations: str,
    section: str,
) -> Model:
    """Return the ``MODEL`` of a drive whose automaton is ``make(drive, slide=, bearing=)``.

    ``second``: the coordinate and the rate of the second body, in a start 0 if left out; the others as of
    :class:`~lsvib.drives.registry.Model`.
    """

    def build(drive: RigidParameters, physics: tuple[str, ...], resume: str) -> Automaton:
        seizures_only_by_contact(name, resume)
        return make(drive, slide="slide_friction" in physics, bearing="bearing_friction" in physics)

    return Model(
        drive=drive,
        build=build,
        start=lambda drive, values: np.array([values["u"], values["w"], *(values.get(key, 0.0) for key in second)]),
        modes=modes,
        events=events,
        required=("u", "w"),
        optional=second,
        states=("angle_deviation", "velocity_deviation", *second),
        terms=(
            "support_damping",
            "translation_damping",
            "axial_force",
            drive.own_damping,
            "slide_friction",
            "bearing_friction",
        ),
        options=(),
        outputs=(
            "normal_force",
            "axial_contact_force",
            "coupling_torque",
            "coupling_deflection",
            "screw_speed",
            "nut_speed",
        ),
        equations=equations,
        characteristic=characteristic,
        powers=powers,
        quantities=quantities,
        section=section,
    )
