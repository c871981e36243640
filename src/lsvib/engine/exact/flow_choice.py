"""Which kind of flow carries a model with more than two states.

The modal form (:mod:`lsvib.engine.exact.modal_form`) is the fast one. Its loss of digits is judged by the typical sizes
of the coordinates and, if they are not good enough, by what changes until some times, beside the sizes that a motion
reaches by then. If the rates of a mode coincide in a way that the modal form does not know, or so nearly that it would
still lose more than six digits, all modes of the model are carried in blocks instead
(:mod:`lsvib.engine.exact.block_form`). A flow is of one type for all modes, because its type chooses the kernels.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from lsvib.engine.exact.block_form import BlockMode, block_flow, block_mode
from lsvib.engine.exact.field import Field, exact_field
from lsvib.engine.exact.modal_arrays import ManyModes, modal_modes
from lsvib.engine.exact.modal_form import ModalMode, guard_forms, modal_flow, modal_mode
from lsvib.engine.exact.pair_arrays import Pairs
from lsvib.engine.exact.reach import reached, slow_reaches
from lsvib.engine.kernels.tables import BlockFlow, ModalFlow

_MORE_DIGITS = 120  # for rates that lie thirty decades apart, where the usual 60 do not suffice


@dataclass(frozen=True)
class LinearMode:
    """The field of a mode, and its modal form if it has one."""

    field: Field
    modal: ModalMode | None
    horizon: float

    @cached_property
    def blocks(self) -> BlockMode:
        """The mode in blocks."""
        return block_mode(reached(self.field, self.horizon))

    @property
    def condition(self) -> float:
        """Largest amplification of rounding by the modal form, or by the blocks where there is none."""
        return self.blocks.condition if self.modal is None else self.modal.condition

    @property
    def time_scales(self) -> list[float]:
        """Time scales [s] of the mode's rates; without a modal form, of the field."""
        if self.modal is None:
            with np.errstate(over="ignore"):  # rates and times beyond all numbers
                rates = np.abs(self.field.table()[:, :-1]) @ self.field.sizes / self.field.sizes
                return [1.0 / rate for rate in rates if rate > 0.0]
        return self.modal.time_scales


def linear_mode(
    rows: Sequence[Sequence],
    sizes: Sequence[Any],
    frozen: Mapping[int, Any] | None = None,
    horizon: Any = math.inf,
) -> LinearMode | ManyModes:
    """Return a mode of a model, of one drive or of many at once.

    Arguments as of :func:`lsvib.engine.exact.field.exact_field`, and the horizon [s] of
    :func:`lsvib.engine.exact.reach.reached`. Of many drives ``rows`` and ``frozen`` hold ``Pairs`` and ``sizes``
    arrays; then there are forms only where all is simple.
    """
    for number in (x for row in rows for x in row):
        if isinstance(number, Pairs):
            return modal_modes(rows, sizes, frozen or {}, number.unsafe)
    field = exact_field(rows, sizes, frozen)
    with suppress(ArithmeticError):
        return LinearMode(field, modal_mode(field), horizon)
    reaches = slow_reaches(field, horizon) if horizon < math.inf else None
    field = reached(field, horizon) if reaches is None else replace(field, sizes=reaches[0][1])
    with suppress(ArithmeticError):
        return LinearMode(field, modal_mode(field, _MORE_DIGITS, reaches), horizon)
    return LinearMode(field, None, horizon)


def flow_of(modes: Sequence[Any]) -> ModalFlow | BlockFlow | list[ModalFlow | None]:
    """Put the modes of a model together in one table, in modal form if all have one, else in blocks.

    Of many drives it is a list of tables, with None where one of the modes has no form.
    """
    if isinstance(modes[0], ManyModes):
        together = zip(*(mode.modes for mode in modes), strict=True)
        return [None if None in own else modal_flow(own) for own in together]
    if any(mode.modal is None for mode in modes):
        return block_flow([mode.blocks for mode in modes])
    return modal_flow([mode.modal for mode in modes])


def guard_forms_of(modes: Sequence[Any], rows: Sequence[Sequence[Sequence]]) -> list[list[float]] | None:
    """Return :func:`lsvib.engine.exact.modal_form.guard_forms` if all modes are in modal form, else None.

    Of many drives at once there are none: their guards have the digits of the tables.
    """
    if isinstance(modes[0], ManyModes):
        return None
    forms = [mode.modal for mode in modes if mode.modal is not None]
    return guard_forms(forms, rows) if len(forms) == len(modes) else None
