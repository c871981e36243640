"""Compiled kernels of sweeps."""
