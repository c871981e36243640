"""From the model to a dataset, from a dataset to a picture: core, analyse, map, dataset, figure."""


rule core:
    """Compile one part of the engine: the flow of rigid drives, of drives with parts, or of a friction law."""
    output:
        "<results>/engine/{part}.txt",
    log:
        "<logs>/core/{part}.log",
    benchmark:
        "<results>/benchmarks/core/{part}.tsv"
    wildcard_constraints:
        part="planar|modal|taylor",
    priority: 1  # others wait for it
    params:
        sources=sources,
    message:
        "Compiling the engine: {wildcards.part}"
    script:
        "../scripts/core.py"


rule analyse:
    """Analyse the drives of a figure: eigenvalues, conditions of instability, thresholds."""
    output:
        "<results>/analysis/{figure}.nc",
    log:
        "<logs>/analyse/{figure}.log",
    benchmark:
        "<results>/benchmarks/analyse/{figure}.tsv"
    wildcard_constraints:
        figure="|".join(ANALYSED),
    params:
        part="analysis",
        settings=settings,
        sources=sources,
    message:
        "Analysing the drives of {wildcards.figure}"
    script:
        "../scripts/part.py"


use rule analyse as map with:
    input:
        engine="<results>/engine/planar.txt",
    output:
        "<results>/maps/{figure}.nc",
    log:
        "<logs>/map/{figure}.log",
    benchmark:
        "<results>/benchmarks/map/{figure}.tsv"
    wildcard_constraints:
        figure="|".join(MAPPED),
    params:
        part="maps",
        settings=settings,
        sources=sources,
    message:
        "Mapping the starts of {wildcards.figure}"


rule dataset:
    """Compute the dataset of a figure and check it against the chapter."""
    input:
        unpack(inputs),
    output:
        dataset="<results>/datasets/{figure}.nc",
        checks="<results>/checks/{figure}.json",
    log:
        "<logs>/dataset/{figure}.log",
    benchmark:
        "<results>/benchmarks/dataset/{figure}.tsv"
    params:
        settings=settings,
        sources=sources,
    message:
        "Computing {wildcards.figure}"
    script:
        "../scripts/dataset.py"


rule figure:
    """Draw a figure from its dataset."""
    input:
        dataset="<results>/datasets/{figure}.nc",
    output:
        png=report(
            "<results>/figures/{figure}.png",
            caption="../report/figure.rst",
            category=category,
            labels={"figure": "{figure}"},
        ),
        pdf="<results>/figures/{figure}.pdf",
        caption="<results>/figures/{figure}.rst",
    log:
        "<logs>/figure/{figure}.log",
    benchmark:
        "<results>/benchmarks/figure/{figure}.tsv"
    wildcard_constraints:
        figure="|".join((*configuration.FIGURES, *configuration.BENCHMARKS, "attraction", "chart")),
    message:
        "Drawing {wildcards.figure}"
    script:
        "../scripts/figure.py"
