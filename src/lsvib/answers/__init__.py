"""Each kind of answer as dataset, as JSON and in words."""
