"""Compiled kernels of attractors."""
