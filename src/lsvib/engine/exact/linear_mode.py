"""The modes of a model with more than two states, in modal form.

The loss of digits of a modal form (:mod:`lsvib.engine.exact.modal_form`) is judged by the typical sizes of the
coordinates and, if they are not good enough, by what changes until some times, beside the sizes that a motion reaches
by then. A mode that would still lose more than six digits is refused: its rates coincide, or lie too far apart.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

from flint import arb

from lsvib.engine.exact.field import Field, Rows, reached, slow_reaches
from lsvib.engine.exact.modal_form import ModalMode, modal_mode
from lsvib.errors import EngineError


def linear_mode(
    rows: Rows,
    sizes: Sequence[float],
    frozen: Mapping[int, arb | float] | None,
    horizon: float,
    movable: str,
) -> ModalMode:
    """Return a mode of a model.

    Arguments: rows of A and b (n, n + 1), balls or floats; typical sizes of the coordinates (n); ``frozen``,
    coordinates that keep a value in this mode, with that value; the horizon [s] of
    :func:`lsvib.engine.exact.field.reached`; ``movable``, the parameter to change where two rates coincide.
    Raises ``EngineError`` for a mode whose rates double precision cannot distinguish.
    """
    field = Field.of(rows, sizes, frozen)
    with suppress(ArithmeticError):
        return modal_mode(field)
    reaches = slow_reaches(field, horizon) if horizon < math.inf else None
    field = reached(field, horizon) if reaches is None else replace(field, sizes=reaches[0][1])
    try:
        return modal_mode(field, reaches)
    except ArithmeticError as error:
        raise EngineError(
            f"two rates of one mode of motion cannot be distinguished in double precision ({error}); change {movable}."
        ) from None
