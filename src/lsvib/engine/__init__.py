"""The engine: automata as tables of numbers, and their exact motions."""
