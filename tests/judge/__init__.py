"""Random drives over the full ranges, and the questions that each is asked."""
