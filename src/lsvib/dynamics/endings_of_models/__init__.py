"""What motions of many drives of a model end on, all at once: a file for each model of which that is known."""
