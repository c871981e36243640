"""The mapper of a drive, chosen by what its motions are."""

from collections.abc import Sequence

from lsvib.basins.mapper import Mapper
from lsvib.models.drive import Drive
from lsvib.models.friction import depends_on_speed
from lsvib.models.model import model_of


def mapper(drive: Drive, physics: Sequence[str] | None = None) -> Mapper:
    """Return the mapper of a drive: for a rigid one a ``PlanarMapper`` or, under a friction law, a ``LawMapper``.

    For any other drive it is a ``StateMapper``.

    Arguments: drive; ``physics`` as in a scene. Raises ``InputError``.

    >>> import lsvib
    >>> from lsvib.basins.grid import Axis, Grid
    >>> grid = Grid(Axis("u", -0.03, 0.03, 4), Axis("w", -5, 5, 2))
    >>> mapped = mapper(lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10))
    >>> mapped.cells(grid, quantities=("label",))["label"].tolist()
    [[0, 0, 0, 0], [0, 0, 0, 2]]
    """
    definition = model_of(drive)
    physics = (*definition.terms, *definition.options) if physics is None else tuple(physics)
    if drive.rigid and not depends_on_speed(drive):
        from lsvib.basins.labels import PlanarMapper  # each with kernels of its own

        return PlanarMapper(drive, physics)
    if drive.rigid:
        from lsvib.basins.law_mapper import LawMapper

        return LawMapper(drive, physics)
    from lsvib.basins.slice_mapper import StateMapper

    return StateMapper(drive, physics)
