"""Drives: parameters, friction, mechanism, and the automaton of a drive in a scene."""
