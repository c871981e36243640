"""Build a figure: its dataset with checks, and its picture, the same from Python, the command line and the workflow.

The workflow runs the two in separate jobs.
"""

import json
import re
from collections.abc import Mapping
from importlib.metadata import metadata
from typing import Any

import xarray as xr

from lsvib.answers.attributes import ASSUMED, GIVEN
from lsvib.answers.io import read_dataset, write_dataset
from lsvib.chapter.checks import Check
from lsvib.chapter.configuration import PARTS, complete_settings, load, module_of, sources_of, standard_settings
from lsvib.errors import InputError
from lsvib.files import File, write_json, write_text
from lsvib.pictures import style

_ENTRY = re.compile(r'"(\w+)": (\[[^][{}]*\]|[^][{},]+)')  # of settings as JSON: a name with its number or list


def compute_part(figure: str, part: str, given: Mapping[str, Any], file: File) -> None:
    """Compute and write a part of a figure that rules of their own make: ``analysis`` or ``maps`` (:data:`PARTS`)."""
    settings = complete_settings(figure, given)
    made = getattr(load(figure), part)(settings).assign_attrs(made_of(figure, settings))
    write_dataset(made, file, f"{module_of(figure)}.{part}")


def compute_figure(
    figure: str,
    given: Mapping[str, Any],
    dataset_file: File,
    checks_file: File,
    parts: Mapping[str, File] | None = None,
) -> list[Check]:
    """Compute the :func:`dataset_of` a figure and judge its file, by the function ``checks`` of its module; write both.

    Raises ``InputError`` about the settings and ``LsvibError`` about files, in one sentence.
    """
    write_dataset(dataset_of(figure, given, parts), dataset_file, f"{module_of(figure)}.build")
    checks: list[Check] = load(figure).checks(read_dataset(dataset_file))
    write_json([check.to_json() for check in checks], checks_file)
    return checks


def dataset_of(figure: str, given: Mapping[str, Any], parts: Mapping[str, File] | None = None) -> xr.Dataset:
    """Return the dataset of a figure, by the function ``build`` of its module.

    ``build`` takes all values of the class ``Settings`` beside it, and the parts that its module has (:data:`PARTS`);
    for values that it cannot use it raises ``InputError``.
    ``given``: settings as in its section of ``config/config.yaml``; those that it does not name have their defaults.
    ``parts``: files of parts that are computed already, by name; the others are computed here.
    The dataset has the attributes that :func:`made_of` tells.
    """
    settings, module, files = complete_settings(figure, given), load(figure), parts or {}
    own = {
        name: read_dataset(files[name]) if name in files else getattr(module, name)(settings)
        for name in PARTS
        if hasattr(module, name)
    }
    dataset: xr.Dataset = module.build(settings, **own)
    here, usual = ({*_ENTRY.findall(json.dumps(x))} for x in (settings, standard_settings(figure)))
    for name, variable in dataset.variables.items():
        if "origin" in variable.attrs and any(key.startswith(str(name)) for key, _ in here - usual):  # masses: mass
            variable.attrs["origin"] = variable.attrs["origin"].replace(ASSUMED, GIVEN)
    return dataset.assign_attrs(made_of(figure, settings))


def made_of(figure: str, settings: Mapping[str, Any]) -> dict[str, str]:
    """Return attributes of a file of the workflow: who, the settings as JSON, a digest of the sources that made it."""
    who = {"creator_name": metadata("lsvib")["Author"], "creator_type": "group"}
    return who | {"settings": json.dumps(settings), "sources_sha256": sources_of(figure)}


def draw_figure(
    figure: str, dataset_file: File, png: File, pdf: File | None = None, caption: File | None = None
) -> None:
    """Draw a figure, ``attraction`` and ``chart`` included, from its dataset and write it.

    ``pdf``, ``caption``: files for the PDF and for the caption in reStructuredText, or None. Raises ``LsvibError``
    about files, in one sentence.
    """
    dataset = overview(dataset_file) if figure == "attraction" else read_dataset(dataset_file)  # a map may be large
    style.save(drawn(figure, dataset), png, pdf)
    if caption is not None:
        write_text(caption_of(figure, dataset), caption)


def drawn(figure: str, dataset: xr.Dataset) -> style.Figure:
    """Draw a figure from its dataset, by the function ``draw`` of its module, in the look that all figures have."""
    return style.styled(load(figure).draw)(dataset)


def caption_of(figure: str, dataset: xr.Dataset) -> str:
    """Return the caption of a figure in reStructuredText: what it shows, then for which values, by its ``dataset``."""
    values = re.sub(r"([*`|_\\])", r"\\\1", style.stated(dataset))  # so that they mean themselves
    words = ("" if figure.startswith("fig8_") else "Not a figure of the chapter. ") + load(figure).CAPTION
    return f"{words}\nValues: {values}\n" if values else words


def overview(path: File, most: int = 1000) -> xr.Dataset:
    """Return a map with at most ``most`` rows and columns: of each block of cells the one in its middle.

    The coordinates are the middles of the blocks, whose sides are odd numbers of cells, and ``cell_width`` is theirs;
    cells beyond the last whole block are left out. ``fraction`` remains that of all cells. Raises ``InputError`` if the
    file cannot be read.
    """
    try:
        with xr.open_dataset(path, engine="netcdf4", cache=False) as whole:
            steps = {dim: -(-whole.sizes[dim] // most) | 1 for dim in whole["label"].dims}
            middles = {dim: slice(n // 2, whole.sizes[dim] // n * n, n) for dim, n in steps.items()}
            coarse = whole.isel(middles).load()
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        raise InputError(f"{path} is not a readable map: {error}.") from error
    for dim, step in steps.items():
        coarse[dim].attrs["cell_width"] *= step
    return coarse
