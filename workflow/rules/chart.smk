"""A chart over two parameters, in tiles: snakemake -j2 chart. Not a figure of the chapter, so not part of `all`."""


scattergather:
    chart=config["chart"]["tiles"],


rule chart:
    """Chart what the drive does and draw it."""
    input:
        "results/chart/chart.nc",
        collect("results/figures/chart.{format}", format=["png", "pdf"]),
    message:
        "The chart is made"


rule chart_tile:
    """Label the cells of one tile. The file goes when the chart that it is part of is complete."""
    input:
        sources=chart_sources(),
        engine=engine(chart_modules()),
    output:
        temp("results/chart/tiles/{scatteritem}.nc"),
    log:
        "logs/chart_tile/{scatteritem}.log",
    resources:
        mem_mb=1000,
    params:
        code=code(jobs.chart_tile),
        settings=CHART,
    message:
        "Charting tile {wildcards.scatteritem}"
    run:
        jobs.run(jobs.chart_tile, log[0], "chart", params.settings, wildcards.scatteritem, output[0], threads)


rule gather_chart:
    """Put the tiles together and add the exact curves."""
    input:
        sources=chart_sources(),
        tiles=gather.chart("results/chart/tiles/{scatteritem}.nc"),
    output:
        "results/chart/chart.nc",
    log:
        "logs/gather_chart.log",
    resources:
        mem_mb=1000,
    params:
        code=code(jobs.whole_chart),
        settings=CHART,
    message:
        "Gathering the chart"
    run:
        jobs.run(jobs.whole_chart, log[0], "chart", params.settings, list(input.tiles), output[0])


rule draw_chart:
    """Draw the chart, a large one from the middle cells of blocks of cells."""
    input:
        chart="results/chart/chart.nc",
        sources=figure_sources("figures", "chart"),
    output:
        png=report(
            "results/figures/chart.png",
            caption="../report/figure.rst",
            category="Chart",
        ),
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
