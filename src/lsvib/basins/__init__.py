"""Regions of attraction: maps of many starts, and the exact boundary."""
