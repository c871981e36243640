"""Simulate a scene: the exact motion as a CF dataset, and its summary."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
import xarray as xr

from lsvib import words
from lsvib.answers import attributes as cf
from lsvib.answers import phase_plane
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive, changed
from lsvib.drives.observables import TABLE
from lsvib.drives.scene import Scene, read_yaml
from lsvib.dynamics.impulses import Impulses, event_impulses
from lsvib.numbers import names_and_values
from lsvib.systems.attractor import Attractor, Doubt, SteadyState, orbit_extremes, steady_state
from lsvib.systems.motion import Budget, Motion, follow

_COMMANDED = (
    "Angles of screw and motor are relative to the commanded motion, speeds to the constant input_speed, not to the "
    "commanded speed, so w is not the rate of u."
)


def as_scene(
    scene: Scene | Mapping[str, Any] | str | Path | None, changes: Mapping[str, Any], drive: Mapping[str, Any]
) -> Scene:
    """Return a checked scene from another, names and values, or the path of a YAML file, changed.

    Arguments: ``changes`` of keys of the scene, ``drive`` of parameters of its drive. Raises ``InputError``.
    """
    if isinstance(scene, Scene):
        values = scene.model_dump()
    elif isinstance(scene, (str, Path)):
        values = read_yaml(scene)
    else:
        values = names_and_values("scene", scene)
    values = {**values, **changes}
    if drive:
        given = values.get("drive")
        given = given.model_dump() if isinstance(given, Drive) else names_and_values("drive", given)
        values["drive"] = changed(given, drive)
    return Scene.of(values)


@dataclass(frozen=True)
class Simulation:
    """The exact motion of a ``scene``, what is stored of it and what it says."""

    scene: Scene
    motion: Motion

    @classmethod
    def of(cls, scene: Scene, budget: Budget | None = None) -> Self:
        """Follow the motion to its end, as far as a ``budget`` suffices (:func:`lsvib.systems.motion.follow`)."""
        definition = scene.definition
        automaton = automaton_of(scene.drive, scene.resume, scene.command, scene.rests)
        start = definition.initial_state(scene.drive, scene.start)
        clock = np.zeros(len(automaton.states) - start.size)
        return cls(scene, follow(automaton, np.concatenate([start, clock]), scene.duration, budget=budget))

    @cached_property
    def attractor(self) -> SteadyState:
        """What the motion goes on to from its end, decided by the return map (Poincaré map).

        Under a command it is known where the command has come to ``input_speed`` for good.
        """
        scene, motion = self.scene, self.motion
        if not scene.command:
            return steady_state(motion.automaton, motion.end_state, mode=motion.end_mode)
        state = motion.end_state[: len(scene.definition.states)]
        if scene.command.times[-1] > scene.duration or scene.command.speeds[-1] != scene.drive.input_speed:
            return SteadyState.unresolved(state, Doubt.COMMAND)
        return steady_state(automaton_of(scene.drive, scene.resume, rest=scene.rests), state)

    @cached_property
    def _seizures(self) -> Impulses | None:
        """The impulses of each event, of drives that may seize."""
        return event_impulses(self.scene.drive, self.motion) if self.motion.automaton.marks.get("impact") else None

    def dataset(self, outputs: tuple[str, ...] | None = None) -> xr.Dataset:
        """Return the motion over ``time`` and ``event``, with its scene's outputs or others.

        At the time of an event the samples are those after it; impulses are zero in events other than seizures.
        """
        scene, motion, definition = self.scene, self.motion, self.scene.definition
        times, codes, seizures = np.linspace(0.0, scene.duration, scene.samples), motion.automaton.codes, self._seizures
        asked = scene.outputs if outputs is None else outputs
        seen = self._seen(times, *motion.at(times), asked)
        data: cf.Variables = {name: ("time", *known) for name, known in seen.items()}
        if scene.command:
            data["commanded_speed"] = "time", scene.command.at(times), cf.quantity("commanded_speed")
        events = phase_plane.events(motion, definition.events, seizures)
        modes = motion.arcs()[0]
        for when, states, rows in (("before", motion.before, modes[:-1]), ("after", motion.after, modes[1:])):
            seen = self._seen(motion.time, states, rows, asked)
            events |= {f"event_{x}_{when}": (seen[x][0], seen[x][1] | cf.quantity(x, when)) for x in asked}
        after = cf.flagged("event", codes[motion.mode], "mode of motion after the event", definition.modes)
        data |= {name: ("event", *known) for name, known in events.items()} | {"event_mode": after}
        coordinates = {
            "time": cf.variable("time", times, "s", "time", "$t$"),
            "event": cf.variable("event", np.arange(motion.time.size), "1", "index of the event"),
        }
        parameters = scene.parameters().items()
        about = {
            "title": "Motion of a lead-screw drive",
            "source": "lsvib, exact event-driven simulation",
            "references": f"doi:10.1007/978-1-4419-1752-2_8, {definition.equations}",
            **cf.about_drive(scene.drive, parameters),
            "physics": " ".join(scene.terms),
            "resume": scene.resume,
            "initial_state": json.dumps(dict(scene.start)),
        }
        if scene.command:
            about |= {"command": scene.command.model_dump_json(), "comment": _COMMANDED}
        return cf.answer(data | cf.given(parameters), coordinates, about)

    def _seen(self, times: Any, states: Any, rows: Any, asked: tuple[str, ...]) -> phase_plane.WithAttributes:
        """Return the states and what is ``asked`` for at some times, by name."""
        scene, found = self.scene, phase_plane.observed(self.motion, states, rows, self.scene.definition.modes, asked)
        for name in asked:
            if TABLE[name].carried:
                turned = scene.command.angle(times) if scene.command else scene.drive.input_speed * times
                travel = scene.drive.pitch_radius * np.tan(scene.drive.lead_angle) * turned
                found[name] = found[name][0] + travel, found[name][1]
            if TABLE[name].rubbed and self._seizures:
                found[name][1]["comment"] = cf.WITHOUT_IMPULSES
        return found

    def file(self) -> xr.Dataset:
        """Return the dataset for a file that explains itself: with its attractor, N and z.

        Added to :meth:`dataset`: ``normal_force`` [N], ``coupling_deflection`` [rad], and of the attractor its label,
        amplitude [rad] and period [s], the last missing unless it is a cycle.
        """
        outputs = tuple(dict.fromkeys((*self.scene.outputs, "normal_force", "coupling_deflection")))
        steady = self.attractor
        doubt = {} if steady.doubt is None else {"comment": f"unresolved: {steady.doubt}"}
        return self.dataset(outputs).assign(
            attractor=cf.flagged((), steady.label, phase_plane.ATTRACTOR, Attractor, **doubt),
            amplitude=cf.variable((), steady.amplitude, "rad", phase_plane.AMPLITUDE),
            period=cf.variable((), steady.period, "s", phase_plane.PERIOD, "$T$"),
        )

    def to_json(self) -> dict[str, Any]:
        """Return a summary as plain numbers and names.

        ``final_state`` (the keys of the start, and the mode), ``events`` (count by kind), ``attractor`` (where the
        motion goes on to, decided by the return map; ``unresolved_because`` says why that is not known),
        ``peak_normal_force`` (largest |N| [N] along the motion, without the impulses of seizures), ``status``; for
        drives that seize also ``peak_normal_impulse`` (largest |J_N| of a seizure [N s], zero without one; the impulse
        of each is in the motion's dataset).
        """
        motion, definition, steady = self.motion, self.scene.definition, self.attractor
        counts = np.bincount(motion.kind, minlength=len(definition.events))
        final = dict(zip(definition.states, (motion.end_state + 0.0).tolist(), strict=False))
        result = {
            "parts": list(self.scene.drive.parts),
            "duration": self.scene.duration,
            "final_state": final
            | {"mode": definition.modes(int(motion.automaton.codes[motion.end_mode])).name.lower()},
            "events": {event.name.lower(): int(counts[event]) for event in definition.events if counts[event]},
            "attractor": steady.label.name.lower(),
            "peak_normal_force": max(map(abs, orbit_extremes(motion, motion.automaton.functional("normal_force")))),
            "status": motion.status.name.lower(),
        }
        if steady.doubt is not None:
            result["unresolved_because"] = str(steady.doubt)
        if seizures := self._seizures:
            result["peak_normal_impulse"] = float(np.max(np.abs(seizures.normal), initial=0.0))
        return result

    def text(self) -> Iterator[str]:
        """Say the summary in lines."""
        said = self.to_json()
        final, doubt = said["final_state"], said.get("unresolved_because")
        mode = words.plain(final.pop("mode"))
        yield f"final state: {', '.join(f'{key} = {x:.15g}' for key, x in final.items())}, {mode} (SI units)"
        yield f"events: {', '.join(f'{n} {words.plain(kind)}' for kind, n in said['events'].items()) or 'none'}"
        yield f"attractor: {words.plain(said['attractor'])}{f': {doubt}' if doubt else ''}"
        yield f"peak normal force: {said['peak_normal_force']:.10g} N, excluding the impulses of seizures"
        if said.get("peak_normal_impulse"):
            yield f"peak normal impulse of a seizure: {said['peak_normal_impulse']:.10g} N s"
