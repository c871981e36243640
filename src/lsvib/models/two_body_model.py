"""What both models with two bodies are besides mechanics: codes of modes and events, powers, and their ``Model``."""

from collections.abc import Iterator, Sequence
from enum import IntEnum
from typing import Any

import numpy as np

from lsvib.engine.automaton import Automaton
from lsvib.engine.exact.arithmetic import many_digits
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, FIRST_MODEL_KIND, GRAZE_KIND
from lsvib.models.drive import Drive, NutDrive, SupportDrive, once
from lsvib.models.model import DIRECTIONS, SIGNS, Model, Powers, product, seizures_only_by_contact
from lsvib.models.two_bodies import HELD, OUTPUTS, SLIPS, TwoBodies


def mode_enum(name: str, rests: Sequence[str], second: str) -> type[IntEnum]:
    """Return the codes of a model's modes: slips and rests, alone and with each direction of the second body."""
    plain = [f"slip_{DIRECTIONS[d]}_{SIGNS[q]}" for d, q in SLIPS] + list(rests)
    names = plain + [f"{mode}_{second}_{how}" for how in HELD.values() for mode in plain]
    return IntEnum(name, {mode.upper(): code for code, mode in enumerate(names)})


def event_enum(name: str, friction: str) -> type[IntEnum]:
    """Return the kinds of a model's events; ``friction``: word for the friction of the second body."""
    kinds = ["CONTACT_REVERSAL", "STICK", "REVERSAL", "RELEASE", "SEIZURE"]
    kinds += [f"{friction}_{kind}".upper() for kind in ("stick", "reversal", "release")]
    kinds.append("PASSAGE")  # θ′ passes Ω, where a friction law divides the mode of steady sliding
    own = {kind: FIRST_MODEL_KIND + i for i, kind in enumerate(kinds)}
    return IntEnum(name, {"GRAZE": GRAZE_KIND, "ACCUMULATION": ACCUMULATION_KIND, **own})


@once
def automaton_of(model: type[TwoBodies], drive: SupportDrive | NutDrive, slide: bool, bearing: bool) -> Automaton:
    """Return the automaton of a drive; ``slide``, ``bearing``: with F_0, with T_0.

    Raises ``InputError`` where F_0 or T_0 leaves the motion undetermined (see the models), ``EngineError`` if the rates
    of a mode cannot be separated in double precision.
    """
    with many_digits():
        return model(drive, slide, bearing).automaton()


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
        outputs=OUTPUTS,
        **own,
    )


class TwoBodyPowers(Powers):
    """Powers of a drive whose second body moves at the fourth coordinate of the state, the row ``second``.

    ``inertia`` names the parameter that is the mass or the moment of inertia of the second body.
    """

    inertia: str

    @property
    def second(self) -> np.ndarray:
        """Speed of the second body, x_1′ [m/s] or θ_2′ [rad/s]."""
        return self.unit[3]

    def dampers(self) -> Iterator[tuple[float, np.ndarray]]:
        """Yield the damper of the second body."""
        yield getattr(self.drive, self.drive.own_damping), self.second

    def friction(self, mode: int) -> Iterator[np.ndarray]:
        """Yield the powers [W] of the friction of threads, slide (F_0) and bearing (T_0)."""
        yield from super().friction(mode)
        yield self.drive.slide_friction * product(self.nut, self.one)
        yield self.drive.bearing_friction * product(self.screw, self.one)

    def second_energy(self, x: np.ndarray) -> float:
        """Return twice the kinetic energy [J] of the second body at (x, 1)."""
        return float(getattr(self.drive, self.inertia) * (self.second @ x) ** 2)
