"""Piecewise-linear systems, exact from event to event: what they are, their motions, and what these end on."""
