"""Puts ``tests`` on the path (``from reference import ...``), makes hypothesis reproducible, and orders the files."""

import pytest
from hypothesis import settings

pytest.register_assert_rewrite("reference")

# The same examples in every run, on every machine; no limit in time, because the first example compiles the kernels.
settings.register_profile("reproducible", derandomize=True, deadline=None)
settings.load_profile("reproducible")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put files with long tests first: files are shared out to processes, and the last one should not run alone."""
    heavy = {item.path for item in items if item.get_closest_marker("slow") or item.get_closest_marker("workflow")}
    items.sort(key=lambda item: item.path not in heavy)
