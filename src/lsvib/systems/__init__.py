"""Piecewise-linear systems, exact from event to event: what they are, their motions, and what these end on.

Systems of one's own are made as :class:`System`; ``__init__.pyi`` says where that lives, and it is loaded on first use.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
