"""A folder for each figure of the benchmarks."""
