"""Build the documentation site from the pages of this folder, which also read well without it.

    python docs/build_site.py build/docs

writes the site to ``build/docs/html`` and, as one file, to ``build/docs/lsvib-docs.zip``, which opens from disk once
unpacked. The scripts of the gallery are run for their pictures, which takes most of the time;
``--pictures results/figures`` shows those of a run of the workflow instead, and ``--without-pictures`` none. The extra
``docs`` is required; a warning of Sphinx is an error.
"""

import argparse
import os
import re
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import main as sphinx

ROOT = Path(__file__).resolve().parents[1]
DOCS, SITE = ROOT / "docs", ROOT / "docs" / "site"
sys.path.insert(0, str(SITE))

import gallery  # noqa: E402
import reference  # noqa: E402

HOME = "index.rst"  # of the site, in place of the README
# Pages of the repository that lie outside of docs, and their names on the site.
ELSEWHERE = {
    "config/README.md": "settings.md",
    "benchmarks/README.md": "benchmarks.md",
    "profiles/slurm/README.md": "slurm.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "README.md": HOME,
}
_LINK = re.compile(r"(?<!!)\]\((?!https?:|#|mailto:)([^)#\s]+)(#[^)\s]*)?\)")
_PICTURE = re.compile(r"!\[[^\]]*\]\(([^)]+)\)")
_ENTRY = re.compile(r"^   (?:.*<)?([\w/]+)>?$", re.MULTILINE)  # of a table of contents


def build(out: Path, *, run_scripts: bool, pictures: Path | None) -> Path:
    """Build the site below ``out`` and return the folder of its pages; ends the program if Sphinx warns."""
    source, pages = out / "source", out / "html"
    for old in (source, pages, out / "doctrees"):
        shutil.rmtree(old, ignore_errors=True)
    assemble(source, pictures)
    options = ["-q", "-W", "--keep-going", "-b", "html", "-d", str(out / "doctrees")]
    if not run_scripts:
        options += ["-D", "plot_gallery=0"]
    if sphinx([*options, str(source), str(pages)]):
        sys.exit("docs: Sphinx warned; see above.")
    return pages


def assemble(source: Path, pictures: Path | None) -> None:
    """Put the sources of the site together: our pages, those from elsewhere, the gallery and the reference."""
    shutil.copytree(SITE, source, ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    shutil.copy2(SITE / "conf.py", source)
    shutil.copytree(DOCS / "figures", source / "figures", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    pages = {f"docs/{path.name}": path.name for path in DOCS.glob("*.md")}
    for path, name in {**pages, **ELSEWHERE}.items():
        if name != HOME:
            text = (ROOT / path).read_text(encoding="utf-8")
            (source / name).write_text(on_site(text, path, source, {**pages, **ELSEWHERE}), encoding="utf-8")
    gallery.write_scripts(source, pictures)
    reference.write_pages(source)
    _list_the_rest(source)


def on_site(text: str, path: str, source: Path, pages: dict[str, str]) -> str:
    """Return the text of a page with its links as they are on the site.

    Arguments: the text; its ``path`` in the repository; the folder of the ``source``, to which files that are linked
    but are no page are copied; the ``pages`` by their paths. Ends the program if a link leads nowhere.
    """

    def replaced(match: re.Match[str]) -> str:
        target = os.path.normpath(os.path.join(os.path.dirname(path), match[1]))
        if target in pages:
            return f"]({pages[target]}{match[2] or ''})"
        if not (ROOT / target).is_file():
            sys.exit(f"docs: {path} links to {match[1]}, which does not exist.")
        copy = source / "files" / target
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / target, copy)
        return f"](files/{target})"

    for picture in _PICTURE.findall(text):
        if not (ROOT / os.path.dirname(path) / picture).is_file():
            sys.exit(f"docs: {path} shows {picture}, which does not exist.")
    return _LINK.sub(replaced, text)


def _list_the_rest(source: Path) -> None:
    """Put the pages that no table of contents names where ``more.rst`` has the line REST, so that none is lost."""
    tables = [path for path in source.glob("*.rst") if ".. toctree::" in path.read_text(encoding="utf-8")]
    listed = {name for path in tables for name in _ENTRY.findall(path.read_text(encoding="utf-8"))}
    rest = sorted({path.stem for path in source.glob("*.md")} - listed)
    more = source / "more.rst"
    text = more.read_text(encoding="utf-8")
    more.write_text(text.replace("   REST\n", "".join(f"   {name}\n" for name in rest)), encoding="utf-8")


def main() -> None:
    """Build the site as the command line says."""
    parser = argparse.ArgumentParser(description="Build the documentation site.")
    parser.add_argument("out", type=Path, help="folder to write to")
    shown = parser.add_mutually_exclusive_group()
    shown.add_argument("--pictures", type=Path, metavar="FOLDER", help="show the pictures in this folder")
    shown.add_argument("--without-pictures", action="store_true", help="do not run the scripts of the gallery")
    given = parser.parse_args()
    if given.pictures:
        for figure in gallery.FIGURES:
            if not (given.pictures / f"{figure}.png").is_file():
                sys.exit(f"docs: {given.pictures} has no picture {figure}.png.")
    run_scripts = not (given.pictures or given.without_pictures)
    pages = build(given.out.resolve(), run_scripts=run_scripts, pictures=given.pictures)
    archive = shutil.make_archive(str(given.out / "lsvib-docs"), "zip", pages)
    print(f"The site is {pages / 'index.html'}, and in one file {archive}.")


if __name__ == "__main__":
    main()
