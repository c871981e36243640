"""Pictures of datasets: one look, phase planes, maps, charts, and one `draw` for every answer."""
