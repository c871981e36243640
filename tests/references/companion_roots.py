"""Roots of a polynomial in many digits, as eigenvalues of its companion matrix."""

import mpmath


def roots(polynomial) -> list[mpmath.mpc]:
    """Roots of a polynomial of decimals, highest power first; 100 digits, because they may lie 20 decades apart."""
    with mpmath.workdps(100):
        leading, *rest = (mpmath.mpf(str(p)) for p in polynomial)
        companion = mpmath.zeros(len(rest))
        for i, p in enumerate(rest):
            companion[0, i] = -p / leading
            if i:
                companion[i, i - 1] = 1
        return list(mpmath.eig(companion, left=False, right=False))
