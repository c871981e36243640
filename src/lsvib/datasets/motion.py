"""Simulate a scene: the exact motion as a CF dataset, and its summary."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from lsvib import words
from lsvib.datasets import attributes as cf
from lsvib.datasets import phase_plane
from lsvib.dynamics.attractor import Attractor, Doubt, SteadyState, orbit_extremes, steady_state
from lsvib.dynamics.impulses import event_impulses
from lsvib.engine.motion import Budget, Motion, follow
from lsvib.models.drive import Drive, changed, names_and_values, parameters_of
from lsvib.models.scene import Scene, read_yaml

_COMMANDED = (
    "Angles of screw and motor are those from the commanded motion, speeds are less the constant input_speed, not less "
    "the commanded speed, so velocity_deviation is not the rate of angle_deviation."
)


def as_scene(
    scene: Scene | Drive | Mapping[str, Any] | str | Path | None, changes: Mapping[str, Any], drive: Mapping[str, Any]
) -> Scene:
    """Return a checked scene from another, a drive, names and values, or the path of a YAML file, changed.

    Arguments: ``changes`` of keys of the scene, ``drive`` of parameters of its drive. Raises ``InputError``.
    """
    if isinstance(scene, Scene):
        values = scene.model_dump()
    elif isinstance(scene, Drive):
        values = {"drive": scene}
    elif isinstance(scene, (str, Path)):
        values = read_yaml(scene)
    else:
        values = names_and_values("scene", scene)
    values = {**values, **changes}
    if drive:
        values["drive"] = changed(parameters_of(values.get("drive")), drive)
    return Scene.of(values)


def run(scene: Scene, budget: Budget | None = None) -> Motion:
    """Follow the motion of a scene to its end, as far as a ``budget`` suffices (:func:`lsvib.engine.motion.follow`)."""
    definition = scene.definition
    automaton = definition.build(scene.drive, scene.terms, scene.resume, scene.command)
    start = definition.initial_state(scene.drive, scene.start)
    clock = np.zeros(len(automaton.states) - start.size)
    return follow(automaton, np.concatenate([start, clock]), scene.duration, budget=budget)


def trajectory(scene: Scene, motion: Motion) -> xr.Dataset:
    """Return the dataset of a motion of a scene, over ``time`` and ``event``.

    At the time of an event the samples are those after it; impulses are zero in events other than seizures.
    """
    times = np.linspace(0.0, scene.duration, scene.samples)
    states, modes = motion.at(times)
    names, codes = scene.definition.states, motion.automaton.codes
    data: cf.Variables = {name: ("time", states[:, k], cf.quantity(name)) for k, name in enumerate(names)}
    if scene.command:
        data["commanded_speed"] = ("time", scene.command.at(times), cf.quantity("commanded_speed"))
    data["mode"] = cf.flagged("time", codes[modes], "mode of motion", scene.definition.modes)
    for name in scene.outputs:
        data[name] = ("time", motion.automaton.observe(name, states, modes), cf.quantity(name))
        if name in ("normal_force", "axial_contact_force") and motion.automaton.sprag_kinds:
            data[name][2]["comment"] = cf.WITHOUT_IMPULSES
    impulses = event_impulses(scene.drive, motion) if motion.automaton.sprag_kinds else None
    events = phase_plane.events(motion, scene.definition.events, impulses)
    data |= {name: ("event", *known) for name, known in events.items()}
    after = "mode of motion after the event"
    data["event_mode"] = cf.flagged("event", codes[motion.mode], after, scene.definition.modes)
    # Two states are carried without a modal form, so that nothing amplifies rounding.
    form = {} if len(names) == 2 else {"condition_number": motion.automaton.condition}
    return xr.Dataset(
        data,
        coords={
            "time": ("time", times, cf.attributes("s", "time", "$t$")),
            "event": ("event", np.arange(motion.time.size), cf.attributes("1", "index of the event")),
        },
        attrs={
            "title": "Motion of a lead-screw drive",
            "source": "lsvib, exact event-driven simulation",
            "references": f"doi:10.1007/978-1-4419-1752-2_8, {scene.definition.equations}",
            **cf.about_drive(scene.drive, scene.parameters().items()),
            "physics": " ".join(scene.terms),
            "resume": scene.resume,
            "initial_state": json.dumps(dict(scene.start)),
            **({"command": scene.command.model_dump_json(), "comment": _COMMANDED} if scene.command else {}),
            **form,
        },
    )


def attractor_of(scene: Scene, motion: Motion) -> SteadyState:
    """Return what the motion of a scene goes on to from its end, decided by the return map (Poincaré map).

    Under a command it is known where the command has come to ``input_speed`` for good.
    """
    if not scene.command:
        return steady_state(motion.automaton, motion.end_state, mode=motion.end_mode)
    state, drive = motion.end_state[: len(scene.definition.states)], scene.drive
    if scene.command.times[-1] > scene.duration or scene.command.speeds[-1] != drive.input_speed:
        return SteadyState.unresolved(state, Doubt.COMMAND)
    return steady_state(scene.definition.build(drive, scene.terms, scene.resume), state)


def motion_file(scene: Scene, motion: Motion, steady: SteadyState) -> xr.Dataset:
    """Return the dataset of a motion for a file that explains itself: with its drive, its attractor, N and z.

    Added to :func:`trajectory`: the parameters of the scene as variables, ``normal_force`` [N], ``coupling_deflection``
    [rad], and of ``steady``, the :func:`attractor_of` the motion, its label, amplitude [rad] and period [s], the last
    missing unless it is a cycle.
    """
    outputs = tuple(dict.fromkeys((*scene.outputs, "normal_force", "coupling_deflection")))
    dataset = trajectory(scene.model_copy(update={"outputs": outputs}), motion)
    doubt = {} if steady.doubt is None else {"comment": f"unresolved: {steady.doubt}"}
    return dataset.assign(cf.given(scene.parameters().items())).assign(
        attractor=cf.flagged((), steady.label, phase_plane.ATTRACTOR, Attractor, **doubt),
        amplitude=cf.variable((), steady.amplitude, "rad", phase_plane.AMPLITUDE),
        period=cf.variable((), steady.period, "s", phase_plane.PERIOD, "$T$"),
    )


def summary(scene: Scene, motion: Motion, steady: SteadyState | None = None) -> dict[str, Any]:
    """Summarise a motion for JSON; ``steady``, its attractor, is found unless it is given.

    ``final_state`` (the keys of the start, and the mode), ``events`` (count by kind), ``attractor`` (where the
    motion goes on to, decided by the return map; ``unresolved_because`` says why that is not known),
    ``peak_normal_force`` (largest |N| [N] along the motion, without the impulses of seizures), ``status``; for drives
    that seize also ``peak_normal_impulse`` (largest |J_N| of a seizure [N s], zero without one; the impulse of each is
    in the motion's dataset).
    """
    definition, automaton = scene.definition, motion.automaton
    counts = np.bincount(motion.kind, minlength=len(definition.events))
    keys = (*definition.required, *definition.optional)
    steady = steady or attractor_of(scene, motion)
    result = {
        "parts": list(scene.drive.parts),
        "duration": scene.duration,
        "final_state": {
            **dict(zip(keys, (motion.end_state[: len(keys)] + 0.0).tolist(), strict=True)),
            "mode": definition.modes(int(automaton.codes[motion.end_mode])).name.lower(),
        },
        "events": {event.name.lower(): int(counts[event]) for event in definition.events if counts[event]},
        "attractor": steady.label.name.lower(),
        "peak_normal_force": max(map(abs, orbit_extremes(motion, automaton.functional("normal_force")))),
        "status": motion.status.name.lower(),
    }
    if steady.doubt is not None:
        result["unresolved_because"] = str(steady.doubt)
    if automaton.sprag_kinds:
        impulses = event_impulses(scene.drive, motion).normal
        result["peak_normal_impulse"] = float(np.max(np.abs(impulses), initial=0.0))
    return result


def text(summary: Mapping[str, Any]) -> Iterator[str]:
    """Say a :func:`summary` in lines."""
    final, doubt = dict(summary["final_state"]), summary.get("unresolved_because")
    mode = words.plain(final.pop("mode"))
    yield f"final state: {', '.join(f'{key} = {x:.15g}' for key, x in final.items())}, {mode} (SI units)"
    yield f"events: {', '.join(f'{n} {words.plain(kind)}' for kind, n in summary['events'].items()) or 'none'}"
    yield f"attractor: {words.plain(summary['attractor'])}{f': {doubt}' if doubt else ''}"
    yield f"peak normal force: {summary['peak_normal_force']:.10g} N, without the impulses of seizures"
    if summary.get("peak_normal_impulse"):
        yield f"peak normal impulse of a seizure: {summary['peak_normal_impulse']:.10g} N s"
