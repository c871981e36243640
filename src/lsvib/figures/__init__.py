"""A file for each figure: how its dataset is built and checked, and how it is drawn."""
