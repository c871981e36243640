"""Benchmarks: the engine held against references and beside other methods. Nothing imports this room."""
