"""The scenes on which methods are compared: drive, start, duration and the sizes that errors are measured in."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from references.drives import threads_drive

from benchmarks.judge import Record
from benchmarks.sweeps.cases_of_laws import before_touch, sliding
from benchmarks.truth import truth
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.model import Model, model_of, seated_state
from lsvib.stability.boundaries import place_values
from lsvib.stability.force_thresholds import threshold_force
from lsvib.systems.automaton import Automaton

_NEAR = 1e-6  # relative distance of the grazing scenes from their threshold
_STEEP = 1e-3  # Stribeck speed of a steep law, in sliding speeds of steady sliding
_GAMMA = 1e-9  # Γ₊ / I of the scene near the critical mass, reached to 7 digits: the mass is a double


@dataclass(frozen=True)
class RaceScene:
    """A motion to compute: ``state`` (n) at time 0, followed for ``duration`` [s].

    ``title`` says what it is; ``step_cap`` [s] is the largest step of the methods that have one, well below the
    shortest oscillation of the drive; ``stiff``: whether a method with a bounded region of stability cannot do it. The
    steady amplitude is taken over the last fifth of the motion.
    """

    name: str
    title: str
    drive: Drive
    state: tuple[float, ...]
    duration: float
    step_cap: float
    stiff: bool = False

    @property
    def definition(self) -> Model:
        """The model of the drive."""
        return model_of(self.drive)

    @property
    def steady_from(self) -> float:
        """Time [s] from which on the amplitude is steady."""
        return 0.8 * self.duration

    @property
    def scales(self) -> np.ndarray:
        """Typical sizes of the coordinates (n), for absolute tolerances: 0.1 rad, Ω, and what N_0 does to a contact."""
        sizes = [0.1, abs(self.drive.input_speed)] * (1 + ("motor" in self.drive.parts))
        if "threads" in self.drive.parts:
            normal = abs(float(coefficients(self.drive).net_force))
            sizes += [normal / self.drive.contact_stiffness, normal / self.drive.contact_damping]
        return np.array(sizes)

    def truth(self) -> Record:
        """Return the true motion, in 40 digits."""
        return truth(self.drive, self.state, self.duration, steady_from=self.steady_from)

    def automaton(self) -> Automaton:
        """Build the automaton of the scene."""
        return automaton_of(self.drive)


@cache
def _scenes() -> dict[str, RaceScene]:
    """All scenes by their names."""
    slips = Drive.of(mass=1, translation_damping=1e3)
    vibrates, grazes = slips.replace(axial_force=40), threshold_force(slips, "stick")
    sprags = Drive.of(mass=11, support_damping=1e-3)
    just = sprags.replace(axial_force=threshold_force(sprags, "global_stability") * (1 - _NEAR))
    stiff = threads_drive(mass=11, axial_force=100)
    seated = tuple(float(x) for x in seated_state(stiff, 0.005, 0.0))
    light = Drive.of(translation_damping=1e3, axial_force=40)
    seat = Drive(friction="powered_seat", axial_force=100)
    steep = light.replace(stribeck_rise=0.4, stribeck_speed=_STEEP * sliding(light))
    driven = seat.replace(input_speed=10, motor_inertia=2e-5, integral_gain=2.0, speed_gain=2e-3,
                          slide_friction=5.0, slide_static_friction=8.0)  # fmt: skip
    u, w = before_touch(seat, 0.02)
    critical = light.replace(mass=place_values(light, "kinematic_constraint", "mass")[0] * (1 - _GAMMA))

    def rigid(name: str, title: str, drive: Drive, start: tuple[float, ...], duration: float = 0.5) -> RaceScene:
        return RaceScene(name, title, drive, start, duration, 2e-4)

    def graze(name: str, title: str, side: int) -> RaceScene:
        return rigid(name, title, slips.replace(axial_force=grazes * (1 + side * _NEAR)), (0.05, 0.0))

    found = (
        rigid("stick_slip", "stick–slip, 40 N", vibrates, (0.01, 0.0)),
        graze("graze_above", "just above stick force", 1),
        graze("graze_below", "just below stick force", -1),
        rigid("sprag_slip", "sprag–slip, Painlevé", sprags.replace(axial_force=-10), (0.1, 0.0)),
        rigid("sprag_graze", "seizure just reached", just, (0.06, -just.input_speed)),
        RaceScene("stiff_contact", "stiff contact, Fig. 8.10", stiff, seated, 0.05, 5e-5, stiff=True),
        rigid("near_critical", "near-critical mass", critical, (0.01, 0.0), 0.3),
        rigid("long_run", "500 periods", vibrates, (0.01, 0.0), 6.75),
        rigid("friction_law", "falling friction, seat", seat, (0.1, 0.0)),
        rigid("steep_law", "steep Stribeck rise", steep, (0.01, 0.0), 0.25),
        rigid("law_graze", "standstill just touched", seat, (u * (1 + _NEAR), w), 0.25),
        rigid("law_motor", "law, motor and guide", driven, (0.05, 0.0, 0.0, 0.0), 0.25),
    )
    return {scene.name: scene for scene in found}


def scene(name: str, shorten: float = 1.0) -> RaceScene:
    """Return a scene by name, cut to a part of its duration."""
    found = _scenes()[name]
    return replace(found, duration=shorten * found.duration)
