"""The modes of a model with more than two states, in modal form.

The loss of digits of a modal form (:mod:`lsvib.engine.exact.modal_form`) is judged by the typical sizes of the
coordinates and, if they are not good enough, by what changes until some times, beside the sizes that a motion reaches
by then. A mode that would still lose more than six digits is refused: its rates coincide, or lie too far apart.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from lsvib.engine.exact.field import exact_field
from lsvib.engine.exact.modal_arrays import ManyModes, modal_modes
from lsvib.engine.exact.modal_form import ModalMode, guard_forms, modal_flow, modal_mode
from lsvib.engine.exact.pair_arrays import Pairs
from lsvib.engine.exact.reach import reached, slow_reaches
from lsvib.engine.kernels.tables import ModalFlow
from lsvib.errors import EngineError

_MORE_DIGITS = 120  # for rates that lie thirty decades apart, where the usual 60 do not suffice


def linear_mode(
    rows: Sequence[Sequence],
    sizes: Sequence[Any],
    frozen: Mapping[int, Any] | None,
    horizon: float,
    movable: str,
) -> ModalMode | ManyModes:
    """Return a mode of a model, of one drive or of many at once.

    Arguments as of :func:`lsvib.engine.exact.field.exact_field`; the horizon [s] of
    :func:`lsvib.engine.exact.reach.reached`; ``movable``, the parameter to change where two rates coincide. Of many
    drives ``rows`` and ``frozen`` hold ``Pairs`` and ``sizes`` arrays; then there are forms only where all is simple.
    Raises ``EngineError`` for a mode whose rates double precision cannot tell apart.
    """
    for number in (x for row in rows for x in row):
        if isinstance(number, Pairs):
            return modal_modes(rows, sizes, frozen or {}, number.unsafe)
    field = exact_field(rows, sizes, frozen)
    with suppress(ArithmeticError):
        return modal_mode(field)
    reaches = slow_reaches(field, horizon) if horizon < math.inf else None
    field = reached(field, horizon) if reaches is None else replace(field, sizes=reaches[0][1])
    try:
        return modal_mode(field, _MORE_DIGITS, reaches)
    except ArithmeticError as error:
        raise EngineError(
            f"two rates of one mode of motion cannot be told apart in double precision ({error}); "
            f"change {movable}."
        ) from None


def flow_of(modes: Sequence[Any]) -> ModalFlow | list[ModalFlow | None]:
    """Put the modes of a model together in one table; of many drives a list, with None where a mode has no form."""
    if isinstance(modes[0], ManyModes):
        together = zip(*(mode.modes for mode in modes), strict=True)
        return [None if None in own else modal_flow(own) for own in together]
    return modal_flow(modes)


def guard_forms_of(modes: Sequence[Any], rows: Sequence[Sequence[Sequence]]) -> list[list[float]] | None:
    """Return :func:`lsvib.engine.exact.modal_form.guard_forms` of one drive, None of many.

    Guards of many drives at once have the digits of the tables.
    """
    return None if isinstance(modes[0], ManyModes) else guard_forms(modes, rows)
