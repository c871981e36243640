"""The phase planes of some drives as a dataset, which several figures draw."""

from collections.abc import Sequence

import xarray as xr

from lsvib.datasets.attributes import drive_parameters, labels
from lsvib.figures.settings import Values
from lsvib.models.drive import RigidDrive


def phase_planes(
    settings: Values, drives: Sequence[RigidDrive], varied: tuple[str, ...], printed: tuple[str, ...]
) -> xr.Dataset:
    """Return a phase plane for each drive, a case, with motions from the ``starts`` of the settings.

    ``varied``: parameters in which the drives differ; ``printed``: places of the chapter beyond Table 8.1 that state
    parameters. Variables: :func:`lsvib.datasets.phase_plane.portraits`.
    """
    from lsvib.datasets import phase_plane

    return xr.Dataset(
        phase_plane.portraits(drives, settings["starts"], settings["duration"], settings["samples"]),
        coords={
            **labels("case", drives, varied),
            **drive_parameters(drives, along=varied, printed=printed),
            **phase_plane.rule_coordinate(),
        },
    )
