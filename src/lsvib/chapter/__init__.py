"""The chapter: a file for each figure – how its dataset is built, checked and drawn –, and what is claimed."""
