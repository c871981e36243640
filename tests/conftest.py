"""Puts ``tests`` on the path (``from references import ...``), makes hypothesis reproducible, and orders the files."""

import os
import sys
from importlib.util import find_spec

import pytest
from hypothesis import settings

# Matrices are small: threads of linear algebra, on cores that other tests keep busy, make one a hundred times slower.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
pytest.register_assert_rewrite("references")

# Assessments and fits need the packages of the extra ``assess``, which requirements.txt installs.
collect_ignore_glob = [] if find_spec("pint") and find_spec("scipy") else ["sheets/test_*.py"]

# The same examples in every run, on every machine; no limit in time, because the first example compiles the kernels.
settings.register_profile("reproducible", derandomize=True, deadline=None)
settings.load_profile("reproducible")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put files with long tests first: files are shared out to processes, and the last one should not run alone."""
    heavy = {item.path for item in items if item.get_closest_marker("slow") or item.get_closest_marker("workflow")}
    items.sort(key=lambda item: item.path not in heavy)


@pytest.fixture(scope="module")
def browser():
    """A browser; a page of it is one of ``references.chromium``."""
    from references import chromium

    with chromium.started() as started:
        yield started


@pytest.fixture
def run(monkeypatch, capsys, tmp_path):
    """Run the command in an empty folder; returns exit code, standard output, error output."""
    from lsvib.cli.app import main

    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["lsvib", *arguments])
        code = 0
        try:
            main()
        except SystemExit as end:
            code = end.code or 0
        out, error = capsys.readouterr()
        # Whether the engine was compiled before depends on the tests before.
        said = [line for line in error.splitlines(keepends=True) if not line.startswith("lsvib: compiling ")]
        return code, out, "".join(said)

    return call
