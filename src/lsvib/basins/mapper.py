"""The region of attraction: the attractor of every start in a grid, how long it takes, and what happens on the way."""

from collections.abc import Sequence

from lsvib.basins.labels import PlanarMapper
from lsvib.basins.mapper import Mapper
from lsvib.basins.slice_mapper import StateMapper
from lsvib.models.drive import Drive
from lsvib.models.model import find_model


def mapper(
    drive: Drive,
    model: str = "rigid",
    physics: Sequence[str] | None = None,
    resume: str = "contact_sign",
    rounding: bool = True,
) -> Mapper:
    """Return the mapper of a drive: a ``PlanarMapper`` for two states, a ``StateMapper`` for more.

    Arguments: drive; name of the model; ``physics`` and ``resume`` as in a scene; ``rounding`` as a
    ``PlanarMapper`` has it. Raises ``InputError``.
    """
    definition = find_model(model)
    physics = (*definition.terms, *definition.options) if physics is None else tuple(physics)
    if len(definition.states) == 2:
        return PlanarMapper(drive, model, physics, resume, rounding)
    return StateMapper(drive, model, physics, resume)
