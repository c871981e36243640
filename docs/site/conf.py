"""Sphinx configuration of the documentation site; ``docs/build_site.py`` puts its sources together."""

import sys
from pathlib import Path
from typing import Any

import lsvib

sys.path.insert(0, str(Path(lsvib.__file__).parents[2] / "docs" / "site"))  # the scraper of the gallery

project = "lsvib"
author = "lsvib developers"
copyright = "lsvib developers, MIT licence"
version = release = lsvib.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_gallery.gen_gallery"]
exclude_patterns = ["examples", "files"]
highlight_language = "none"  # formulas are in blocks; blocks of code name their language
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
python_maximum_signature_line_length = 80
toc_object_entries_show_parents = "hide"

sphinx_gallery_conf = {
    "examples_dirs": ["examples"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r"\.py$",
    "image_scrapers": ("gallery",),
    "reset_modules": (),
    "capture_repr": (),
    "remove_config_comments": True,
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
}

html_theme = "pydata_sphinx_theme"
html_title = f"lsvib {release}"
html_show_sourcelink = False
html_show_search_summary = False  # a browser does not fetch them from disk
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_context = {"default_mode": "auto"}
html_sidebars = {"changelog": [], "tutorial": []}
html_theme_options = {
    "header_links_before_dropdown": 6,
    "navbar_end": ["theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "navigation_with_keys": False,
}


def no_substitutions(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Let the bars of |N| in a docstring be bars: outside of literals they would ask for a substitution."""
    for k, line in enumerate(lines):
        parts = line.split("``")
        parts[::2] = [part.replace("|", r"\|") for part in parts[::2]]
        lines[k] = "``".join(parts)


def setup(app: Any) -> None:
    """Tell Sphinx what to do with docstrings."""
    app.connect("autodoc-process-docstring", no_substitutions)
