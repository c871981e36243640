"""Thresholds of a model beyond the boundaries that every model has: a file for each, found by its name."""
