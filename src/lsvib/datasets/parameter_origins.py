"""The parameters of the drives behind a dataset, each with the place that its value comes from.

Whoever opens a file shall be able to repeat it: every parameter of its drives is a variable of the file under the name
that it has in :mod:`lsvib.models.drive`, without dimensions where all drives share the value, else along theirs.
Its attribute ``origin`` begins with one of five words:

* ``printed: Table 8.1``, or another place of the chapter;
* ``assumed: not stated in the text``; if some of several values are printed they follow after ``except``;
* ``varied: an axis of this file``;
* ``given: by whoever asked for this file``, of a single motion or of a map;
* ``of no effect: the results of this file do not depend on it``, but for the sign of a product that the file names.

A parameter that a file needs twice bears a qualifier in front, one of :data:`QUALIFIERS`.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lsvib.datasets.attributes import attributes, named_index, variable
from lsvib.models import chapter
from lsvib.models.drive import Drive

ASSUMED = "assumed: not stated in the text"
GIVEN = "given: by whoever asked for this file"
VARIED = "varied: an axis of this file"
NO_EFFECT = "of no effect: the results of this file do not depend on it"
# In front of a parameter's name: along a sweep, a grid, a curve, growth rates or a boundary; of readings of the text;
# of the cases, where the name alone is that of the drive that they change; of what is drawn.
QUALIFIERS = ("swept", "grid", "curve", "growth", "boundary", "reading", "case", "drawn")


def _fields(kind: type[Drive] = Drive) -> dict[str, Any]:
    """What the classes of drives that are loaded say of their parameters, by name."""
    fields = {name: field.json_schema_extra for name, field in kind.model_fields.items()}
    for more in kind.__subclasses__():
        fields = _fields(more) | fields
    return fields


FIELDS = _fields()
_GREEK = ("Omega", "lambda", "mu")

Variables = dict[str, tuple]


def parameter(name: str, origin: str, **more: Any) -> dict[str, Any]:
    """Return the attributes of a parameter, whose name may bear one of :data:`QUALIFIERS`, with its ``origin``."""
    qualifier, _, rest = name.partition("_")
    fields = FIELDS if name in FIELDS or rest in FIELDS else _fields()  # of a model that was loaded since
    known = fields[rest if name not in fields and qualifier in QUALIFIERS else name]
    symbol = f"$\\{known['symbol']}$" if known["symbol"] in _GREEK else f"${known['symbol']}$"
    return attributes(known["unit"], known["long_name"], symbol, origin=origin, **more)


def axis(name: str, values: Any, dims: str | tuple[str, ...] = "", origin: str = VARIED) -> Variables:
    """Return a parameter as the axis of a file (its dimension has its name), or along the dimensions ``dims``."""
    return {name: (dims or name, np.asarray(values, dtype=float), parameter(name, origin))}


def drive_parameters(
    drives: Drive | Sequence[Drive],
    dim: str = "case",
    *,
    along: Sequence[str] = (),
    printed: Sequence[str] = (),
    assumed: Sequence[str] = (),
    no_effect: Sequence[str] = (),
    axes: Sequence[str] = (),
) -> Variables:
    """Return every parameter of some drives of one class as variables.

    Arguments: a drive, or several along ``dim``; parameters that differ by design and therefore lie ``along`` it even
    where they agree; places of the chapter whose values the drives may have, keys of :data:`chapter.STATED`; parameters
    that are ``assumed`` although Table 8.1 states their value, for other drives; parameters that have ``no_effect``;
    those which are ``axes`` of the file and therefore are left out here.
    """
    row = [drives] if isinstance(drives, Drive) else list(drives)
    result = {}
    for name in type(row[0]).model_fields:
        if name in axes:
            continue
        values = np.array([getattr(drive, name) for drive in row])
        origin = NO_EFFECT if name in no_effect else ASSUMED if name in assumed else origin_of(name, values, printed)
        shared = name not in along and (values == values[0]).all()
        result[name] = ((), values[0], parameter(name, origin)) if shared else (dim, values, parameter(name, origin))
    return result


def origin_of(name: str, values: Any, printed: Sequence[str] = ()) -> str:
    """Return where the values of a parameter come from, of Table 8.1 and the ``printed`` places."""
    places = {value: _place(name, value, printed) for value in np.unique(values).tolist()}
    known = {value: place for value, place in places.items() if place}
    if len(known) == len(places):
        return f"printed: {', '.join(sorted(set(known.values()), key=list(known.values()).index))}"
    if not known:
        return ASSUMED
    return f"{ASSUMED}, except {', '.join(f'{value:g} (printed: {place})' for value, place in known.items())}"


def _place(name: str, value: float, printed: Sequence[str]) -> str:
    """The first place that states this value of a parameter; empty if none does."""
    stated: Mapping[str, Mapping[str, tuple[float, ...]]] = chapter.STATED
    return next((place for place in ("Table 8.1", *printed) if value in stated[place].get(name, ())), "")


def labels(dim: str, drives: Sequence[Drive], names: Sequence[str]) -> Variables:
    """Return the coordinate of some drives: an index, whose ``flag_meanings`` name what makes each of them.

    ``names``: the parameters in which they differ; without any, the only one is called ``drive``.
    """
    words = ["_".join(f"{name}_{getattr(drive, name)!r}" for name in names) or "drive" for drive in drives]
    return {dim: named_index(dim, f"index of the {dim}", words)}


def start_state(start: Mapping[str, float], words: str) -> Variables:
    """Return the state that motions start from, u [rad] and w [rad/s]; ``words`` say which motions."""
    u, w, about = float(start["u"]), float(start["w"]), {"comment": words}
    rate = "rate of the deviation at the start"
    return {
        "initial_angle_deviation": variable((), u, "rad", "deviation at the start", "$u$", **about),
        "initial_velocity_deviation": variable((), w, "rad s-1", rate, r"$\dot u$", **about),
    }
