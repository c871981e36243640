"""Pictures of datasets, below all that draws: one look, phase planes, maps, charts, and one `draw` for every answer."""
