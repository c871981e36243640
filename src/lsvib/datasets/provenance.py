"""What made a dataset: package version, git commit, library versions. No time, so equal runs give equal files."""

import json
import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

_LIBRARIES = ("numpy", "numba", "xarray", "netCDF4")


def provenance(maker: str) -> dict[str, str]:
    """Return attributes that name the code, and in ``history`` the ``maker``, a function.

    ``git_commit`` and ``git_dirty`` are ``"unknown"`` where git is missing or the package does not lie in a repository
    that tracks it; ``package_versions`` is a JSON object of Python and library versions.
    """
    commit, dirty = _git_state(Path(__file__).resolve())
    versions = {"python": platform.python_version(), **{name: version(name) for name in _LIBRARIES}}
    return {
        "history": f"made by {maker}, lsvib {version('lsvib')}",
        "lsvib_version": version("lsvib"),
        "git_commit": commit,
        "git_dirty": dirty,
        "package_versions": json.dumps(versions),
    }


def machine() -> dict[str, str | int]:
    """Return attributes that name processor, its cores and operating system, for datasets that hold run times."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        name = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "unknown")
    except OSError:
        name = platform.processor() or "unknown"
    return {"processor": name, "processor_cores": os.cpu_count() or 0, "operating_system": platform.system()}


def _git_state(tracked: Path) -> tuple[str, str]:
    def git(*arguments: str) -> str:
        command = ["git", "-C", str(tracked.parent), *arguments]
        return subprocess.run(command, capture_output=True, check=True, text=True).stdout.strip()

    try:
        # An installed copy may lie inside somebody else's repository: ask for the commit only if it tracks this file.
        git("ls-files", "--error-unmatch", tracked.name)
        return git("rev-parse", "HEAD"), str(bool(git("status", "--porcelain", "--untracked-files=no"))).lower()
    except (OSError, subprocess.CalledProcessError):
        return "unknown", "unknown"
