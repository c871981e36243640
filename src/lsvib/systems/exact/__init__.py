"""Tables of a mode's flow from its linear field, with many digits."""
