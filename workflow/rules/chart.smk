"""A chart over two parameters: snakemake -j2 chart. Not a figure of the chapter, so not part of `all`."""


rule chart:
    """Chart what the drive does and draw it."""
    input:
        "<results>/figures/chart.png",


rule chart_cells:
    """Label the cells of the chart and add the exact curves."""
    output:
        "<results>/datasets/chart.nc",
    log:
        "<logs>/chart_cells.log",
    threads: 64  # all that Snakemake has, if it has fewer
    params:
        settings=configuration.given(config, "chart"),
        sources=sources,
    message:
        "Charting the drive"
    script:
        "../scripts/chart.py"
