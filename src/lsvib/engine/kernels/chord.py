"""What a guard does on a step so short that it is its chord to rounding: the last test of every kind of flow."""

from lsvib.engine.kernels.jit import inlined_kernel
from lsvib.engine.kernels.status import Decision

_POSITIVE = int(Decision.POSITIVE)
_TOUCHES = int(Decision.TOUCHES)
_ROOT = int(Decision.ROOT)


@inlined_kernel
def decide_by_chord(first, last, rounding, starts_on_surface):
    """Decide whether a guard with these values and derivatives at the ends of a step rests on zero, or touches it.

    ``rounding``: size of the guard below which it is rounding only; zero where nothing is left of the guard.
    """
    if min(first[0], last[0]) > rounding:
        return _POSITIVE
    if last[0] <= -rounding and not (starts_on_surface and last[0] == 0.0):
        return _ROOT
    # While it still falls it has not touched zero: it may die away without ever coming there.
    falls = last[0] >= 0.0 and last[1] <= 0.0
    return _POSITIVE if starts_on_surface or falls else _TOUCHES
