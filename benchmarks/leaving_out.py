"""What a scene saves by leaving out what it does not need: each scene with its own model, and with a general one.

The general model of a rigid scene has everything: four states of which the two of the contact are held at zero, and
rest. That of a drive with axial support has friction of the slide, so small (1e-18 N) that no digit feels it, and that
of one with constant friction a law with a rise of 1e-300.
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
from lsvib.systems.kernels.layout import ModalFlow, TaylorFlow
from lsvib.systems.motion import Motion, follow

_CONTACT_SIZES = (1e-6, 1e-3)  # of mismatch [m] and its rate [m/s]; they only scale coordinates that stay zero
_NOTHING = 1e-18  # N
_NO_RISE = {"stribeck_rise": 1e-300, "stribeck_speed": 0.01}


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
    sprag, seat = Drive.of(mass=15.0, axial_force=100.0), Drive(friction="powered_seat", axial_force=100.0)
    support = support_drive(screw_mass=1.0, support_stiffness=1e6, mass=1.0, axial_force=40.0, translation_damping=1e3)
    loaded = support.replace(slide_friction=_NOTHING)
    here = np.array([1e-3, 0.0])

    def rigid(words: str, drive: Drive, rest: bool) -> Ablated:
        """Return the scene of a rigid drive, with or without rest among its modes."""
        return Ablated(
            words,
            lambda: automaton_of(drive, rest=rest),
            lambda: generalised(automaton_of(drive), drive.input_speed),
            (here, four),
            duration,
        )

    def other(words: str, drive: Drive, general: Drive, start: np.ndarray) -> Ablated:
        """Return the scene of a drive beside that of another one with the same motion."""
        return Ablated(words, lambda: automaton_of(drive), lambda: automaton_of(general), (start, start), duration)

    four = np.array([1e-3, 0.0, 0.0, 0.0])
    return {
        "slip_cycle": rigid("rest, seizure, contact state", slip, False),
        "stick_slip": rigid("seizure, contact state", stick, True),
        "sprag_slip": rigid("slip under law +, contact state", sprag, True),
        "axial_support": other("friction of the slide", support, loaded, four),
        "constant_friction": other("friction law", stick, stick.replace(**_NO_RISE), here),
        "friction_law": rigid("contact state", seat, True),
    }


def generalised(automaton: Automaton, input_speed: float) -> Automaton:
    """Return a rigid automaton as one of four states, of which the last two stay zero; not in closed form of two."""
    tables = automaton.tables
    resets = np.zeros((len(tables.resets), 4, 5))
    resets[:, :2] = _wider(tables.resets)
    longer = _in_series if isinstance(tables.flow, TaylorFlow) else _in_closed_form
    flow, condition = longer(automaton, input_speed)
    return replace(
        automaton,
        tables=tables._replace(
            flow=flow,
            surfaces=_wider(tables.surfaces),
            resets=resets,
            condition_row=_wider(tables.condition_row),
            guard_parts=np.zeros((len(tables.guard_sign), 0)),
        ),
        states=(*automaton.states, "thread_mismatch", "mismatch_rate"),
        observables={name: _wider(rows) for name, rows in automaton.observables.items()},
        condition=condition,
    )


def _in_closed_form(automaton: Automaton, input_speed: float) -> tuple[ModalFlow, float]:
    """The flow of a planar automaton with two more states, and its largest condition."""
    modes = []
    for row, code in zip(automaton.tables.flow, automaton.codes, strict=True):
        acceleration = (-row[layout.A0], -row[layout.A1], 0, 0, row[layout.B])
        held = {2: 0, 3: 0} | ({1: -input_speed} if code in automaton.marks["rest"] else {})
        field = [(0, 1, 0, 0, 0), acceleration, (0, 0, 0, 1, 0), (0, 0, 0, 0, 0)]
        modes.append(linear_mode(field, (0.1, abs(input_speed), *_CONTACT_SIZES), held, "the drive"))
    return modal_flow(modes), max(mode.condition for mode in modes)


def _in_series(automaton: Automaton, _: float) -> tuple[TaylorFlow, float]:
    """The flow under a friction law with two more states, and its condition."""
    flow, two = automaton.tables.flow, ((0, 0), (0, 2))
    longer = flow._replace(
        field=np.pad(_wider(flow.field), ((0, 0), (0, 2), (0, 0))),
        push=np.pad(flow.push, two),
        contact=_wider(flow.contact),
        speed=_wider(flow.speed),
        settled_place=np.pad(flow.settled_place, two),
        settled_form=np.pad(flow.settled_form, ((0, 0), (0, 2), (0, 2))),
    )
    return longer, automaton.condition


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
