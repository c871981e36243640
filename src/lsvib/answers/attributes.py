"""Variables of datasets with their attributes, and the parameters of drives as such, with where their values come from.

Functions return variables ``(dimensions, values, attributes)`` as ``xarray.Dataset`` takes them, or several by name.
What the ``origin`` of a parameter says, so that whoever opens a file can repeat it, is in ``docs/design.md``.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from lsvib.drives import chapter
from lsvib.drives.drive import Drive
from lsvib.drives.names import WORDS
from lsvib.drives.observables import TABLE
from lsvib.variables import *  # noqa: F403  # so that all of these functions are in one place
from lsvib.variables import Dims, Variables, attributes, flags, named_index, variable


def about_drive(drive: Drive, parameters: Iterable[tuple[str, Any]]) -> dict[str, str]:
    """Return the attributes of a file that name the parts of a drive, and some of its parameters as JSON."""
    return {"parts": " ".join(drive.parts) or "none", "parameters": json.dumps(dict(parameters))}


def quantity(name: str, when: str = "") -> dict[str, str]:
    """Return ``long_name``, ``units`` and ``symbol`` of a quantity of a drive, before or after an event if so said."""
    long_name, units, symbol = WORDS[name] if name in WORDS else TABLE[name].words
    return {"long_name": f"{long_name}, {when} the event" if when else long_name, "units": units, "symbol": symbol}


CRITICAL_MASS = attributes("kg", "critical mass of the rigid drive (8.20)", r"$m_\mathrm{cr}$")
# Of events: the impulses of seizures, zero in other events, and a sign.
IMPULSES = {
    "normal_impulse": attributes("N s", "normal impulse of the threads at the event"),
    "axial_impulse": attributes("N s", "axial impulse of the threads at the event"),
    "torque_impulse": attributes("N m s", "angular impulse of the threads at the event"),
}
WITHOUT_IMPULSES = "excludes the impulses of seizures, which are in event_normal_impulse"
SIGNS = attributes(
    "1",
    "sign of the impulse of a seizure, or of the normal force after a contact reversal",
    **flags({-1: "negative", 0: "none", 1: "positive"}),
)

ASSUMED = "assumed: not stated in the text"
GIVEN = "given: set by the user"
VARIED = "varied: an axis of this file"
NO_EFFECT = "no effect: the results in this file do not depend on it"
# In front of the name of a parameter that a file needs twice: along what it varies, or of what it is.
QUALIFIERS = ("swept", "grid", "curve", "growth", "boundary", "reading", "case", "drawn")


def _fields(kind: type[Drive] = Drive) -> dict[str, Any]:
    """What the classes of drives that are loaded say of their parameters, by name."""
    fields = {name: field.json_schema_extra for name, field in kind.model_fields.items()}
    for more in kind.__subclasses__():
        fields = _fields(more) | fields
    return fields


FIELDS = _fields()
_GREEK = re.compile(r"\b(Omega|lambda|mu|Delta|delta)(?![a-z])")


def parameter(name: str, origin: str, **more: Any) -> dict[str, Any]:
    """Return the attributes of a parameter, whose name may bear one of :data:`QUALIFIERS`, with its ``origin``."""
    qualifier, _, rest = name.partition("_")
    fields = FIELDS if name in FIELDS or rest in FIELDS else _fields()  # of a model that was loaded since
    known = fields[rest if name not in fields and qualifier in QUALIFIERS else name]
    symbol = _GREEK.sub(r"\\\1", known["symbol"])
    return attributes(known["unit"], known["long_name"], f"${symbol}$", origin=origin, **more)


def given(values: Iterable[tuple[str, Any]]) -> Variables:
    """Return names and values of a drive's parameters as variables; all but the defaults were given."""
    default, places = {name: field.default or 0.0 for name, field in Drive.model_fields.items()}, tuple(chapter.STATED)
    origins = ((n, x, GIVEN if x != default.get(n, 0.0) else origin_of(n, x, places)) for n, x in values)
    return {name: ((), value, parameter(name, origin)) for name, value, origin in origins}


def varied(dims: Dims = "", origin: str = VARIED, /, **values: Any) -> Variables:
    """Return parameters that a file varies, by name: each an axis (its dimension has its name), or along ``dims``."""
    return {name: (dims or name, np.asarray(own, dtype=float), parameter(name, origin)) for name, own in values.items()}


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
    """Return every parameter of some drives of one class as variables, of several drives with their coordinate ``dim``.

    That is an index whose ``flag_meanings`` name what makes each of them: what is ``along``, or else what differs.
    Arguments: a drive, or several along ``dim``; parameters that differ by design and therefore lie ``along`` it even
    where they agree; places of the chapter whose values the drives may have, keys of :data:`chapter.STATED`; parameters
    that are ``assumed`` although Table 8.1 states their value, for other drives; parameters that have ``no_effect``;
    those which are ``axes`` of the file and therefore are left out here.
    """
    row, result = [drives] if isinstance(drives, Drive) else list(drives), Variables()
    if not isinstance(drives, Drive):
        names = along or [name for name in Drive.model_fields if len({getattr(drive, name) for drive in row}) > 1]
        words = ["_".join(f"{name}_{getattr(drive, name)!r}" for name in names) or "drive" for drive in row]
        result[dim] = named_index(dim, f"index of the {dim}", words)
    own = {name for drive in row for name, _ in drive}
    for name in Drive.model_fields:
        if name in axes or name not in own:
            continue
        values = np.array([getattr(drive, name) for drive in row])
        origin = NO_EFFECT if name in no_effect else ASSUMED if name in assumed else origin_of(name, values, printed)
        shared = name not in along and (values == values[0]).all()
        result[name] = ((), values[0], parameter(name, origin)) if shared else (dim, values, parameter(name, origin))
    return result


def origin_of(name: str, values: Any, printed: Sequence[str] = ()) -> str:
    """Return where the values of a parameter come from, of Table 8.1 and the ``printed`` places: the first of each."""
    stated: Mapping[str, Mapping[str, tuple[float, ...]]] = chapter.STATED
    kinds = np.unique(values).tolist()
    places = ("Table 8.1", *printed)
    first = {x: next((place for place in places if x in stated[place].get(name, ())), "") for x in kinds}
    known = {x: place for x, place in first.items() if place}
    if len(known) == len(kinds):
        return f"printed: {', '.join(dict.fromkeys(known.values()))}"
    if not known:
        return ASSUMED
    return f"{ASSUMED}, except {', '.join(f'{value:g} (printed: {place})' for value, place in known.items())}"


def start_state(start: Mapping[str, float], words: str) -> Variables:
    """Return the state that motions start from, u [rad] and w [rad/s]; ``words`` say which motions."""
    u, w, rate = float(start["u"]), float(start["w"]), "rate of the deviation at the start"
    return {
        "initial_u": variable((), u, "rad", "deviation at the start", "$u$", comment=words),
        "initial_w": variable((), w, "rad s-1", rate, r"$\dot u$", comment=words),
    }
