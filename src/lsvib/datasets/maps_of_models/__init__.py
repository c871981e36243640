"""What is drawn around a map of a model beyond its cycles: a file for each model of which there is something."""
