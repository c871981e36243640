"""The configuration, checked, and what several rules ask of it."""

from lsvib.errors import LsvibError
from lsvib.chapter import configuration
from snakemake.exceptions import WorkflowError

try:
    config.update(configuration.checked(config))
except LsvibError as error:
    raise WorkflowError(f"Configuration: {error}") from None

FIGURES = configuration.selected(config)
ANALYSED, MAPPED = (
    [figure for figure in configuration.FIGURES if hasattr(configuration.load(figure), part)]
    for part in configuration.PARTS
)


wildcard_constraints:
    figure="|".join((*configuration.FIGURES, *configuration.BENCHMARKS)),


def settings(wildcards):
    """Return the section of a figure; what it does not name has the defaults of its ``Settings``."""
    return configuration.given(config, wildcards.figure)


def sources(wildcards):
    """Return a digest of the sources on which a figure depends, all of lsvib; an edit makes it anew."""
    return configuration.sources_of(wildcards.get("figure", "attraction"))


def category(wildcards):
    """Return the part of the report in which a figure is."""
    if wildcards.figure.startswith("fig8_"):
        return "Chapter 8"
    return "Other methods and a measurement" if wildcards.figure in configuration.BENCHMARKS else "Beyond the chapter"


def inputs(wildcards):
    """Return what the dataset of a figure needs: parts of the engine, tables, and its analysis and maps if it has them."""
    figure, own = wildcards.figure, configuration.load(wildcards.figure).Settings
    parts = zip(configuration.PARTS, (ANALYSED, MAPPED))
    files = {part: f"<results>/{part}/{figure}.nc" for part, figures in parts if figure in figures}
    engine = [f"<results>/engine/{part}.txt" for part in own.engine]
    return files | {"engine": engine, "tables": list(map(str, own.tables))}
