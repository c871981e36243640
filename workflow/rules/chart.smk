"""A chart over two parameters: snakemake -j2 chart. Not a figure of the chapter, so not part of `all`."""


rule chart:
    """Chart what the drive does and draw it."""
    input:
        "results/chart/chart.nc",
        collect("results/figures/chart.{format}", format=["png", "pdf"]),
    message:
        "The chart is made"


rule chart_cells:
    """Label the cells of the chart and add the exact curves."""
    input:
        sources=source_files(imports("lsvib.datasets.sweep")),
        engine=engine(imports("lsvib.datasets.sweep"), flows_of(CHART["drive"])),
    output:
        "results/chart/chart.nc",
    log:
        "logs/chart_cells.log",
    threads: lambda wildcards: workflow.cores
    resources:
        mem_mb=1000,
    params:
        code=code(jobs.chart),
        settings=CHART,
    message:
        "Charting the drive"
    run:
        jobs.run(jobs.chart, log[0], "chart", params.settings, output[0], threads)


rule draw_chart:
    """Draw the chart, a large one from the middle cells of blocks of cells."""
    input:
        chart="results/chart/chart.nc",
        sources=figure_sources("figures", "chart"),
    output:
        png=report("results/figures/chart.png", caption="../report/figure.rst", category="Chart"),
        pdf="results/figures/chart.pdf",
        caption="results/figures/chart.rst",
    log:
        "logs/draw_chart.log",
    resources:
        mem_mb=1000,
    params:
        code=code(jobs.picture),
    message:
        "Drawing the chart"
    run:
        jobs.run(jobs.picture, log[0], "chart", "chart", input.chart, output.png, output.pdf, output.caption)
