"""Figure 8.3: stability of the steady sliding over effective inertia and damping, by eigenvalues (8.18)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import spans
from lsvib.datasets.attributes import attributes, drive_parameters, flagged, labels, variable
from lsvib.datasets.checks import Check
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients
from lsvib.stability.linear import Stability, eigenvalue_pair, stability_class

_HALVINGS = 100  # to the last bit, also where the boundary lies decades below its bracket
_CHANGED = ("mass", "translation_damping")  # in which the drives that are placed differ
_INERTIA = attributes("kg m2", "effective inertia", r"$\Gamma_0$")
_DAMPING = attributes("N m s rad-1", "effective damping", "$C_0$")


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the class map, the node–focus boundary and the place of the chapter's drives."""
    drive = RigidDrive.of(settings["drive"])
    stiffness = drive.coupling_stiffness
    inertia, damping = spans.even(settings["inertia"]), spans.even(settings["damping"])
    kinds = stability_class(inertia[:, None], damping[None, :], stiffness)
    positive = inertia[-1] * np.linspace(0, 1, inertia.size)[1:] ** 2  # dense near the vertex of the parabola
    meet, along = _node_focus_boundary(positive, stiffness), "node_focus_effective_inertia"
    cases = [drive.replace(**changes) for changes in settings["cases"]]
    own = [(float(c.gamma[c.steady_law]), float(c.damping[c.steady_law])) for c in map(coefficients, cases)]
    return xr.Dataset(
        {
            "stability": flagged(
                ("effective_inertia", "effective_damping"), kinds, "class of the steady sliding", Stability
            ),
            "node_focus_effective_damping": variable(
                "node_focus_effective_inertia",
                meet,
                "N m s rad-1",
                "effective damping where two eigenvalues meet",
                "$C_0$",
            ),
            "case_effective_inertia": ("case", [inertia for inertia, _ in own], _INERTIA),
            "case_effective_damping": ("case", [damping for _, damping in own], _DAMPING),
        },
        coords={
            "effective_inertia": ("effective_inertia", inertia, _INERTIA),
            "effective_damping": ("effective_damping", damping, _DAMPING),
            along: (along, positive, _INERTIA),
            **labels("case", cases, _CHANGED),
            **drive_parameters(cases, along=_CHANGED, printed=("Sect. 8.5.1", "Sect. 8.6.1", "Sect. 8.6")),
        },
        attrs={
            "title": "Figure 8.3: stability of the steady sliding over effective inertia and effective damping",
            "source": "lsvib, eigenvalues in closed form (8.18)",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.4, Fig. 8.3",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the class map against the conditions of Sect. 8.4 and against eigenvalues of the matrix itself (LAPACK)."""
    inertia = dataset.effective_inertia.values[:, None]
    damping = dataset.effective_damping.values[None, :]
    kinds = dataset.stability.values
    stiffness = float(dataset.coupling_stiffness)
    regular = kinds != Stability.DEGENERATE
    stable = np.isin(kinds, [Stability.STABLE_NODE, Stability.STABLE_FOCUS])
    wrong = int(np.sum(regular & (stable != ((inertia > 0) & (damping > 0)))))
    saddles = (kinds == Stability.SADDLE) == (inertia < 0)
    ratio = dataset.node_focus_effective_damping**2 / (4 * stiffness * dataset.node_focus_effective_inertia)
    worst = float(ratio[int(np.argmax(np.abs(ratio.values - 1)))])
    largest = _distance_from_lapack(inertia, damping, stiffness)
    return [
        Check.holds(
            "Steady sliding is stable exactly where Γ_0 > 0 and C_0 > 0",
            "Sect. 8.4, Fig. 8.3",
            f"{wrong} exceptions among {int(regular.sum())} points",
            wrong == 0 and bool(stable.any()),
        ),
        Check.without_exception(
            "Γ_0 < 0 gives a saddle whatever the damping",
            "Sect. 8.4, eq. 8.20",
            np.sum(regular & ~saddles),
            regular.sum(),
        ),
        Check.within(
            "C_0²/(4kΓ_0) where node and focus meet (worst point of the curve)",
            "eq. 8.18",
            expected=1.0,
            computed=worst,
            tolerance=1e-12,
            unit="1",
            tolerance_reason="the curve is exact; rounding only",
        ),
        Check.holds(
            "The closed form gives the eigenvalues of the Jacobian matrix up to 1e-7 of the larger one",
            "eq. 8.18",
            f"largest difference {largest:.1e}",
            largest < 1e-7,  # LAPACK keeps only half of the digits (1.5e-8) where two eigenvalues coincide
        ),
    ]


def _node_focus_boundary(inertia: np.ndarray, stiffness: float) -> np.ndarray:
    """Damping [N m s/rad] at which the eigenvalues turn real, by bisection on the eigenvalues themselves."""
    focus, node = np.zeros_like(inertia), 4 * np.sqrt(stiffness * inertia)
    for _ in range(_HALVINGS):
        middle = (focus + node) / 2
        oscillates = eigenvalue_pair(inertia, middle, stiffness)[:, 1].imag != 0
        focus, node = np.where(oscillates, middle, focus), np.where(oscillates, node, middle)
    return node


def _distance_from_lapack(inertia: np.ndarray, damping: np.ndarray, stiffness: float) -> float:
    """Largest difference [1] of (8.18) from LAPACK's eigenvalues of the Jacobian, relative to the larger eigenvalue."""
    gamma, c = (array.ravel() for array in np.broadcast_arrays(inertia, damping))
    gamma, c = gamma[gamma != 0], c[gamma != 0]
    jacobian = np.zeros((gamma.size, 2, 2))
    jacobian[:, 0, 1], jacobian[:, 1, 0], jacobian[:, 1, 1] = 1, -stiffness / gamma, -c / gamma
    theirs = np.sort_complex(np.linalg.eigvals(jacobian).astype(complex))
    ours = eigenvalue_pair(gamma, c, stiffness)
    return float(np.max(np.abs(ours - theirs) / np.abs(ours).max(axis=1, keepdims=True)))
