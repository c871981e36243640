"""Puts ``tests`` on the path (``from reference import ...``) and makes hypothesis reproducible."""

import pytest
from hypothesis import settings

pytest.register_assert_rewrite("reference")

# The same examples in every run, on every machine; no limit in time, because the first example compiles the kernels.
settings.register_profile("reproducible", derandomize=True, deadline=None)
settings.load_profile("reproducible")
