"""What a scene saves by leaving out what it does not need: run time, construction, compilation, data and imports."""

import os
import platform
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from benchmarks.ablation import leaving_out
from benchmarks.ablation.cost_of_starting import compilation, imports
from benchmarks.figures.ablation.settings import MODULES
from lsvib.datasets.attributes import named_index, variable, yes_no
from lsvib.datasets.checks import Check

_SOURCE = "docs/validation.md"
_ROUNDING = 1e-12  # of the size of a state: what half a second of events may make of the last digit
_MODELS = ("pared", "general")
_PACKAGES = ("numba", "matplotlib", "xarray")
_NUMBERS = {
    "run_time": ("s", "fastest time to follow the motion"),
    "build_time": ("s", "fastest time to build the model"),
    "modes": ("1", "number of modes"),
    "guards": ("1", "number of guards"),
    "states": ("1", "number of states"),
    "table_bytes": ("byte", "size of the tables"),
}


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Measure the scenes of :func:`benchmarks.ablation.leaving_out.scenes`, the imports and the compilation.

    ``settings``: see ``Settings``; compilation takes about 7 s of CPU time for two states and 33 s for any number.
    """
    scenes = leaving_out.scenes(settings["duration"])
    kinds = {
        "_and_".join(settings["compile"][: k + 1]): tuple(settings["compile"][: k + 1])
        for k in range(len(settings["compile"]))
    }
    pairs = [leaving_out.measure(scene, settings["repeats"]) for scene in scenes.values()]
    variables: dict[str, tuple] = {
        name: variable(("scene", "model"), np.array([[getattr(m, name) for m in pair] for pair in pairs]), units, words)
        for name, (units, words) in _NUMBERS.items()
    }
    compared = [leaving_out.difference(pared.motion, general.motion) for pared, general in pairs]
    apart = "largest difference of states and event times, relative to their size"
    variables |= {
        "same_events": yes_no("scene", [same for same, _ in compared], "both models have the same events"),
        "difference": variable("scene", [gap for _, gap in compared], "1", apart),
    }
    variables |= _imports(settings) | _compilation(kinds)
    return xr.Dataset(
        variables,
        coords={
            "scene": named_index("scene", "scene", list(scenes)),
            "model": named_index("model", "extent of the model", _MODELS),
            "imported_for": named_index("imported_for", "what is imported", list(MODULES)),
            "package": named_index("package", "package", _PACKAGES),
            "compiled": named_index("compiled", "kinds of flow that are compiled", kinds),
        },
        attrs={
            "title": "Nothing that a scene does not need",
            "source": "lsvib, its own models and general ones of the same motion",
            "references": "docs/validation.md",
            "left_out": "; ".join(f"{name}: {scene.left_out}" for name, scene in scenes.items()),
            "modules": "; ".join(f"{name}: {module}" for name, module in MODULES.items()),
            "hardware": f"{platform.machine()}, {os.cpu_count()} CPUs",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that both models have one motion, that every scene gains, and what is imported."""
    speed_up = (dataset.run_time[:, 1] / dataset.run_time[:, 0]).values
    built = (dataset.build_time[:, 1] / dataset.build_time[:, 0]).values
    loads = dataset.loads.astype(bool).values
    row = {name: k for k, name in enumerate(MODULES)}
    column = {name: k for k, name in enumerate(_PACKAGES)}
    return [
        Check.holds(
            f"The pared and the general model of each scene have the same events, and states to {_ROUNDING:.0e}",
            _SOURCE,
            f"largest difference {float(dataset.difference.max()):.1e}",
            bool(dataset.same_events.all() and (dataset.difference <= _ROUNDING).all()),
        ),
        Check.holds(
            "Every scene that leaves something out runs faster and is built faster",
            _SOURCE,
            f"runs {speed_up.min():.1f} to {speed_up.max():.1f} times as fast, "
            f"built {built.min():.1f} to {built.max():.0f} times as fast",
            bool((speed_up > 1).all() and (built > 1).all()),
        ),
        Check.holds(
            "Datasets of eigenvalues import no numba, datasets of motions no matplotlib, pictures no engine",
            _SOURCE,
            ", ".join(f"{name}: {int(n)} modules" for name, n in zip(MODULES, dataset.imported.values, strict=True)),
            not (
                loads[row["eigenvalues"], column["numba"]]
                or loads[row["motion"], column["matplotlib"]]
                or loads[row["figure"], column["numba"]]
            ),
        ),
    ]


def _imports(settings: Mapping[str, Any]) -> dict[str, tuple]:
    found = [imports(module, settings["repeats"]) for module in MODULES.values()]
    (counts, seconds, packages), dim = zip(*found, strict=True), "imported_for"
    loads = [[package in names for package in _PACKAGES] for names in packages]
    return {
        "imported": variable(dim, list(counts), "1", "number of modules that are imported"),
        "import_time": variable(dim, list(seconds), "s", "fastest time to import them"),
        "loads": yes_no((dim, "package"), loads, "the package is imported"),
    }


def _compilation(kinds: Mapping[str, tuple[str, ...]]) -> dict[str, tuple]:
    counts, seconds = zip(*map(compilation, kinds.values()), strict=True)
    return {
        "specialisations": variable("compiled", list(counts), "1", "number of compiled specialisations"),
        "compile_time": variable("compiled", list(seconds), "s", "CPU time to compile the engine"),
    }
