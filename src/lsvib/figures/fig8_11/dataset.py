"""Figure 8.11: effect of the support damping on the sprag–slip cycle, with the line N = 0 of each damping."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import phase_plane
from lsvib.datasets.attributes import drive_parameters, labels
from lsvib.datasets.checks import Check
from lsvib.dynamics.attractor import Attractor
from lsvib.models.drive import RigidDrive
from lsvib.models.rigid import EventKind

_ROUNDING = 1e-14  # a few rounding errors of the sum of three terms


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the phase plane for each damping; ``settings``: see ``Settings``."""
    drive = RigidDrive.of(settings["drive"])
    drives = [drive.replace(support_damping=c) for c in settings["support_dampings"]]
    return xr.Dataset(
        phase_plane.portraits(drives, settings["starts"], settings["duration"], settings["samples"]),
        coords={
            **labels("case", drives, ("support_damping",)),
            **drive_parameters(drives, along=("support_damping",), printed=("Sect. 8.6", "Sect. 8.6.1")),
            **phase_plane.rule_coordinate(),
        },
        attrs={
            "title": "Figure 8.11: effect of the support damping on the sprag-slip cycle",
            "source": "lsvib, exact event-driven motion and its return map",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.6.1, Fig. 8.11",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the trend of the amplitude, where seizures start, and that the rule of resuming plays no part here."""
    amplitude, damping = dataset.amplitude.values, dataset.support_damping.values
    sprags = dataset.attractor.values == Attractor.SPRAG_SLIP_CYCLE
    seizes = (dataset.event_kind == EventKind.SEIZURE) & (dataset.event_time > 0)
    slope, offset = dataset.contact_line_slope, dataset.contact_line_angle
    terms = [dataset.event_angle_deviation_before, -slope * dataset.event_velocity_deviation_before, -offset]
    distance = abs(sum(terms)) / sum(abs(term) for term in terms)
    worst = float(distance.where(seizes).max())
    count = int(seizes.sum())
    falls = amplitude[:, 0].max(axis=1)
    return [
        Check.everywhere("The motion is a sprag-slip cycle at each damping", "Sect. 8.6.1, Fig. 8.11", sprags),
        Check.holds(
            "The amplitude falls as the damping grows",
            "Sect. 8.6.1, Fig. 8.11",
            ", ".join(f"{a:.5g} rad at c = {c:g} N m s/rad" for a, c in zip(falls, damping, strict=True)),
            bool((np.diff(damping) > 0).all() and (np.diff(amplitude, axis=0) < 0).all()),
        ),
        Check.holds(
            f"Every seizure starts on the line N = 0, to {_ROUNDING:g} of the terms of Q",
            "Sect. 8.6.1, Fig. 8.11, eq. 8.17",
            f"largest distance {worst:.1e} of {count} seizures",
            count > 0 and worst <= _ROUNDING,
        ),
        Check.holds(
            "At these dampings both rules of resuming give the same cycle (Fig. 8.12 shows where they differ)",
            "Sect. 8.6, rule of resuming",
            f"largest difference of the amplitudes {np.abs(np.diff(amplitude, axis=1)).max():.1e} rad",
            bool((np.diff(amplitude, axis=1) == 0).all()),
        ),
    ]
