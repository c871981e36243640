"""Newton's laws of steady sliding (:class:`references.bodies.Bodies`), linearised with many digits.

Stability is by eigenvalues, or by Routh's array of the characteristic polynomial.
"""

import mpmath
import numpy as np
from flint import acb_mat, arb, arb_mat, ctx
from mpmath import mpf

from .bodies import Bodies

DIGITS = 250  # rates of random drives lie up to 30 decades apart, and the polynomial has products of four of them
FEWER = 80  # under a law, whose slope is a difference
STEP = arb(10) ** -25  # of a central difference, over the input speed


def laws_of(model, drive) -> Bodies:
    """The laws of a drive of a model."""
    return Bodies(drive, parts=() if model == "rigid" else (model,))


def linearised(laws: Bodies, mode: dict, state=None) -> arb_mat:
    """State matrix of a mode; under a law of friction that at a state."""
    slip = laws.values([laws.slip], state if state is not None else [0] * laws.size)[0]
    rows = laws.rates(mode, laws.mu(slip))
    if state is not None:
        step = STEP * laws.p["input_speed"]
        ends = (laws.values(laws.rates(mode, laws.mu(slip + way * step)), state) for way in (1, -1))
        rows = rows + np.outer([(a - b) / (2 * step) for a, b in zip(*ends, strict=True)], laws.slip)
    return arb_mat([list(row[: laws.size]) for row in rows[: laws.size]])


def eigenvalues_of_sliding(drive) -> list[mpmath.mpc]:
    """Eigenvalues [1/s] of the steady sliding of a drive, in ascending real part."""
    with ctx.workdps(FEWER):
        laws = Bodies(drive)
        state, mode, mu = list(laws.steady), laws.sliding, laws.mu(laws.p["input_speed"])
        if "e" in laws.place:  # which is counted from no force
            bears = laws.cos + laws.steady_law * mu * laws.sin
            state[laws.place["e"]] = laws.axial / (bears * laws.cos * laws.p["contact_stiffness"])
        assert all(rate.contains(0) for rate in laws.values(laws.rates(mode, mu)[: laws.size], state))  # of rest
        found = acb_mat(linearised(laws, mode, state).mid()).eig(nonstop=True)
        found = sorted(found, key=lambda x: (float(x.real), float(x.imag)))
    with mpmath.workdps(FEWER):
        return [mpmath.mpc(*(part.str(FEWER, radius=False) for part in (x.real, x.imag))) for x in found]


_ROUNDING = mpf(10) ** -100  # far below what doubles can come to by chance, far above DIGITS
_SPARE = 60  # digits that may be lost where the accelerations are solved for


def solved(function, model: str, drive):
    """What a function of the laws of a drive is, in the digits that mpmath works with."""
    with ctx.workdps(mpmath.mp.dps + _SPARE):
        found = function(laws_of(model, drive))
        return found if isinstance(found, list | int) else mpf(found.mid())


def steady_law(drive) -> int:
    """Law of steady sliding by the force on the contact; 0 if there is none."""
    return solved(lambda laws: laws.steady_law, "rigid", drive)


def state_matrix(model: str, drive, law: int) -> list[list[mpf]]:
    """State matrix under a law and constant friction."""

    def rates(laws: Bodies) -> list[list[mpf]]:
        rows = linearised(laws, {"slip": 1, "contact": law}).tolist()
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
