"""What a case at the edge of the domain is: its family, where in it it stands, its drive, start and duration."""

from enum import IntEnum
from typing import Literal, NamedTuple

from lsvib.drives.drive import Drive


class CaseFamily(IntEnum):
    """What is driven to the edge."""

    CONTACT = 0  # contact stiffness and damping of compliant threads
    CRITICAL_MASS = 1  # Γ₊ → 0 from both sides
    FRICTION = 2  # μ → 0, tan λ, cot λ
    INPUT_SPEED = 3  # Ω → 0 and 1e6
    AXIAL_FORCE = 4  # R → 0 and the thresholds from both sides
    SUPPORT_DAMPING = 5  # c = 0 and c → 1e15
    TRANSLATION_DAMPING = 6  # c_x = 0 and c_x → 1e15
    TIME_SPAN = 7
    START = 8  # on guards, on corners, on the equilibrium, at 1e±8
    DOUBLE_RATE = 9  # critical damping, to the last digit
    RANDOM = 10  # every parameter over decades
    SUPPORT = 11  # axial support: its stiffness, damping and mass, with and without friction of slide and bearing
    NUT = 12  # rotating nut, the same
    FRICTION_LAW = 13  # transition speed over Ω, from 1e-6 to 10, with friction at rest up to ten times the kinetic one
    VANISHING_FRICTION = 14  # slope up to where friction is zero in steady sliding, and beyond
    GRAZING = 15  # slip under a law that just touches θ′ = 0
    LAW_AND_PARTS = 16  # transition speed over Ω with motor, guide, bearing, collar, support, nut, threads


FamilyName = Literal[*(family.name.lower() for family in CaseFamily)]


class Case(NamedTuple):
    """One motion: its drive and start, and where in its family it stands.

    ``level`` is the decimal logarithm of what the family varies: of the parameter, or of its relative distance from
    the edge (−inf: on the edge). ``physics``: the frictions of a second body that are there, in the words of a scene.
    """

    family: CaseFamily
    level: float
    drive: Drive
    start: tuple[float, ...]
    duration: float
    physics: tuple[str, ...] = ()
