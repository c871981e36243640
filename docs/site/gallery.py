"""The gallery: a short script for every figure, written from its file, and how Sphinx-Gallery finds the pictures."""

import inspect
import shutil
from importlib import import_module
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from lsvib.chapter.configuration import FIGURES, load, module_of
from lsvib.pictures.style import save

_EXAMPLES = Path(__file__).parents[2] / "examples"
_RESOLUTION = 110  # dots per inch, enough for a screen
_HEADER = """
Gallery
=======

Every figure of the workflow, with its caption, the script that makes it, and its source file, which computes the
dataset, checks it and draws the picture. ``lsvib figure 8.6`` makes the same files. The scripts of ``examples`` come
last.
"""
_SECTIONS = {
    "1_chapter": "The chapter\n-----------\n\nThe fifteen figures of chapter 8.\n",
    "2_beyond": "Beyond the chapter\n------------------\n\nWhat the chapter says without a figure, and more.\n",
    "3_scripts": "Scripts\n-------\n\nUp to forty lines each, to copy and change.\n",
    "4_systems": "Your own system\n---------------\n\nEach reproduces a published number.\n",
}
# The file is shown as "pyi": in what is "python", Sphinx-Gallery looks for names to link, token by token, for seconds.
_SCRIPT = '''"""
{title}
{rule}

{caption}
"""

from lsvib.chapter.build import dataset_of, drawn
from lsvib.chapter.configuration import standard_settings

found = dataset_of("{name}", standard_settings("{name}"))
figure = drawn("{name}", found)
{shown}
# %%
# The file of the figure
# ----------------------
#
# .. literalinclude:: {file}
#    :language: pyi
'''
_SHOWN = """
# sphinx_gallery_thumbnail_path = 'files/figures/{name}.png'
# %%
# .. image:: /files/figures/{name}.png
#    :alt: {words}
"""


def title(figure: str) -> str:
    """Return the heading of a figure: that of the chapter has its number, another one its name in words."""
    chapter, _, number = figure.removeprefix("fig").partition("_")
    if chapter.isdigit() and number.isdigit():
        return f"Figure {chapter}.{int(number)}"
    return figure.replace("_", " ").capitalize()


def script(figure: str, source: Path, pictures: Path | None) -> str:
    """Return the script of a figure, and copy its module to the sources of the site, which show it.

    ``pictures``: a folder with a picture of every figure, for a script that is shown and not run.
    """
    file, shown = f"files/figures/{figure}.py", ""
    (source / file).parent.mkdir(parents=True, exist_ok=True)
    (source / file).write_text(inspect.getsource(import_module(module_of(figure))), encoding="utf-8")
    if pictures:
        shutil.copy2(pictures / f"{figure}.png", source / "files" / "figures" / f"{figure}.png")
        shown = _SHOWN.format(name=figure, words=_words(figure))
    name, caption = title(figure), load(figure).CAPTION.strip()
    return _SCRIPT.format(title=name, rule="=" * len(name), caption=caption, name=figure, shown=shown, file=f"/{file}")


def _words(figure: str) -> str:
    return f"{title(figure)}; the caption above says what it shows."


def write_scripts(source: Path, pictures: Path | None) -> None:
    """Write the scripts of all figures, and those of our own ``examples``, into this folder of the sources."""
    examples = source / "examples"
    examples.mkdir()
    (examples / "GALLERY_HEADER.rst").write_text(_HEADER, encoding="utf-8")
    for section, header in _SECTIONS.items():
        folder = examples / section
        folder.mkdir()
        (folder / "GALLERY_HEADER.rst").write_text(header, encoding="utf-8")
        for figure in FIGURES:
            if section == ("1_chapter" if figure.startswith("fig8_") else "2_beyond"):
                (folder / f"{figure}.py").write_text(script(figure, source, pictures), encoding="utf-8")
    for path in _EXAMPLES.rglob("*.py"):
        heading = f'"""{title(path.stem)}\n{"=" * len(path.stem)}\n\n'
        text = path.read_text(encoding="utf-8").replace('"""', heading, 1)
        section = "4_systems" if path.parent.name == "systems" else "3_scripts"
        (examples / section / path.name).write_text(text, encoding="utf-8")


def _get_sg_image_scraper() -> Any:
    """Return :func:`scrape`, under the name by which Sphinx-Gallery asks a module for it."""
    return scrape


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any], **more: Any) -> str:
    """Save the figure that a script has made, which no pyplot knows, and return the lines that show it."""
    from sphinx_gallery.scrapers import figure_rst

    figure = block_vars["example_globals"].pop("figure", None)
    if not isinstance(figure, Figure):
        return ""
    path = next(block_vars["image_path_iterator"])
    save(figure, path, resolution=_RESOLUTION)
    shown: str = figure_rst([path], gallery_conf["src_dir"], _words(Path(block_vars["src_file"]).stem))
    return shown
