"""The number of digits with which coefficients are formed."""

PLACES = 50  # decimal digits: a double has 16, and differences of products may cancel twice as many
