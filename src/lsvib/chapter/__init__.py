"""The chapter: a file for each figure, which builds, checks and draws its dataset, and the checks of all claims."""
