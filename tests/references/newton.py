"""Newton's laws of steady sliding, body by body (:class:`references.bodies.Bodies`), linearised with many digits.

Numbers are flint's balls. Under a friction law the linearisation is by differences, with 80 digits, of which only the
middle is kept; without, the state matrix has the rates at unit states as columns. Stability is by eigenvalues, or by
Routh's array of the characteristic polynomial.
"""

import mpmath
from flint import acb, acb_mat, arb, ctx
from mpmath import mpf

from .bodies import Bodies

DIGITS = 250  # rates of random drives lie up to 30 decades apart, and the polynomial has products of four of them
FEWER = 80  # of differences
STEP = arb(10) ** -25  # of a central difference, relative to the rates of the drive


def laws_of(model, drive) -> Bodies:
    """The laws of a drive of a model, in balls."""
    return Bodies(drive, parts=() if model == "rigid" else (model,), number=arb)


def sliding_state(laws) -> list:
    """The state of steady sliding, by the balance of forces."""
    state = list(laws.steady)
    if "e" in laws.place:
        normal = laws.axial / (laws.cos + laws.steady_law * laws.mu(laws.p["input_speed"]) * laws.sin)
        state[2] = normal / (laws.cos * laws.p["contact_stiffness"])
    return state


def eigenvalues_by_differences(model, drive):
    """Eigenvalues [1/s] of the steady sliding of a drive, as mpmath's complex numbers, in ascending real part."""
    with ctx.workdps(FEWER):
        laws = laws_of(model, drive)
        state, mode = sliding_state(laws), laws.sliding
        assert all(rate.contains(0) for rate in laws.rate(0, state, mode))  # it is a state of rest of the laws
        jacobian = acb_mat(len(state), len(state))
        for j in range(len(state)):
            step, ends = STEP * (laws.p["input_speed"] if j % 2 else arb(1)), []
            for way in (1, -1):
                moved = list(state)
                moved[j] += way * step
                ends.append(laws.rate(0, moved, mode))
            for i in range(len(state)):
                jacobian[i, j] = acb(((ends[0][i] - ends[1][i]) / (2 * step)).mid())
        found = sorted(jacobian.eig(nonstop=True), key=lambda x: (float(x.real), float(x.imag)))
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
    """State matrix; its columns are the rates at unit states, because without loads the equations are homogeneous."""

    def rates(laws: Bodies) -> list[list[mpf]]:
        laws.p |= {"axial_force": arb(0), "input_speed": arb(0)}
        size = 2 if model == "rigid" else 4
        units = [[arb(int(i == j)) for i in range(size)] for j in range(size)]
        columns = [laws.rate(0, unit, {"slip": 1, "contact": law}) for unit in units]
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
