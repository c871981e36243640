"""The tables of many drives of a model at once: a file for each model of which they are made so, found by its name."""
