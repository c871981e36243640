"""From the model to a dataset, from a dataset to a picture."""


rule compile_engine:
    """Compile one part of the engine: the flow of two states, that of more states, or the mapper.

    Several parts may be compiled side by side; a figure waits only for those that it runs.
    """
    input:
        sources=source_files(module for module in import_graph().modules if ".kernels." in module),
        before=lambda wildcards: marker("planar") if wildcards.part == "mapper" else [],  # whose kernels it calls
    output:
        "results/engine/{part}.txt",
    log:
        "logs/compile_engine/{part}.log",
    wildcard_constraints:
        part="|".join(ENGINE),
    priority: 1  # others wait for it
    params:
        numba=importlib.metadata.version("numba"),
    message:
        "Compiling the engine: {wildcards.part}"
    script:
        "../scripts/compile_engine.py"


rule dataset:
    """Compute the dataset of a figure and check it against the chapter."""
    input:
        sources=sources("datasets"),
        engine=lambda wildcards: engine(imports(dataset_module(wildcards.figure))),
    output:
        dataset="results/datasets/{figure}.nc",
        checks="results/checks/{figure}.json",
    log:
        "logs/dataset/{figure}.log",
    benchmark:
        "benchmarks/dataset/{figure}.tsv"
    threads: cores
    params:
        settings=settings,
    message:
        "Computing {wildcards.figure}"
    script:
        "../scripts/build_dataset.py"


rule figure:
    """Draw a figure from its dataset."""
    input:
        dataset="results/datasets/{figure}.nc",
        sources=sources("figures"),
        caption=lambda wildcards: caption(wildcards.figure),
    output:
        png=report(
            "results/figures/{figure}.png",
            caption="../report/figure.rst",
            category=category,
            labels={"figure": "{figure}"},
        ),
        pdf="results/figures/{figure}.pdf",
        caption="results/figures/{figure}.rst",
    log:
        "logs/figure/{figure}.log",
    benchmark:
        "benchmarks/figure/{figure}.tsv"
    message:
        "Drawing {wildcards.figure}"
    script:
        "../scripts/draw_figure.py"
