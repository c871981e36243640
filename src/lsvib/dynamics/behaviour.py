"""What drives do, in one word for each, by their motions alone: steady, vibrating in one way or another, or both.

Up to three motions are followed. One starts next to steady sliding, where only its stability counts; one far away on
θ′ = 0, from where the screw is pulled forward. If the first ends in steady sliding and the second on a cycle, both
coexist. Then, and wherever static friction is above that of sliding, the drive is also started from rest: the screw
stands with the coupling relaxed, and the motor begins to turn. Nothing else is taken from the equations of the drive:
no threshold, no sign of a coefficient.
"""

from enum import IntEnum
from types import SimpleNamespace

import numpy as np

from lsvib.drives import mechanics
from lsvib.drives.drive import STATIC
from lsvib.drives.many import ManyDrives
from lsvib.dynamics.kernels.sweep import REVERSES
from lsvib.dynamics.sweep import Starts, all_endings
from lsvib.numbers import Progress
from lsvib.systems.attractor import Attractor


class Behaviour(IntEnum):
    """What a drive does."""

    UNRESOLVED = -1
    NO_VIBRATION = 0  # every motion that was followed ends in steady sliding
    PURE_SLIP = 1
    STICK_SLIP = 2  # the contact force keeps its sign
    STICK_SLIP_WITH_CONTACT_REVERSAL = 3
    SPRAG_SLIP = 4
    COEXISTENCE = 5  # steady sliding attracts what is near, a cycle what is far
    NEUTRAL = 6  # undamped oscillations side by side
    VIBRATION_FROM_REST = 7  # steady sliding attracts what is near, a cycle the motion that begins at rest


_OF_CYCLES = {
    Attractor.OTHER_CYCLE: Behaviour.PURE_SLIP,
    Attractor.STICK_SLIP_CYCLE: Behaviour.STICK_SLIP,
    Attractor.SPRAG_SLIP_CYCLE: Behaviour.SPRAG_SLIP,
    Attractor.NEUTRAL_FAMILY: Behaviour.NEUTRAL,
}


def behaviours(
    drives: ManyDrives, workers: int = 1, progress: Progress | None = None
) -> tuple[np.recarray, np.ndarray]:
    """Return what motions next to steady sliding end on (k), and what the drives do (k, int8), a ``Behaviour`` each.

    Arguments: number of ``workers`` (:func:`lsvib.dynamics.sweep.all_endings`), which changes no label; ``progress``,
    called with the numbers of motions followed and the most that there may be.
    """
    near, far = near_and_far(drives)
    most = 3 * drives.size
    first = all_endings(drives, near, workers, progress and (lambda done, _: progress(done, most)))
    kinds = [first.attractor == kind for kind in _OF_CYCLES]
    found = np.select(kinds, list(_OF_CYCLES.values()), Behaviour.UNRESOLVED).astype(np.int8)
    reverses = (found == Behaviour.STICK_SLIP) & ((first.happens & REVERSES) > 0)
    found[reverses] = Behaviour.STICK_SLIP_WITH_CONTACT_REVERSAL
    steady = np.flatnonzero(first.attractor == Attractor.STEADY_SLIDING)

    def vibrating(start: Starts | None, done: int) -> np.ndarray:
        """Note which of the steady drives do not return from a start; return whether they vibrate then."""
        again = all_endings(drives.some(steady), start, workers, progress and (lambda n, _: progress(done + n, most)))
        found[steady[~np.isin(again.attractor, (Attractor.STEADY_SLIDING, *_OF_CYCLES))]] = Behaviour.UNRESOLVED
        return np.isin(again.attractor, list(_OF_CYCLES))

    if steady.size:
        found[steady] = Behaviour.NO_VIBRATION
        cycles = vibrating({key: column[steady] for key, column in far.items()}, drives.size)
        found[steady[cycles]] = Behaviour.COEXISTENCE
        static = np.any([drives.values.get(name, np.zeros(drives.size)) > 0 for name in STATIC], axis=0)
        steady = steady[cycles | static[steady]]
    if steady.size:
        found[steady[vibrating(None, 2 * drives.size)]] = Behaviour.VIBRATION_FROM_REST
    if progress is not None:
        progress(most, most)
    return first, found


@np.errstate(all="ignore")  # a drive whose lengths are beyond all numbers is refused with its tables
def near_and_far(drives: ManyDrives) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return starts next to steady sliding and far away, u [rad] and w [rad/s] (k), in plain double precision."""
    v = drives.values
    tangent = np.tan(v["lead_angle"])
    lever, speed, stiffness = v["pitch_radius"] * tangent, v["input_speed"], v["coupling_stiffness"]
    force = v["axial_force"] - lever * v["translation_damping"] * speed
    law = np.where(force * speed < 0, -1, 1)
    factors, inertias, dampings = mechanics.by_law(SimpleNamespace(**v, tan_lead=tangent), v["friction_coefficient"])
    inertia = np.where(law > 0, inertias[1], inertias[-1])
    to_contact = np.abs(inertia * force) / (lever * v["mass"] * stiffness)  # from steady sliding to Q = 0
    to_stop = np.abs(speed) * np.sqrt(v["screw_inertia"] / stiffness)
    band = v["pitch_radius"] * (factors[1] - factors[-1]) * np.abs(v["axial_force"]) / stiffness
    lengths = to_contact + to_stop + band + np.abs(dampings[-1] * speed) / stiffness
    # Without a net force steady sliding lies on Q = 0: beside it θ′ = 0 alone gives a length.
    nearest = np.where(to_contact > 0, np.minimum(to_contact, to_stop), to_stop)
    # u of the near start, in distances to the nearest event: it stays in one mode, and is no rounding
    near = {"u": 1e-6 * nearest, "w": np.zeros(drives.size)}
    # u of the far start, in sums of all lengths of the drive along u
    return near, {"u": -np.sign(speed) * 10.0 * lengths, "w": -speed}
