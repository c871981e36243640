"""The reference: every public name, every parameter and the documented modules, written from the package itself."""

import math
from importlib import import_module
from pathlib import Path

import lsvib
from lsvib.drives.complaints import allowed_range
from lsvib.drives.drive import IN_WORDS, PART_OF, PARTS, Drive, described

_GROUPS = {
    "Drives": ["Drive"],
    "Simulation": ["simulate", "Scene"],
    "Stability and thresholds": [
        "StabilityReport",
        "Condition",
        "Quantity",
        "Threshold",
        "ThresholdSolution",
        "Derivative",
    ],
    "Attractors": ["Attractor", "SteadyState"],
    "Regions of attraction": ["Basin", "Resilience", "Window", "Grid", "Axis"],
    "Errors": ["LsvibError", "InputError", "NoThreshold", "EngineError", "DivergenceError"],
}
_OTHER = "Others"
# Modules that the other pages name, by subject; docs/design.md has the layers.
MODULES = {
    "Drives": ["lsvib.drives.drive", "lsvib.drives.scene", "lsvib.drives.chapter", "lsvib.drives.model"],
    "Your own system": ["lsvib.systems.system", "lsvib.systems.ends"],
    "Engine": ["lsvib.systems.automaton", "lsvib.systems.motion"],
    "Steady sliding": [
        "lsvib.stability.spectrum",
        "lsvib.stability.conditions",
        "lsvib.stability.threshold",
        "lsvib.stability.boundaries",
        "lsvib.stability.force_thresholds",
        "lsvib.stability.motion_equations",
        "lsvib.stability.slip",
        "lsvib.stability.solve",
        "lsvib.stability.curves",
    ],
    "Cycles": [
        "lsvib.systems.attractor",
        "lsvib.systems.cycles",
        "lsvib.dynamics.cycles",
        "lsvib.systems.continuation",
        "lsvib.dynamics.impulses",
        "lsvib.answers.cycles",
    ],
    "Regions of attraction": [
        "lsvib.dynamics.boundary",
        "lsvib.dynamics.resilience",
        "lsvib.systems.grid",
        "lsvib.dynamics.curves",
    ],
    "Data": ["lsvib.answers.motion", "lsvib.answers.sweep", "lsvib.chapter.checks", "lsvib.answers.io"],
    "Figures": ["lsvib.chapter.build", "lsvib.chapter.configuration"],
}


def write_pages(source: Path) -> None:
    """Write ``api.rst``, ``parameters.rst`` and ``modules.rst`` into the sources of the site."""
    (source / "api.rst").write_text(public_names(), encoding="utf-8")
    (source / "parameters.rst").write_text(parameter_tables(), encoding="utf-8")
    (source / "modules.rst").write_text(module_pages(source), encoding="utf-8")


def public_names() -> str:
    """Return the page of all names of ``lsvib.__all__``, in groups; none can be forgotten."""
    known = {name for names in _GROUPS.values() for name in names}
    rest = [name for name in lsvib.__all__ if name not in known]
    lines = [_heading("Public interface", "="), ".. currentmodule:: lsvib\n"]
    lines.append("``import lsvib`` provides all of it; :doc:`python` shows how.\n")
    for group, names in (*_GROUPS.items(), *([(_OTHER, rest)] if rest else [])):
        lines.append(_heading(group, "-"))
        lines += [_entry(name) for name in names]
    return "\n".join(lines)


def _entry(name: str) -> str:
    thing = getattr(lsvib, name)
    if not isinstance(thing, type):
        return f".. autofunction:: lsvib.{name}\n"
    options = {"members": "", "undoc-members": "", "show-inheritance": ""}
    if name == "Cycle":  # what cycles of any system are, too
        options["inherited-members"] = ""
    if name.endswith("Drive"):  # what all drives can, and nothing of pydantic
        options = {"members": "", "inherited-members": "BaseModel"}
    if issubclass(thing, Exception):
        options = {"show-inheritance": ""}
    return "\n".join([f".. autoclass:: lsvib.{name}", *(f"   :{key}: {value}" for key, value in options.items()), ""])


def parameter_tables() -> str:
    """Return the page of all parameters, with symbol, unit, range, default and meaning."""
    lines = [
        _heading("Parameters", "="),
        "The defaults are those of Table 8.1, as far as it states them; :doc:`physics` says where the others come "
        "from.\n``lsvib config`` prints the same.\n",
    ]
    groups = {"Any drive": [key for key in Drive.model_fields if key not in PART_OF]}
    groups |= {IN_WORDS[part].capitalize(): list(names) for part, names in PARTS.items()}
    for title, own in groups.items():
        words = "All drives have these:" if title == "Any drive" else "A drive has this part if these are given:"
        lines += [_heading(title, "-"), f"{words}\n"]
        lines += [".. list-table::", "   :header-rows: 1", ""]
        lines += _row(["key", "symbol", "unit", "allowed range", "default", "meaning"])
        for key in own:
            about = described(key)
            default = Drive.model_fields[key].default
            shown = "none" if default is None else f"{default:g}"
            shown = f"{math.degrees(default):.4g}°" if key == "lead_angle" else shown
            # The symbol is shorter than the key, and |…| in bars would be a substitution.
            allowed = allowed_range(Drive, key).replace(key, about["symbol"]).replace("|", r"\|")
            lines += _row([f"``{key}``", about["symbol"], about["unit"], allowed, shown, about["long_name"]])
        lines.append("")
    return "\n".join(lines)


def module_pages(source: Path) -> str:
    """Return the page that lists the documented modules, and write a page for each."""
    folder = source / "module"
    folder.mkdir()
    lines = [_heading("Modules", "="), "Modules that the theory pages name; :doc:`design` describes the layers.\n"]
    for subject, names in MODULES.items():
        lines += [_heading(subject, "-"), ".. toctree::\n"]
        lines += [f"   module/{name.removeprefix('lsvib.')}" for name in names]
        lines.append("")
        for name in names:
            module = import_module(name)
            others = [key for key in getattr(module, "__all__", ()) if getattr(module, key).__module__ != name]
            text = f"{_heading(name, '=')}\n.. automodule:: {name}\n   :members:\n"
            text += f"   :exclude-members: {', '.join(others)}\n" if others else ""
            (folder / f"{name.removeprefix('lsvib.')}.rst").write_text(text, encoding="utf-8")
    return "\n".join(lines)


def _heading(text: str, mark: str) -> str:
    return f"{text}\n{mark * len(text)}\n"


def _row(cells: list[str]) -> list[str]:
    return [f"   {'*' if k == 0 else ' '} - {cell}" for k, cell in enumerate(cells)]
