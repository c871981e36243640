"""What is made from a drive is made once: a drive that travels through many layers is not built in each of them.

Drives are values, so that what was made from one serves every equal one. The last few hundred drives are kept, not all:
a sweep goes through a hundred thousand, and holds on to many of them.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

_KEPT = 256  # more drives than any figure looks at in turn; an automaton takes some ten kilobytes
_forget: list[Callable[[], None]] = []


def once(make: Callable[P, T]) -> Callable[P, T]:
    """Decorate a function of a drive, and of what else can be hashed, so that it computes each result once.

    The result is shared, so nobody may change it. Arguments must be given in one and the same way.
    """
    kept: Any = lru_cache(maxsize=_KEPT)(make)
    _forget.append(kept.cache_clear)
    return kept  # type: ignore[no-any-return]


def forget() -> None:
    """Forget all results, so that the time to make one can be measured."""
    for clear in _forget:
        clear()
