"""Puts ``tests`` on the path (``from references import ...``), makes hypothesis reproducible, and orders the files."""

import sys

import pytest
from hypothesis import settings

pytest.register_assert_rewrite("references")

# The same examples in every run, on every machine; no limit in time, because the first example compiles the kernels.
settings.register_profile("reproducible", derandomize=True, deadline=None)
settings.load_profile("reproducible")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put files with long tests first: files are shared out to processes, and the last one should not run alone."""
    heavy = {item.path for item in items if item.get_closest_marker("slow") or item.get_closest_marker("workflow")}
    items.sort(key=lambda item: item.path not in heavy)


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
