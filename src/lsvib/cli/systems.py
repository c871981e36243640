"""What commands do where ``--system`` names a file of a system of one's own."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from lsvib.cli import options
from lsvib.cli.app import ProgressLine, show
from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError
from lsvib.words import plain

Start = tuple[str, dict[str, float]]  # mode and state


def read(file: Path, changes: list[options.Pair] | None, start: list[options.Coordinate] | None) -> tuple[Any, Start]:
    """Return the system that a file holds, with changes, and the start, in the first mode unless another is named."""
    from lsvib.systems.api import System

    system = System.of(read_yaml(file, texts=True)).replace(**dict(changes or ()))
    modes = [key for key, value in start or () if value != value or key == "rest"]
    if len(modes) > 1:
        raise InputError(f"start names {len(modes)} modes, {' and '.join(modes)}; give one.")
    state = {key: value for key, value in start or () if key not in modes}
    return system, ((modes or [*system.modes])[0], state)


def simulate(
    given: tuple[Any, Start], duration: float | None, samples: int | None, files: options.Files, as_json: bool
) -> None:
    """Simulate a system."""
    from lsvib.systems.answers import summary

    system, start = given
    if duration is None:
        raise InputError("simulate needs a duration.")
    found, end = system.simulate(*start, duration, samples=samples or 1001), system.steady_state(*start)
    files.write(found, "lsvib.simulate")
    result = summary(found, end)

    def text() -> Iterator[str]:
        final = dict(result["final_state"])
        mode = final.pop("mode")
        yield f"final state: {', '.join(f'{key} = {x:.15g}' for key, x in final.items())}, in mode {mode}"
        yield f"events: {', '.join(f'{n} {plain(kind)}' for kind, n in result['events'].items()) or 'none'}"
        yield from end.text()

    show(result, as_json, text(), files.out)


def cycles(given: tuple[Any, Start], box: Mapping[str, Any], count: int, seed: int, as_json: bool) -> None:
    """Find what motions of a system end on, from a start or from a box of them."""
    system, start = given
    found = system.cycles([] if box else [start], box=box, count=count, seed=seed)
    show(found.to_json(), as_json, found.text())


def follow(given: tuple[Any, Start], over: Any, points: int, files: options.Files, as_json: bool) -> None:
    """Follow the cycle that the motion from a start ends on."""
    from lsvib.systems.answers import branch_dataset, branch_json, branch_text

    system, start = given
    end = system.steady_state(*start)
    if end.cycle is None:
        raise InputError(f"the motion from the start ends on no cycle ({end.label}), so there is none to follow.")
    branch = system.follow(end, *over, points=points, progress=ProgressLine("points"))
    files.write(branch_dataset(branch))
    show(branch_json(branch), as_json, branch_text(branch), files.out)


def sweep(given: tuple[Any, Start], over: Any, files: options.Files, as_json: bool) -> None:
    """Sweep parameters of a system."""
    system, start = given
    _tell(system.sweep(*start, progress=ProgressLine("motions"), **options.values_of(over)), files, as_json)


def attraction(given: tuple[Any, Start], grid: Any, files: options.Files, as_json: bool) -> None:
    """Map the starts of a system."""
    system, (mode, _) = given
    _tell(system.map(dict(grid), mode, progress=ProgressLine()), files, as_json)


def _tell(found: Any, files: options.Files, as_json: bool) -> None:
    from lsvib.variables import counted

    files.write(found)
    kinds = counted(found.behaviour)
    shares = (f"{plain(kind)}: {count} of {found.behaviour.size}" for kind, count in kinds.items())
    show({"points": found.behaviour.size, "kinds": kinds}, as_json, shares, files.out)
