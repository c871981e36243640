"""Try the wheel as a new user would, away from the sources, in an empty environment of each given Python.

    python tests/tools/try_wheel.py python3.11 python3.12 python3.13

builds the wheel, installs it from the package index, runs the commands that the documentation shows in an empty folder,
adds the extras, assesses a drive and opens the page of the explorer, and prints how long each took. Ends with code 1 if
one of them fails.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter
from urllib.request import urlopen

ROOT = Path(__file__).parents[2]
EXTRAS = "assess,explore"
COMMANDS = (  # without extras
    "config",
    "stability --set mass=11",
    "thresholds --model threads --set mass=9 --set contact_damping=5e4",
    "figure 8.3 --out figures",
    "figure 8.6 --out figures",
    "simulate --model rigid --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --start u=0.1 w=0 "
    "--duration 0.5 --out motion.nc",
    "attraction --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --grid u=-0.3:0.3:200 w=-150:150:200 "
    "--out map.nc --figure map.png",
    "figure 8.14 --out figures",
    "figure 8.13 --out figures",
)
ASSESS = "assess powered_seat.yaml --out report"


def clean(folder: Path) -> dict[str, str]:
    """Return an environment without what this process has on its path, with the caches of programs in the folder."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    return environment | {"XDG_CACHE_HOME": str(folder / "cache")}


def run(*command: str, folder: Path) -> str:
    """Run a program in a folder; what it says on failure is raised."""
    done = subprocess.run(command, cwd=folder, env=clean(folder), capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    return done.stdout


def explore(python: Path, folder: Path) -> None:
    """Open the page of the explorer; its script must come."""
    command = [str(python), "-m", "lsvib", "explore", "--no-show", "--port", "0"]
    with subprocess.Popen(command, cwd=folder, env=clean(folder), stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            address = re.search(r"http://localhost:\d+/", process.stdout.readline())
            if address is None:
                raise RuntimeError("lsvib explore has said no address.")
            with urlopen(address.group()) as page:
                if b"lsvib explorer" not in page.read():
                    raise RuntimeError("lsvib explore serves another page.")
        finally:
            process.terminate()


def try_with(interpreter: str, wheel: Path, folder: Path) -> None:
    """Install the wheel for one interpreter and run everything; raises ``RuntimeError`` about what fails."""
    version = run(interpreter, "--version", folder=folder).strip()
    begin = perf_counter()
    run(interpreter, "-m", "venv", "environment", folder=folder)
    python = folder / "environment" / "bin" / "python"
    run(str(python), "-m", "pip", "install", "-q", str(wheel), folder=folder)
    print(f"{version}: installed in {perf_counter() - begin:.0f} s", flush=True)
    work = folder / "work"
    work.mkdir()
    (work / "powered_seat.yaml").write_bytes((ROOT / "examples" / "powered_seat.yaml").read_bytes())
    for command in (*COMMANDS, ASSESS):
        if command == ASSESS:
            begin = perf_counter()
            run(str(python), "-m", "pip", "install", "-q", f"{wheel}[{EXTRAS}]", folder=folder)
            print(f"{version}: extras installed in {perf_counter() - begin:.0f} s", flush=True)
        begin = perf_counter()
        run(str(python.with_name("lsvib")), *command.split(), folder=work)
        print(f"{version}: {perf_counter() - begin:6.1f} s  lsvib {command}", flush=True)
    begin = perf_counter()
    explore(python, work)
    print(f"{version}: {perf_counter() - begin:6.1f} s  lsvib explore", flush=True)


def main() -> None:
    """Try every interpreter that the command line names."""
    failed = False
    with tempfile.TemporaryDirectory() as made:
        folder, copy = Path(made), Path(made) / "copy"  # of the sources: what an earlier build has left is not in it
        shutil.copytree(ROOT / "src", copy / "src", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
        for name in ("pyproject.toml", "README.md", "LICENSE"):
            shutil.copy2(ROOT / name, copy)
        run(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(folder), str(copy), folder=folder)
        (wheel,) = folder.glob("*.whl")
        for number, interpreter in enumerate(sys.argv[1:]):
            (folder / str(number)).mkdir()
            try:
                try_with(interpreter, wheel, folder / str(number))
            except RuntimeError as error:
                failed = True
                print(f"{interpreter}: FAILED: {error}", flush=True)
    sys.exit(failed)


if __name__ == "__main__":
    main()
