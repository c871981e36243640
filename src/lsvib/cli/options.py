"""The options that several commands share: their types, and how their texts are read, each in one place."""

import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from lsvib import numbers
from lsvib.drives.pairings import stated
from lsvib.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from lsvib.api import Drive


class Pair(tuple[str, str]):
    """KEY=VALUE; the value stays text, which the drive reads and checks."""


class Coordinate(tuple[str, float]):
    """KEY=NUMBER, in SI units."""


class Span(tuple[str, tuple[float, float]]):
    """KEY=LOW:HIGH, in SI units."""


class Steps(tuple[str, tuple[float, float, int]]):
    """KEY=START:STOP:COUNT, in SI units."""


def _reader(**parts: Callable[[str], Any]) -> Callable[[str], tuple[str, Any]]:
    """Return what reads ``KEY=PART:…`` from text: the key, and its value, or the tuple of them if there are several."""

    def read(text: str) -> tuple[str, Any]:
        """Read the text, or refuse it in one sentence."""
        key, equals, value = text.partition("=")
        texts = value.split(":") if len(parts) > 1 else [value]
        if not (key and equals and value) or len(texts) != len(parts):
            raise InputError(f"{text!r} is not of the form KEY={':'.join(parts).upper()}.")
        try:
            found = tuple(own(part) for own, part in zip(parts.values(), texts, strict=True))
        except numbers.NotNumber as error:
            raise InputError(f"{text} has a part that {error}.") from None
        return key, found if len(found) > 1 else found[0]

    return read


_pair = _reader(value=str)
_coordinate = _reader(number=numbers.number)
_span = _reader(low=numbers.number, high=numbers.number)
_steps = _reader(start=numbers.number, stop=numbers.number, count=numbers.whole)


def _started(text: str) -> tuple[str, float]:
    return _coordinate(text) if "=" in text else (text, 0.0 if text == "rest" else math.nan)


def start_of(given: list[Coordinate] | None) -> "dict[str, float] | Literal['rest'] | None":
    """Return what was given as a start: coordinates by name, the word rest, or nothing."""
    found = dict(given or ())
    for word in (key for key, value in found.items() if value != value):
        raise InputError(f"{word!r} is neither of the form KEY=NUMBER nor the word rest.")
    return "rest" if list(found) == ["rest"] else found or None


def _whole(text: str) -> int:
    try:
        return numbers.whole(text)
    except numbers.NotNumber as error:
        raise InputError(f"{text!r} {error}.") from None


def one(read: Callable[[str], Any], help: str = "") -> Parameter:
    """Return an option whose text ``read`` reads."""
    return Parameter(converter=lambda kind, tokens: read(tokens[0].value), n_tokens=1, accepts_keys=False, help=help)


def several(read: Callable[[str], Any], help: str, **more: Any) -> Parameter:
    """Return an option with several values, each of which ``read`` reads; none of them may have the key of another."""

    def convert(kind: Any, tokens: Sequence[Any]) -> list[tuple[str, Any]]:
        found: dict[str, Any] = {}
        for token in tokens:
            key, value = read(token.value)
            if key in found:
                raise InputError(f"{key} is given twice; give it once.")
            found[key] = value
        return list(found.items())

    # No --no-OPTION, or --empty-OPTION, beside it.
    return Parameter(converter=convert, n_tokens=1, accepts_keys=False, negative="", help=help, **more)


Whole = Annotated[int, one(_whole)]
Workers = Annotated[int, one(_whole, "Number of threads; the result does not depend on it.")]
Start = Annotated[
    list[Coordinate] | None,
    several(
        _started,
        "State at t = 0: u=RAD w=RAD_PER_S ..., or rest; of a system its mode and states.",
        consume_multiple=True,
    ),
]
Over = Annotated[list[Steps], several(_steps, "KEY=START:STOP:COUNT: a parameter to vary; repeatable.")]
Ends = Annotated[Span, one(_span, "KEY=LOW:HIGH: the parameter and its range, around the drive's own value.")]
Window = Annotated[
    list[Span] | None, several(_span, "Part of the phase plane: u=LOW:HIGH w=LOW:HIGH.", consume_multiple=True)
]
GridOfStarts = Annotated[
    list[Steps | Coordinate],
    several(
        lambda text: _steps(text) if ":" in text else _coordinate(text),
        "Two axes KEY=START:STOP:COUNT; KEY=VALUE fixes any other coordinate.",
        consume_multiple=True,
    ),
]
Changes = Annotated[
    list[Pair] | None, several(_pair, "KEY=VALUE: change a parameter of the drive; repeatable.", name="--set")
]
SystemFile = Annotated[
    Path | None, Parameter(help="YAML file of your own system, in place of the drive; --set changes its parameters.")
]
SceneFile = Annotated[Path | None, Parameter(help="YAML file of a scene to start from.")]
OutFile = Annotated[Path, Parameter(help="File to write: netCDF (.nc), or its table alone (.csv).")]
Picture = Annotated[Path | None, Parameter(help="PNG file to draw it to; a PDF is written beside it.")]
AsJson = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object.")]


def drive_of(changes: list[Pair] | None, **others: Any) -> "Drive":
    """Return the drive of Table 8.1 with changes; raises ``InputError``, also for options that drives do not have."""
    from lsvib.api import Drive

    for key in (key for key, given in others.items() if given):
        raise InputError(f"--{key} needs --system.")
    return Drive.of(dict(changes or ()))


def refuse_varied(changes: list[Pair] | None, over: list[Steps]) -> None:
    """Refuse parameters that are varied as well as changed; raises ``InputError``."""
    values = dict(changes or ())
    given = {key.removesuffix("_deg") for key in values}
    if "friction" in values:
        given |= stated(values["friction"]).keys()
    for key in dict(over).keys() & given:
        raise InputError(f"{key} is both varied and set; give it once.")


def values_of(over: list[Steps]) -> "dict[str, np.ndarray]":
    """Return the values of each axis by its key, both ends included; raises ``InputError``."""
    from lsvib.answers.spans import spaced

    return {
        key: spaced(key, start, stop, numbers.whole_between(f"{key}: count", count, 1, 10_000_000))
        for key, (start, stop, count) in over
    }


def refuse_results_of_the_workflow(*files: Path | None) -> None:
    """Refuse files in the folders below ``results`` of the workflow, which could not distinguish them from its own.

    Raises :class:`~lsvib.errors.InputError`.
    """
    for file in filter(None, files):
        try:
            above = list(Path(os.path.realpath(file)).parents)[1:]
        except (OSError, ValueError):
            continue  # it cannot be written at all, which is said where it would be written
        if any(folder.name == "results" and (folder.parent / "Snakefile").is_file() for folder in above):
            raise InputError(f"{file.parent} belongs to the workflow; choose another folder.")


def require_folder(out: Path | None, files: str) -> None:
    """Refuse a folder of the workflow, and the name of a file; ``files`` says what the command writes."""
    refuse_results_of_the_workflow(out and out / files)
    if out is not None and out.suffix in (".csv", ".nc", ".json", ".html", ".png", ".pdf"):
        raise InputError(f"out = {out} names a file, but this command writes {files} to a folder.")


class Files:
    """The dataset and the picture that a command writes: checked before its work begins, both put in place or none."""

    def __init__(
        self, out: Path | None, figure: Path | None = None, reads: Path | None = None, ends: Any = (".nc", ".csv")
    ) -> None:
        from lsvib.files import check_outputs

        refuse_results_of_the_workflow(out, figure)
        if figure is not None and figure.suffix != ".png":
            raise InputError(f"figure = {figure} must end in .png; a PDF is written beside it.")
        self.out, self.figure = out, figure
        self.paths = [path for path in (out, figure, figure and figure.with_suffix(".pdf")) if path]
        check_outputs(self.paths, [reads] if reads else [])
        if out is not None and out.suffix not in ends:
            raise InputError(f"out = {out} must end in {' or '.join(ends)}.")

    def write(self, dataset: "xr.Dataset", command: str = "lsvib", kind: str | None = None) -> None:
        """Write a dataset, and the picture of it, of a ``kind``."""
        from lsvib.answers.io import table_of, write_dataset
        from lsvib.files import replacing

        with replacing(*self.paths) as parts:
            if self.out and self.out.suffix == ".csv":
                table_of(dataset).to_csv(parts[0], index=False, lineterminator="\n")
            elif self.out:
                write_dataset(dataset, parts[0], command)
            if self.figure:
                from lsvib.pictures.answers import draw
                from lsvib.pictures.style import save

                save(draw(dataset, kind), *parts[-2:])
