"""The mapper of a drive, chosen by what its motions are."""

from collections.abc import Sequence

from lsvib.basins.mapper import Mapper
from lsvib.models.drive import Drive
from lsvib.models.friction import depends_on_speed
from lsvib.models.model import model_of


def mapper(drive: Drive, physics: Sequence[str] | None = None) -> Mapper:
    """Return the mapper of a drive, ``physics`` as in a scene; raises ``InputError``.

    For a rigid drive whose motor turns that is a ``PlanarMapper`` or, under a friction law, a ``LawMapper``; else a
    ``StateMapper``.

    >>> import lsvib
    >>> from lsvib.basins.grid import Axis, Grid
    >>> grid = Grid(Axis("u", -0.03, 0.03, 4), Axis("w", -5, 5, 2))
    >>> mapped = mapper(lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10))
    >>> mapped.cells(grid, quantities=("label",))["label"].tolist()
    [[0, 0, 0, 0], [0, 0, 0, 2]]
    """
    definition = model_of(drive)
    physics = (*definition.terms, *definition.options) if physics is None else tuple(physics)
    if not (drive.rigid and drive.input_speed):
        from lsvib.basins.slice_mapper import StateMapper  # each with kernels of its own

        return StateMapper(drive, physics)
    if depends_on_speed(drive):
        from lsvib.basins.law_mapper import LawMapper

        return LawMapper(drive, physics)
    from lsvib.basins.labels import PlanarMapper

    return PlanarMapper(drive, physics)
