"""Datasets: sampling, attributes, checks, provenance, files, tiles."""
