"""Fast followers of motions that share nothing with the engine's search."""
