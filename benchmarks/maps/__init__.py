"""Ways to map a region of attraction, compared."""
