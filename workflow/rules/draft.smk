"""A quick look: several figures in one process, since loading our modules takes longer than a coarse grid does.

These rules make the same files as those of a full run; Snakemake prefers a rule without wildcards.
"""

BATCHES = 4  # enough for four cores; the costly figures, which are neighbours in the list, come into different ones

for number, figures in enumerate([FIGURES[k::BATCHES] for k in range(BATCHES)]):
    if not figures:
        continue

    rule:
        name:
            f"draft_{number + 1}"
        input:
            sources=sorted(
                {file for f in figures for kind in ("datasets", "figures") for file in figure_sources(kind, f)}
            ),
            engine=sorted({part for f in figures for part in engine(imports(module_of(f)), settings_of(f).flows)}),
        output:
            datasets=expand("results/datasets/{figure}.nc", figure=figures),
            checks=expand("results/checks/{figure}.json", figure=figures),
            png=expand("results/figures/{figure}.png", figure=figures),
            captions=expand("results/figures/{figure}.rst", figure=figures),
        log:
            f"logs/draft_{number + 1}.log",
        params:
            code=code(jobs.draft),
            settings={figure: given(config, figure) for figure in figures},
            claims=[claims_in(tuple(figure_sources("datasets", figure))) for figure in figures],
        message:
            f"Computing and drawing {', '.join(figures)}"
        run:
            files = (list(output.get(name)) for name in ("datasets", "checks", "png", "captions"))
            jobs.run(jobs.draft, log[0], "draft", params.settings, *files)
