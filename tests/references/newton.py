"""Steady sliding straight from Newton's laws in many digits, by the laws of ``sliding_friction.py``.

Independent of ``lsvib.stability``: no matrices of mass, damping and stiffness, and stability
by eigenvalues of the state matrix or by Routh's array of its characteristic polynomial.
"""

import mpmath
from flint import arb, ctx
from mpmath import mpf

from references.sliding_friction import SlidingDrive

DIGITS = 250  # rates of random drives lie up to 30 decades apart, and the polynomial has products of four of them

_ROUNDING = mpf(10) ** -100  # far below what doubles can come to by chance, far above DIGITS
_SPARE = 60  # digits that may be lost where the accelerations are solved for


def solved(function, model: str, drive):
    """What a function of the laws of a drive is, in the digits that mpmath works with."""
    with ctx.workdps(mpmath.mp.dps + _SPARE):
        found = function(SlidingDrive(model, drive))
        return found if isinstance(found, list | int) else mpf(found.mid())


def steady_law(drive) -> int:
    """Law of steady sliding by the force on the contact; 0 if there is none."""
    return solved(lambda laws: laws.law, "rigid", drive)


def state_matrix(model: str, drive, law: int) -> list[list[mpf]]:
    """State matrix; its columns are the rates at unit states, because without loads the equations are homogeneous."""

    def rates(laws: SlidingDrive) -> list[list[mpf]]:
        laws.law, laws.sense = law, 0
        laws.p |= {"axial_force": arb(0), "input_speed": arb(0)}
        size = 2 if model == "rigid" else 4
        columns = [laws.rates([arb(int(i == j)) for i in range(size)]) for j in range(size)]
        rows = zip(*columns, strict=True)
        return [[mpf(0) if x.contains(0) else mpf(x.mid()) for x in row] for row in rows]

    return solved(rates, model, drive)


def eigenvalues(model: str, drive, law: int) -> list[mpmath.mpc]:
    """Eigenvalues [1/s] of the state matrix in ascending real, then imaginary part."""
    found = mpmath.eig(mpmath.matrix(state_matrix(model, drive, law)), left=False, right=False)
    return sorted(found, key=lambda z: (float(mpmath.re(z)), float(mpmath.im(z))))


def is_stable(model: str, drive, law: int) -> bool:
    """Whether all eigenvalues have negative real parts: Routh's array of the polynomial by Faddeev and LeVerrier."""
    a = state_matrix(model, drive, law)
    size, power, polynomial = len(a), [], [mpf(1)]
    for k in range(size):
        shifted = [
            [(power[i][j] if power else 0) + (polynomial[-1] if i == j else 0) for j in range(size)]
            for i in range(size)
        ]
        power = [[sum(a[i][n] * shifted[n][j] for n in range(size)) for j in range(size)] for i in range(size)]
        polynomial.append(-sum(power[i][i] for i in range(size)) / (k + 1))
    first, second = polynomial[0::2], polynomial[1::2]
    while second:
        if second[0] <= 0:
            return False
        padded = second + [mpf(0)] * (len(first) - len(second))
        terms = [(b, first[0] / second[0] * c) for b, c in zip(first[1:], padded[1:], strict=True)]
        # What is left of a difference by rounding is zero, as with a mode that no damping reaches.
        first, second = second, [b - c if abs(b - c) > _ROUNDING * (abs(b) + abs(c)) else mpf(0) for b, c in terms]
    return True
