"""Stability of damped models with two coordinates by LAPACK's eigenvalues, against which conditions are held."""

import numpy as np

from lsvib.stability.linear import UndampedClass, eigenvalues, polynomial


def growth_rate(values, law: int) -> np.ndarray:
    """Largest real part [1/s] of the eigenvalues; positive where steady sliding is unstable."""
    return eigenvalues(values, law)[..., -1].real


def damped_class(values, law: int) -> np.ndarray:
    """Class (:class:`UndampedClass`) of M q″ + C q′ + K q = 0 with C ≠ 0, by its eigenvalues.

    The fastest growing one decides between divergence and flutter; det M < 0 is kinematic whatever the rest.
    """
    fastest = eigenvalues(values, law)[..., -1]
    kinds = [UndampedClass.KINEMATIC_CONSTRAINT, UndampedClass.STABLE, UndampedClass.DIVERGENCE]
    negative = np.broadcast_to(np.asarray(polynomial(values, law)[0]) < 0, fastest.shape)
    return np.select([negative, fastest.real < 0, fastest.imag == 0], kinds, UndampedClass.FLUTTER)
