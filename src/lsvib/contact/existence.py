"""Existence and uniqueness of the contact force over the phase plane (Sect. 8.1, eq. 8.5, Fig. 8.7)."""

from enum import IntEnum

import numpy as np

from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients


class Existence(IntEnum):
    """How many contact forces solve the rigid-body equations at a state."""

    INCONSISTENT = 0  # none
    UNIQUE = 1
    INDETERMINATE = 2  # two
    BOUNDARY = 3  # Q = 0 or θ′ = 0: the sign functions of (8.3) are not defined


def contact_forces(drive: RigidDrive, u, w) -> np.ndarray:
    """Contact force that each friction law would give, N_s = Q / [Γ_s (cos λ + s μ sin λ)] (eqs 8.5, 8.17).

    Arguments: u [rad], w = u′ [rad/s], arrays of one shape. Returns N₊ and N₋ [N], shape (2, ...). The law is
    admissible where sgn(N_s) sgn(θ′) = s; Γ_s = 0 gives an infinite force.
    """
    c = coefficients(drive)
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    q = q_u * np.asarray(u) + q_w * np.asarray(w) + q_0
    cosine, sine = np.cos(drive.lead_angle), np.sin(drive.lead_angle)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack([q / (float(c.gamma[s]) * (cosine + s * drive.friction_coefficient * sine)) for s in (1, -1)])


def existence(drive: RigidDrive, u, w) -> np.ndarray:
    """Classify states by their number of admissible contact forces; equal shapes in, ``Existence`` (int8) out."""
    forces = contact_forces(drive, u, w)
    direction = np.sign(drive.input_speed + np.asarray(w))
    admissible = [np.sign(force) * direction == s for force, s in zip(forces, (1, -1), strict=True)]
    count = np.where((direction == 0) | (forces[1] == 0), Existence.BOUNDARY, np.sum(admissible, axis=0))
    return count.astype(np.int8)
