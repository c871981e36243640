"""From the model to a dataset, from a dataset to a picture: core, analyse, map, dataset, figure."""


rule core:
    """Compile one part of the engine: the rule of what motions end in, the flow of rigid drives, of drives with parts, of
    a friction law, or the mapper.

    Several parts may be compiled side by side; a figure waits only for those that it runs. The flow of drives with
    parts takes longest, and asks the rule last.
    """
    input:
        sources=source_files(module for module in import_graph().modules if ".kernels." in module),
        before=lambda wildcards: [marker(part) for part in CALLED[wildcards.part]],
    output:
        "results/engine/{part}.txt",
    log:
        "logs/core/{part}.log",
    wildcard_constraints:
        part="|".join(ENGINE),
    priority: 1  # others wait for it
    params:
        code=code(jobs.compile_engine),
        numba=importlib.metadata.version("numba"),
    message:
        "Compiling the engine: {wildcards.part}"
    run:
        jobs.run(jobs.compile_engine, log[0], wildcards.part, wildcards.part, list(input.sources), output[0])


rule analyse:
    """Analyse the drives of a figure: eigenvalues, conditions of instability, thresholds."""
    input:
        sources=part_sources("lsvib.datasets.analysis"),
    output:
        "results/analysis/{figure}.nc",
    log:
        "logs/analyse/{figure}.log",
    params:
        code=code(jobs.part),
        settings=settings,
    message:
        "Analysing the drives of {wildcards.figure}"
    run:
        jobs.run(jobs.part, log[0], wildcards.figure, wildcards.figure, "analysis", params.settings, output[0])


rule map:
    """Map grids of starts of a figure to the attractors of their motions."""
    input:
        sources=part_sources("lsvib.datasets.map"),
        engine=[marker("planar"), marker("mapper")],
    output:
        "results/maps/{figure}.nc",
    log:
        "logs/map/{figure}.log",
    params:
        code=code(jobs.part),
        settings=settings,
    message:
        "Mapping the starts of {wildcards.figure}"
    run:
        jobs.run(jobs.part, log[0], wildcards.figure, wildcards.figure, "maps", params.settings, output[0])


rule dataset:
    """Compute the dataset of a figure and check it against the chapter."""
    input:
        unpack(parts),
        sources=sources("datasets"),
        engine=lambda wildcards: engine(imports(module_of(wildcards.figure)), settings_of(wildcards.figure).flows),
        tables=lambda wildcards: list(map(str, settings_of(wildcards.figure).tables)),
    output:
        dataset="results/datasets/{figure}.nc",
        checks="results/checks/{figure}.json",
    log:
        "logs/dataset/{figure}.log",
    params:
        code=code(jobs.dataset),
        settings=settings,
        claims=claims,
    message:
        "Computing {wildcards.figure}"
    run:
        jobs.run(jobs.dataset, log[0], wildcards.figure, wildcards.figure, params.settings, input, list(output))


rule figure:
    """Draw a figure from its dataset."""
    input:
        dataset="results/datasets/{figure}.nc",
        sources=sources("figures"),
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
    params:
        code=code(jobs.picture),
    message:
        "Drawing {wildcards.figure}"
    run:
        jobs.run(jobs.picture, log[0], wildcards.figure, wildcards.figure, input.dataset, *output)
