"""Compiled kernels of maps."""
