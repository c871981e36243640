"""How much of a sample a run takes: a part by default, more in continuous integration, the rest by hand."""

from collections.abc import Iterable

import pytest


def sizes(default: Iterable, slow: Iterable, search: Iterable = ()) -> list:
    """Return values of one parameter of a test, those that follow marked as such."""
    marked = (pytest.mark.slow, slow), (pytest.mark.search, search)
    return [*default, *(pytest.param(value, marks=mark) for mark, values in marked for value in values)]
