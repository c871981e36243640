"""Other methods: how they are driven, timed and judged."""
