"""Linear stability of steady sliding, the chapter's conditions, boundaries and thresholds."""
