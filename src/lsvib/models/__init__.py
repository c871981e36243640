"""The models: parameters, friction, and the automaton of a drive in a scene."""
