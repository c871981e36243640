"""What the layers above ask of a drive: its :class:`Model`, made from the parts that it has.

A drive has a screw on a coupling, rigid threads and a load; what else there may be – an axial support, a nut that may
turn, compliant threads – are *parts* (:mod:`lsvib.drives.mechanism`), and any of them can be there. What is known of a
drive with certain parts alone, above all of the rigid drive (eqs 8.13–8.33), stands in one module each and is chosen by
the parts.
"""

from collections.abc import Mapping
from enum import IntEnum
from functools import cache, cached_property
from typing import Any, cast

import numpy as np

from lsvib.drives import observables, thresholds
from lsvib.drives.drive import DRY, PARTS, Drive
from lsvib.drives.mechanism import Mechanism
from lsvib.drives.names import BODIES, COORDINATES, Event, codes_of, own_frictions, sides_of_rest
from lsvib.errors import InputError
from lsvib.systems.exact.arithmetic import doubles, many_digits, sign

_EQUATIONS = {"threads": "eqs 8.6, 8.7", "support": "eqs 8.23-8.32", "nut": "Sect. 5.8, eq. 8.33"}
_CONSTRAINT = {
    (): "Γ₊ = I − ξ₊ tan λ m r_m² = 0 (eq. 8.20)",
    ("motor",): "Γ₊ = I − ξ₊ tan λ m r_m² = 0 (eq. 8.20)",
    ("threads",): "Γ₊ = I − ξ₊ tan λ m r_m² = 0, the limit of stiff threads (eq. 8.20, Lemma 8.1)",
    ("support",): "Γ̃₊ = I − ξ₊ tan λ m̃ r_m² = 0 with m̃ = m m_1 / (m + m_1) (eqs 8.27, 8.28)",
    ("nut",): "Γ̂₊ = I I_2 / (I + I_2) − ξ₊ tan λ m r_m² = 0 (eq. 8.33)",
}


class Model:
    """What can be said of all drives with certain ``parts``, in the order of :data:`COORDINATES`.

    ``rigid``: whether they are rigid drives of the chapter, without parts and without friction against the ground.

    A start gives the coordinates ``states`` by name: u [rad] and w [rad/s] are needed, the others may be left out.
    ``modes`` and ``events`` name the codes of datasets. ``terms`` are the parameters that a scene may leave out (then
    they must be zero), ``options`` the other words that its ``physics`` may hold, ``outputs`` its observables.

    ``constraint`` is the equation of the kinematic constraint in words; ``thresholds`` are the names of those that can
    be solved for a parameter (of two states there is no flutter), ``curves`` those of the exact curves in its charts; a
    drive without any has no charts. ``equations`` are the numbers of its equations in the book.
    """

    events = Event

    def __init__(self, parts: tuple[str, ...], dry: tuple[str, ...]) -> None:
        self.parts, self.dry = parts, dry
        self.rigid, self.compliant = not (parts or dry), "threads" in parts
        self.states = tuple(name for part in ("screw", *parts) for name in COORDINATES[part])
        dampers = (PARTS[part][-1] for part in parts)
        self.terms: tuple[str, ...] = ("support_damping", "translation_damping", "axial_force", *dampers, *dry)
        self.options = () if parts else ("rest",)
        outputs = [name for name, one in observables.TABLE.items() if one.rigid or not self.rigid]
        self.outputs = tuple(sorted(outputs, key=lambda name: not observables.TABLE[name].rigid))
        self.equations = ", ".join(_EQUATIONS[part] for part in parts if part in _EQUATIONS) or "eqs 8.13-8.17"
        general = "Γ₊ = I_eff − ξ₊ tan λ m_eff r_m² = 0 with the reduced inertia and mass (eqs 8.20, 8.28, 8.33)"
        self.constraint = _CONSTRAINT.get(parts, general)
        names = thresholds.names(self.rigid)
        self.thresholds = names if parts else tuple(name for name in names if name != "flutter")
        self.curves: tuple[str, ...] = ("flutter",) if parts == ("threads",) else ()
        if self.rigid:
            self.curves = thresholds.names(rigid=True, drawn=True)

    @cached_property
    def modes(self) -> type[IntEnum]:
        """The codes of modes."""
        codes = codes_of(own_frictions(self.parts, self.dry), sides_of_rest(self.parts))
        return cast(type[IntEnum], IntEnum("MotionMode", {name.upper(): code for name, code in codes.items()}))

    def from_rest(self, drive: Drive) -> dict[str, float]:
        """Return the start at which the screw stands with the coupling relaxed while the motor begins to turn at Ω."""
        return dict(zip(self.states, standing_state(drive).tolist(), strict=True))

    def initial_state(self, drive: Drive, values: Mapping[str, float]) -> np.ndarray:
        """Return the state of a start, else as in steady sliding; ``InputError`` if a key is missing or not known."""
        if not {"u", "w"} <= set(values) <= set(self.states):
            optional = f", and may have {' and '.join(self.states[2:])}" if self.parts else ""
            raise InputError(f"start has the keys {', '.join(values) or 'none'}; it needs u and w{optional}.")
        state = seated_state(drive, values["u"], values["w"]) if self.compliant else np.zeros(len(self.states))
        given = [values.get(key) for key in self.states]
        return np.array([x if value is None else value for value, x in zip(given, state, strict=True)], dtype=float)


_of_parts = cache(Model)


def model_of(drive: Drive) -> Model:
    """Return what can be said of a drive by its parts.

    >>> model_of(Drive(contact_stiffness=1e8)).states
    ('u', 'w', 'thread_mismatch', 'mismatch_rate')
    """
    return _of_parts(drive.parts, tuple(name for name in DRY if getattr(drive, name)))


def coordinates() -> tuple[str, ...]:
    """Return the names of the coordinates of all parts."""
    return Model(tuple(PARTS), ()).states


def seated(mechanism: Mechanism) -> np.ndarray:
    """Return the state of steady sliding: compliant threads are compressed by N_0, all else is measured from it."""
    state = [0] * len(mechanism.states)
    if mechanism.compliant:
        state[mechanism.place["threads"]] = mechanism.compression
    return doubles(state, (len(state),))


def standing(m: Mechanism) -> np.ndarray:
    """Return the state in which the screw stands with the coupling relaxed, as before the motor is switched on.

    The threads carry no torque; what lets the load move along carries R, less what the slide holds of it as it slides.
    """
    d, state = m.d, list[Any]([0] * len(m.states))
    state[:2] = -m.deflection[-1], -d.input_speed
    left = abs(d.axial_force) - m.limits.get("slide", 0)
    contact = left * sign(d.axial_force) if sign(left) > 0 else 0
    for part in m.bodies:
        load, carried = {"contact": (m.force, contact), "torque": (m.twist, 0)}.get(BODIES[part].pushed, (0, 0))
        place = m.place[part]
        state[place] = (carried - load) / getattr(d, PARTS[part][1])
        if BODIES[part].on == "screw":
            state[place], state[place + 1] = state[place] + state[0], state[place + 1] + state[1]
        elif part == "motor":  # which stands, too, and whose controller has seen no error
            state[place : place + 2] = m.steady_torque / d.integral_gain, state[1]
            state[0] = state[0] + state[place]
    if m.compliant:
        state[m.place["threads"]] = contact / d.contact_stiffness
    return doubles(state, (len(state),))


@many_digits()
def standing_state(drive: Drive) -> np.ndarray:
    """Return the state of :func:`standing` of a drive."""
    d = drive.exact()
    return standing(Mechanism(d, drive.parts, d.steady_friction))


@many_digits()
def seated_state(drive: Drive, u: float, w: float) -> np.ndarray:
    """Return the state with a deviation u [rad] and w [rad/s], all else as in steady sliding of compliant threads."""
    d = drive.exact()
    state = seated(Mechanism(d, drive.parts, d.steady_friction))
    state[:2] = u, w
    return state
