"""The scenes on which methods are compared: drive, start, duration and the sizes that errors are measured in."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lsvib.drives.coefficients import coefficients
from lsvib.drives.parameters import RigidParameters, ThreadsParameters
from lsvib.drives.registry import Model, find_model
from lsvib.drives.threads import seated_state
from lsvib.engine.automaton import Automaton
from lsvib.errors import InputError
from lsvib.steady_sliding.conditions import critical_mass
from lsvib.steady_sliding.thresholds import global_stability_force, stick_force

_NEAR = 1e-6  # relative distance of the grazing scenes from their threshold
_GAMMA = 1e-9  # Γ₊ / I of the scene near the critical mass, reached to 7 digits: the mass is a double


@dataclass(frozen=True)
class RaceScene:
    """A motion to compute: ``state`` (n) at time 0, followed for ``duration`` [s].

    ``title`` says what it is; ``step_cap`` [s] is the largest step of the methods that have one, well below the
    shortest oscillation of the drive; ``explicit``: whether a method with a bounded region of stability can do it at
    all. The steady amplitude is taken over the last fifth of the motion.
    """

    name: str
    title: str
    model: str
    drive: RigidParameters
    state: tuple[float, ...]
    duration: float
    step_cap: float
    explicit: bool = True

    @property
    def kind(self) -> Model:
        """The model by its name."""
        return find_model(self.model)

    @property
    def window(self) -> float:
        """Time [s] from which on the amplitude is steady."""
        return 0.8 * self.duration

    @property
    def scales(self) -> np.ndarray:
        """Typical sizes of the coordinates (n), for absolute tolerances: 0.1 rad, Ω, and what N_0 does to a contact."""
        sizes = [0.1, abs(self.drive.input_speed)]
        if isinstance(self.drive, ThreadsParameters):
            normal = abs(float(coefficients(self.drive).net_force))
            sizes += [normal / self.drive.contact_stiffness, normal / self.drive.contact_damping]
        return np.array(sizes)

    def automaton(self) -> Automaton:
        """Build the automaton of the scene."""
        return self.kind.build(self.drive, self.kind.options, "contact_sign")


def _stick_slip() -> RaceScene:
    drive = RigidParameters.of(mass=1, translation_damping=1e3, axial_force=40)
    return RaceScene("stick_slip", "stick–slip, 40 N", "rigid", drive, (0.01, 0.0), 0.5, 2e-4)


def _graze(name: str, title: str, side: int) -> RaceScene:
    drive = RigidParameters.of(mass=1, translation_damping=1e3)
    drive = drive.replace(axial_force=stick_force(drive) * (1 + side * _NEAR))
    return RaceScene(name, title, "rigid", drive, (0.05, 0.0), 0.5, 2e-4)


def _graze_above() -> RaceScene:
    return _graze("graze_above", "just above stick force", 1)


def _graze_below() -> RaceScene:
    return _graze("graze_below", "just below stick force", -1)


def _sprag_slip() -> RaceScene:
    drive = RigidParameters.of(mass=11, support_damping=1e-3, axial_force=-10)
    return RaceScene("sprag_slip", "sprag–slip, Painlevé", "rigid", drive, (0.1, 0.0), 0.5, 2e-4)


def _sprag_graze() -> RaceScene:
    drive = RigidParameters.of(mass=11, support_damping=1e-3)
    drive = drive.replace(axial_force=global_stability_force(drive) * (1 - _NEAR))
    return RaceScene("sprag_graze", "seizure just reached", "rigid", drive, (0.06, -drive.input_speed), 0.5, 2e-4)


def _stiff_contact() -> RaceScene:
    drive = ThreadsParameters.of(mass=11, axial_force=100)
    state = tuple(float(x) for x in seated_state(drive, 0.005, 0.0))
    return RaceScene("stiff_contact", "stiff contact, Fig. 8.10", "threads", drive, state, 0.05, 5e-5, explicit=False)


def _near_critical() -> RaceScene:
    drive = RigidParameters.of(translation_damping=1e3, axial_force=40)
    drive = drive.replace(mass=critical_mass(drive) * (1 - _GAMMA))
    return RaceScene("near_critical", "near-critical mass", "rigid", drive, (0.01, 0.0), 0.3, 2e-4)


def _long_run() -> RaceScene:
    drive = RigidParameters.of(mass=1, translation_damping=1e3, axial_force=40)
    return RaceScene("long_run", "1000 periods", "rigid", drive, (0.01, 0.0), 13.5, 2e-4)


_SCENES: dict[str, Callable[[], RaceScene]] = {
    "stick_slip": _stick_slip,
    "graze_above": _graze_above,
    "graze_below": _graze_below,
    "sprag_slip": _sprag_slip,
    "sprag_graze": _sprag_graze,
    "stiff_contact": _stiff_contact,
    "near_critical": _near_critical,
    "long_run": _long_run,
}
NAMES = tuple(_SCENES)


def scene(name: str, shorten: float = 1.0) -> RaceScene:
    """Return a scene by name, cut to a part of its duration; ``InputError`` if there is none of that name."""
    if name not in _SCENES:
        raise InputError(f"scene = {name!r} is not one of {', '.join(NAMES)}.")
    found = _SCENES[name]()
    return replace(found, duration=shorten * found.duration)
