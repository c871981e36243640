"""Linear stability of the steady sliding of the rigid drive: eigenvalues (8.18) and their class."""

from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Stability(IntEnum):
    """Class of the steady sliding by its eigenvalues; the values are the ``int8`` flags of datasets."""

    STABLE_NODE = 0
    STABLE_FOCUS = 1
    CENTRE = 2
    UNSTABLE_FOCUS = 3
    UNSTABLE_NODE = 4
    SADDLE = 5
    DEGENERATE = 6


def eigenvalues(inertia: ArrayLike, damping: ArrayLike, stiffness: ArrayLike) -> NDArray[np.complex128]:
    """Eigenvalues of Γ_0 ü + C_0 u̇ + k u = 0 at the origin (8.18), to full precision also where they nearly coincide.

    Arguments: effective inertia Γ_0 [kg m²], effective damping C_0 [N m s/rad], stiffness k [N m/rad]; of any
    sign; shapes that broadcast. Returns complex numbers [1/s] of the broadcast shape with a last axis of
    two, in ascending real part, then ascending imaginary part. The larger root is formed without subtraction and the
    other one from the product k/Γ_0. Where Γ_0 = 0 the motion is of first order: −k/C_0 first, then NaN, as there is no
    second eigenvalue.
    """
    gamma, c, k = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (inertia, damping, stiffness)))
    discriminant = _discriminant(gamma, c, k)
    sign = np.where(c < 0, -1.0, 1.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        root = np.sqrt(np.abs(discriminant))
        q = -(c + sign * root) / 2
        first = q / gamma
        # q vanishes only with C_0 = 0 and k Γ_0 = 0, where both eigenvalues are zero.
        second = np.where(q == 0, 0.0, k / q)
        pair = np.stack([np.fmin(first, second) + 0j, np.fmax(first, second) + 0j], axis=-1)
        centre = -c / (2 * gamma)
        half = np.abs(root / (2 * gamma))
        focus = np.stack([centre - 1j * half, centre + 1j * half], axis=-1)
        flat = np.stack([-k / c + 0j, np.full_like(c, np.nan) + 0j], axis=-1)
    pair = np.where((discriminant < 0)[..., None], focus, pair)
    return np.where((gamma == 0)[..., None], flat, pair)


def stability_class(inertia: ArrayLike, damping: ArrayLike, stiffness: ArrayLike) -> NDArray[np.int8]:
    """Class of the steady sliding (:class:`Stability`) by its eigenvalues (8.18); arguments as :func:`eigenvalues`.

    k > 0. A pair that coincides counts as a node, Γ_0 = 0 as degenerate.
    """
    pair = eigenvalues(inertia, damping, stiffness)
    low, high = pair[..., 0], pair[..., 1]
    oscillates = high.imag != 0
    first_of = {
        Stability.DEGENERATE: np.isnan(high.real),
        Stability.STABLE_FOCUS: oscillates & (high.real < 0),
        Stability.UNSTABLE_FOCUS: oscillates & (high.real > 0),
        Stability.CENTRE: oscillates,
        Stability.STABLE_NODE: high.real < 0,
        Stability.UNSTABLE_NODE: low.real > 0,
    }
    return np.select([*first_of.values()], [*first_of], Stability.SADDLE).astype(np.int8)


def _rounded_product(a: NDArray, b: NDArray) -> tuple[NDArray, NDArray]:
    """Return the rounded product of doubles and what its rounding has cut off, by Dekker's splitting (1971)."""
    halves = []
    for x in (a, b):
        t = (2.0**27 + 1) * x
        high = t - (t - x)
        halves.append((high, x - high))
    (a1, a2), (b1, b2), product = *halves, a * b
    return product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2


def _discriminant(gamma: NDArray, c: NDArray, k: NDArray) -> NDArray:
    """C_0² − 4kΓ_0 with the rounding errors of both products added back, so nearly equal roots keep their digits."""
    (square, of_square), (product, of_product) = _rounded_product(c, c), _rounded_product(4 * k, gamma)
    return (square - product) + (of_square - of_product)
