"""Steady sliding of drives as a dataset: eigenvalues, the conditions of instability, and thresholds.

The analysis of a figure is made once, by the rule ``analyse`` of the workflow, and read by the figure.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np
import xarray as xr

from lsvib.answers.attributes import Variables, drive_parameters, named_index, parameter, variable, yes_no
from lsvib.drives.drive import Drive
from lsvib.errors import InputError, NoThreshold
from lsvib.stability.conditions import stability
from lsvib.stability.threshold import solve_threshold


def analyse(
    drives: Sequence[Drive],
    thresholds: Iterable[tuple[str, str]],
    along: Sequence[str] = (),
    printed: Sequence[str] = (),
) -> xr.Dataset:
    """Analyse the steady sliding of some drives of one class, a ``case`` each.

    Arguments: drives; ``thresholds``, pairs of a name and of the parameter it is solved for; ``along`` and ``printed``
    as of :func:`drive_parameters`. Returns the eigenvalues of (8.18), or of the drive with two coordinates, in
    ascending real part; of the rigid drive the effective inertias and dampings of both laws (8.13) and whether the
    drive is in the region of Painlevé's paradoxes, Γ₊ ≤ 0 (8.4); each threshold with doubles that enclose it, missing
    where it does not exist, with the reason as its comment. Raises ``InputError`` as :meth:`Drive.stability` does.

    >>> import lsvib
    >>> found = analyse([lsvib.Drive(mass=11)], [("kinematic_constraint", "mass")])
    >>> f"{found.kinematic_constraint_mass.item():.6f}", found.paradox_region.item()
    ('10.106965', 1)
    """
    reports = [stability(drive) for drive in drives]
    roots = np.array([report.eigenvalues for report in reports])
    dims, part = ("case", "eigenvalue"), "part of the eigenvalue of steady sliding"
    settles = "whether steady sliding is asymptotically stable"
    found: Variables = {
        "eigenvalue_real_part": variable(dims, roots.real, "s-1", f"real {part}", r"Re $\varepsilon$"),
        "eigenvalue_imaginary_part": variable(dims, roots.imag, "rad s-1", f"imaginary {part}", r"Im $\varepsilon$"),
        "stable": yes_no("case", [report.stable for report in reports], settles),
    }
    for name, first in reports[0].quantities.items():
        values = [report.quantities[name].value for report in reports]
        found[name] = variable("case", np.array(values, dtype=float), first.unit, name.replace("_", " "))
    if reports[0].paradox_region is not None:
        words = "whether the effective inertia of law + is not positive, the region of Painlevé's paradoxes"
        found["paradox_region"] = yes_no("case", [report.paradox_region for report in reports], words)
    for name, unknown in thresholds:
        found |= _threshold(name, unknown, drives)
    return xr.Dataset(
        found,
        coords={
            **drive_parameters(drives, along=along, printed=printed),
            "eigenvalue": variable("eigenvalue", np.arange(1, roots.shape[1] + 1), "1", "index of the eigenvalue"),
            "end": named_index("end", "end of an enclosure", ("low", "high")),
        },
        attrs={
            "title": "Steady sliding of lead-screw drives: eigenvalues, effective inertias and dampings, thresholds",
            "source": "lsvib; signs and enclosures in ball arithmetic",
            "references": "doi:10.1007/978-1-4419-1752-2_8, eqs 8.4, 8.13, 8.18 to 8.21, 8.27",
        },
    )


def value(threshold: xr.DataArray, case: int = 0) -> float:
    """Return a threshold of an analysis as a number; ``InputError`` with the reason if the drive has none."""
    found = float(threshold[case])
    if math.isnan(found):
        raise InputError(f"{threshold.attrs['comment'][0].upper()}{threshold.attrs['comment'][1:]}")
    return found


def _threshold(name: str, unknown: str, drives: Sequence[Drive]) -> Variables:
    """A threshold of some drives, the smallest solution of each, and its enclosure, or why there is none."""
    key, known, reasons = f"{name}_{unknown}", parameter(unknown, ""), dict[str, None]()
    values, ends = np.full(len(drives), math.nan), np.full((len(drives), 2), math.nan)
    for case, drive in enumerate(drives):
        try:
            solved = solve_threshold(drive, name, unknown)
            values[case], ends[case] = solved.value, solved.enclosure
        except NoThreshold as absent:
            reasons[str(absent)] = None  # each once, in their order
    words = f"{known['long_name']} at the threshold {name.replace('_', ' ')}"
    more = {"comment": " ".join(reasons)} if reasons else {}
    return {
        key: variable("case", values, known["units"], words, known["symbol"], **more),
        f"{key}_enclosure": variable(("case", "end"), ends, known["units"], f"{words}, enclosure"),
    }
