"""What a scene saves by leaving out what it does not need: each scene with its own model, and with a general one.

The general model of a rigid scene has everything: four states of which the two of the contact are held at zero, and
rest. That of a drive with axial support has friction of the slide, so small (1e-18 N) that no digit feels it.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from references.drives import support_drive

from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive, forget
from lsvib.systems.automaton import Automaton
from lsvib.systems.exact.modal_form import linear_mode, modal_flow
from lsvib.systems.kernels import layout
from lsvib.systems.motion import Motion, follow

_CONTACT_SIZES = (1e-6, 1e-3)  # of mismatch [m] and its rate [m/s]; they only scale coordinates that stay zero
_NOTHING = 1e-18  # N


class Ablated(NamedTuple):
    """A scene: what it leaves out, its pared and its general automaton, and its start in either."""

    left_out: str
    pared: Callable[[], Automaton]
    general: Callable[[], Automaton]
    start: tuple[np.ndarray, np.ndarray]
    duration: float


class Measured(NamedTuple):
    """A model on a scene: times [s] of its runs and its constructions, number of modes, guards and states, motion."""

    run_times: list[float]
    build_times: list[float]
    modes: int
    guards: int
    states: int
    table_bytes: int
    motion: Motion


def scenes(duration: float) -> dict[str, Ablated]:
    """Return the scenes by name, each to be followed for ``duration`` [s]."""
    slip = Drive.of(translation_damping=1e3, axial_force=25.0)
    stick = slip.replace(axial_force=40.0)
    sprag = Drive.of(mass=15.0, axial_force=100.0)
    support = support_drive(screw_mass=1.0, support_stiffness=1e6, mass=1.0, axial_force=40.0, translation_damping=1e3)
    loaded = support.replace(slide_friction=_NOTHING)
    here = np.array([1e-3, 0.0])

    def rigid(words: str, drive: Drive, rest: bool) -> Ablated:
        """Return the scene of a rigid drive, with or without rest among its modes."""
        return Ablated(
            words,
            lambda: automaton_of(drive, rest=rest),
            lambda: generalised(automaton_of(drive), drive.input_speed),
            (here, np.append(here, [0.0, 0.0])),
            duration,
        )

    four = np.array([1e-3, 0.0, 0.0, 0.0])
    return {
        "slip_cycle": rigid("rest, seizure, contact state", slip, False),
        "stick_slip": rigid("seizure, contact state", stick, True),
        "sprag_slip": rigid("law + slip, contact state", sprag, True),
        "axial_support": Ablated(
            "friction of the slide",
            lambda: automaton_of(support),
            lambda: automaton_of(loaded),
            (four, four),
            duration,
        ),
    }


def generalised(automaton: Automaton, input_speed: float) -> Automaton:
    """Return a rigid automaton as one of four states, of which the last two stay zero, on the modal engine."""
    tables, rest = automaton.tables, automaton.marks["rest"]
    modes = []
    for row, code in zip(tables.flow, automaton.codes, strict=True):
        acceleration = (-row[layout.A0], -row[layout.A1], 0, 0, row[layout.B])
        held = {2: 0, 3: 0} | ({1: -input_speed} if code in rest else {})
        field = [(0, 1, 0, 0, 0), acceleration, (0, 0, 0, 1, 0), (0, 0, 0, 0, 0)]
        modes.append(linear_mode(field, (0.1, abs(input_speed), *_CONTACT_SIZES), held, "the drive"))
    resets = np.zeros((len(tables.resets), 4, 5))
    resets[:, :2] = _wider(tables.resets)
    tables = tables._replace(
        flow=modal_flow(modes),
        surfaces=_wider(tables.surfaces),
        resets=resets,
        condition_row=_wider(tables.condition_row),
        guard_parts=np.zeros((len(tables.guard_sign), 0)),
    )
    return replace(
        automaton,
        tables=tables,
        states=(*automaton.states, "thread_mismatch", "mismatch_rate"),
        observables={name: _wider(rows) for name, rows in automaton.observables.items()},
        condition=max(mode.condition for mode in modes),
    )


def _wider(rows: np.ndarray) -> np.ndarray:
    """Rows over (u, w, 1) as rows over (u, w, e, v, 1)."""
    return np.concatenate([rows[..., :2], np.zeros((*rows.shape[:-1], 2)), rows[..., 2:]], axis=-1)


def measure(scene: Ablated, repeats: int) -> tuple[Measured, Measured]:
    """Measure the pared and the general model of a scene in turns, so that a busy machine slows both alike."""
    builds = (scene.pared, scene.general)
    times: list[list[tuple[float, float]]] = [[], []]
    motions: list[Motion] = []
    for build, start in zip(builds, scene.start, strict=True):
        motions.append(follow(build(), start, scene.duration))
    for _ in range(repeats):
        for k, (build, start) in enumerate(zip(builds, scene.start, strict=True)):
            forget()  # a drive is built once
            begun = time.process_time()
            automaton = build()
            built = time.process_time()
            follow(automaton, start, scene.duration)
            times[k].append((time.process_time() - built, built - begun))
    return tuple(_measured(motion, *zip(*found, strict=True)) for motion, found in zip(motions, times, strict=True))


def _measured(motion: Motion, run_times: list[float], build_times: list[float]) -> Measured:
    tables, automaton = motion.automaton.tables, motion.automaton
    arrays = [x for x in tables if isinstance(x, np.ndarray)]
    arrays += [] if isinstance(tables.flow, np.ndarray) else list(tables.flow)
    size = sum(array.nbytes for array in arrays)
    return Measured(
        run_times, build_times, automaton.codes.size, tables.guard_sign.size, len(automaton.states), size, motion
    )


def difference(pared: Motion, general: Motion) -> tuple[bool, float]:
    """Whether both have the same events, and the largest difference of states and times, relative to their size.

    Events of a kind that the pared model does not have – of a friction that is next to nothing – are not counted.
    """
    counted = np.isin(general.kind, pared.kind)
    if not np.array_equal(pared.kind, general.kind[counted]):
        return False, float("nan")
    first, second = np.vstack([pared.after, pared.end_state]), np.vstack([general.after[counted], general.end_state])
    gap = np.abs(first[:, :2] - second[:, :2]).max(axis=0) / np.abs(first[:, :2]).max(axis=0)
    late = np.abs(pared.time - general.time[counted]).max(initial=0.0) / pared.end_time
    return True, float(max(gap.max(), late))
