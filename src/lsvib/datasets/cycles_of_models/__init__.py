"""What is proved of the cycles of a model: a file for each model of which something is."""
