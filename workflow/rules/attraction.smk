"""The region of attraction, in tiles: snakemake -j2 attraction. Not a figure of the chapter, so not part of `all`."""


scattergather:
    attraction=config["attraction"]["tiles"],


rule attraction:
    """Map the region of attraction and draw it."""
    input:
        "results/attraction/map.nc",
        collect("results/figures/attraction.{format}", format=["png", "pdf"]),
    message:
        "The region of attraction is mapped"


rule compile_mapper:
    """Map one cell, so that the kernels are compiled once, and what is wrong with the map is said once."""
    input:
        sources=source_files(imports("lsvib.datasets.map")),
        engine=engine(imports("lsvib.datasets.map"), flows_of(MAP["drive"])),
    output:
        "results/attraction/mapper.txt",
    log:
        "logs/compile_mapper.log",
    params:
        code=code(jobs.first_cell),
        settings=MAP,
    message:
        "Compiling the mapper"
    run:
        jobs.run(jobs.first_cell, log[0], "attraction", params.settings, output[0])


rule map_tile:
    """Label the cells of one tile. The file goes when the map that it is part of is complete."""
    input:
        sources=source_files(imports("lsvib.datasets.map")),
        mapper="results/attraction/mapper.txt",
    output:
        temp("results/attraction/tiles/{scatteritem}.nc"),
    log:
        "logs/map_tile/{scatteritem}.log",
    resources:
        mem_mb=1000,
    params:
        code=code(jobs.map_tile),
        settings=MAP,
    message:
        "Mapping tile {wildcards.scatteritem}"
    run:
        jobs.run(jobs.map_tile, log[0], "attraction", params.settings, wildcards.scatteritem, output[0], threads)


rule gather_map:
    """Put the tiles together in one compressed file."""
    input:
        sources=source_files(imports("lsvib.datasets.map")),
        tiles=gather.attraction("results/attraction/tiles/{scatteritem}.nc"),
    output:
        "results/attraction/map.nc",
    log:
        "logs/gather_map.log",
    resources:
        mem_mb=2000,
    params:
        code=code(jobs.whole_map),
        settings=MAP,
    message:
        "Gathering the tiles"
    run:
        jobs.run(jobs.whole_map, log[0], "attraction", params.settings, list(input.tiles), output[0])


rule draw_map:
    """Draw the map, a large one from the middle cells of blocks of cells."""
    input:
        map="results/attraction/map.nc",
        sources=figure_sources("figures", "attraction"),
    output:
        png=report("results/figures/attraction.png", caption="../report/figure.rst", category="Region of attraction"),
        pdf="results/figures/attraction.pdf",
        caption="results/figures/attraction.rst",
    log:
        "logs/draw_map.log",
    resources:
        mem_mb=1000,
    params:
        code=code(jobs.picture),
    message:
        "Drawing the region of attraction"
    run:
        jobs.run(jobs.picture, log[0], "attraction", "attraction", input.map, output.png, output.pdf, output.caption)
