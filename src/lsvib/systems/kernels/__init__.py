"""Compiled kernels: flows, searches, the event loop, the rule of what motions end on, sections, maps."""
