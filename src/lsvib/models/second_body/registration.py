"""What scenes and the command line know of the drives with a second body: axial support and rotating nut."""

from typing import Any

import numpy as np

from lsvib.engine.automaton import Automaton
from lsvib.models.drive import Drive
from lsvib.models.model import Model, seizures_only_by_contact
from lsvib.models.two_bodies import TwoBodies, automaton_of


def two_body_model(kind: type[TwoBodies], drive: type[Drive], **own: Any) -> Model:
    """Return the ``MODEL`` of the drives of a class; ``own``: its fields that no other model shares.

    The coordinate and the rate of the second body are 0 if a start leaves them out.
    """
    second = kind.states[2:]

    def build(drive: Any, physics: tuple[str, ...], resume: str) -> Automaton:
        seizures_only_by_contact(drive.model, resume)
        return automaton_of(kind, drive, "slide_friction" in physics, "bearing_friction" in physics)

    common = ("support_damping", "translation_damping", "axial_force", drive.own_damping)
    return Model(
        drive=drive,
        build=build,
        start=lambda drive, values: np.array([values["u"], values["w"], *(values.get(key, 0.0) for key in second)]),
        modes=kind.modes,
        events=kind.events,
        optional=second,
        states=kind.states,
        terms=(*common, "slide_friction", "bearing_friction"),
        outputs=(
            "normal_force",
            "axial_contact_force",
            "coupling_torque",
            "coupling_deflection",
            "screw_speed",
            "nut_speed",
        ),
        **own,
    )
