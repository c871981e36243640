"""The region of attraction, in tiles: snakemake -j2 attraction. Not a figure of the chapter, so not part of `all`."""

# All but the number of tiles.
MAP = {key: value for key, value in configuration.given(config, "attraction").items() if key != "tiles"}


scattergather:
    attraction=config["attraction"]["tiles"],


rule attraction:
    """Map the region of attraction and draw it."""
    input:
        "<results>/figures/attraction.png",


rule map_tile:
    """Label the cells of one tile. The file goes when the map that it is part of is complete."""
    input:
        "<results>/engine/planar.txt",  # the rule of what motions end in, too, which all drives have
    output:
        temp("<results>/tiles/{scatteritem}.nc"),
    log:
        "<logs>/map_tile/{scatteritem}.log",
    params:
        settings=MAP,
        sources=sources,
    message:
        "Mapping tile {wildcards.scatteritem}"
    script:
        "../scripts/map_tile.py"


rule gather_map:
    """Put the tiles together in one compressed file."""
    input:
        gather.attraction("<results>/tiles/{scatteritem}.nc"),
    output:
        "<results>/datasets/attraction.nc",
    log:
        "<logs>/gather_map.log",
    params:
        settings=MAP,
        sources=sources,
    message:
        "Gathering the tiles"
    script:
        "../scripts/gather_map.py"
