"""References in many digits, independent of the engine."""
