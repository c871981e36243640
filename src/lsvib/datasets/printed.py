"""Numbers that the chapter prints: as variables of a dataset, to be drawn beside what is computed, and as checks."""

from lsvib.datasets import attributes
from lsvib.datasets.checks import Check
from lsvib.models.chapter import Claim


def variable(claim: Claim, words: str) -> attributes.Variable:
    """Return a printed number, whose ``words`` say what it is, as a variable without dimensions."""
    return attributes.variable((), claim.value, claim.unit, f"{words}, as printed", relative_tolerance=claim.tolerance)


def check(words: str, claim: Claim, computed: float) -> Check:
    """Check that ``computed``, in the unit of the printed number, agrees with it to its tolerance."""
    return Check.within(words, claim.source, claim.value, float(computed), claim.tolerance, claim.unit, claim.reason)
