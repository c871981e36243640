"""Attractors: steady sliding, rest and limit cycles, and what is carried through a cycle."""
