"""Stability of two-coordinate models by their generalised eigenvalues, whole grids at once."""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.stability import linear
from lsvib.stability.linear import LinearModel


class UndampedClass(IntEnum):
    """Class of the steady sliding of a model with two coordinates; the values are the ``int8`` flags of datasets."""

    STABLE = 0  # no eigenvalue in the right half plane; without damping, all frequencies real
    DIVERGENCE = 1  # a growing motion without oscillation, although the mass matrix has a positive determinant
    FLUTTER = 2  # growing oscillation; without damping, mode coupling
    KINEMATIC = 3  # det M ≤ 0: the kinematic constraint turns an inertia negative (Painlevé's paradoxes)


def reciprocal_squares(model: LinearModel) -> NDArray[np.complex128]:
    """Return 1/ω² of det(K − ω² M) = 0 [s²], both roots along a new last axis; damping plays no part.

    They are the eigenvalues of K⁻¹ M. As det K > 0 in every model here, 1/ω² stays finite where an inertia vanishes and
    ω² passes through infinity (eq. 8.27): a real one then changes its sign in a simple root.
    """
    a_4, _, minus_a_2, _, a_0 = LinearModel(model.mass, ((0, 0), (0, 0)), model.stiffness).polynomial()
    return linear.eigenvalue_pair(a_0, -minus_a_2, a_4)


def undamped_class(model: LinearModel) -> NDArray[np.int8]:
    """Return the :class:`UndampedClass` of M q″ + K q = 0 by its eigenvalues 1/ω², point by point; det K > 0."""
    squares = reciprocal_squares(model)
    # det K > 0, so the product of both 1/ω² has the sign of det M: it is negative for exactly one negative 1/ω².
    complex_pair = squares[..., 0].imag != 0
    lower, upper = squares[..., 0].real, squares[..., 1].real
    kinds = [UndampedClass.FLUTTER, UndampedClass.STABLE, UndampedClass.DIVERGENCE]
    return np.select([complex_pair, lower > 0, upper < 0], kinds, UndampedClass.KINEMATIC_CONSTRAINT).astype(np.int8)


def eigenvalues(model: LinearModel) -> NDArray[np.complex128]:
    """Eigenvalues [1/s] of M q″ + C q′ + K q = 0, shape (..., 4), by LAPACK on the balanced state matrix.

    In ascending real part; they are those of :meth:`LinearModel.jacobian`. det M must not vanish.
    """
    values = np.linalg.eigvals(model.jacobian()).astype(complex)
    return np.take_along_axis(values, np.argsort(values.real, axis=-1), axis=-1)


def routh_hurwitz(polynomial: tuple) -> bool:
    """Whether all roots of p_4 s⁴ + … + p_0, p_4 > 0, have negative real parts; with balls yes is certain."""
    p_4, p_3, p_2, p_1, p_0 = polynomial
    with many_digits():
        hurwitz = (p_3 * p_2 - p_4 * p_1) * p_1 - p_3**2 * p_0
    return all(p > 0 for p in (p_3, p_2, p_1, p_0, hurwitz))
