"""Cases at the edge of the domain, and their judges."""
