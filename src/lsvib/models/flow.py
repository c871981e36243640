"""Which kind of flow carries a model with more than two states.

The modal form (:mod:`lsvib.models.modes`) is the fast one. Where rates of a mode coincide in a way that it does not
know, or so nearly that it would lose more than six digits, all modes of the model are carried in blocks instead
(:mod:`lsvib.models.blocks`), since a flow is of one kind: its kernels are chosen by its type.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property

import numpy as np

from lsvib.core.blocks import BlockFlow
from lsvib.core.modal import ModalFlow
from lsvib.models.blocks import BlockMode, block_flow, block_mode
from lsvib.models.field import Field, exact_field
from lsvib.models.modes import ModalMode, modal_flow, modal_mode


@dataclass(frozen=True)
class LinearMode:
    """The field of a mode, and its modal form if it has one."""

    field: Field
    modal: ModalMode | None

    @cached_property
    def blocks(self) -> BlockMode:
        """The mode in blocks."""
        return block_mode(self.field)

    @property
    def condition(self) -> float:
        """Largest amplification of rounding by the modal form, or by the blocks where there is none."""
        return self.blocks.condition if self.modal is None else self.modal.condition

    @property
    def time_scales(self) -> list[float]:
        """Time scales [s] of the mode's rates; without a modal form, of the field."""
        if self.modal is None:
            rates = np.abs(self.field.table()[:, :-1]) @ self.field.sizes / self.field.sizes
            return [1.0 / rate for rate in rates if rate > 0.0]
        return self.modal.time_scales


def linear_mode(
    rows: Sequence[Sequence], sizes: Sequence[float], frozen: Mapping[int, Decimal] | None = None
) -> LinearMode:
    """Return a mode of a model; arguments as of :func:`lsvib.models.field.exact_field`."""
    field = exact_field(rows, sizes, frozen)
    try:
        return LinearMode(field, modal_mode(field))
    except ArithmeticError:
        return LinearMode(field, None)


def flow_of(modes: Sequence[LinearMode]) -> ModalFlow | BlockFlow:
    """Put the modes of a model together in one table, in modal form if all have one, else in blocks."""
    if any(mode.modal is None for mode in modes):
        return block_flow([mode.blocks for mode in modes])
    return modal_flow([mode.modal for mode in modes])
