"""Say what is being compiled, once, before it is: the first use of the engine takes much longer than all later ones.

What numba finds in its cache starts no compilation, so nothing is said then. The sentences go to the log of the
package, which the ``lsvib`` command shows and other programs may.
"""

import logging

from numba.core import event

# What is compiled, by the folder of the kernel and a word in the types of its arguments, the first that fits; with the
# processor time that was measured. Kernels that fit nothing are small and are compiled for one of the others.
_PARTS = (
    ("lsvib.", "ModalFlow", "the engine for models with three or four states, once, about 30 s"),
    ("lsvib.basins.", "", "the mapper of two-state models, once, 6 to 15 s"),
    ("lsvib.dynamics.", "Tables", "the search for many drives at once, once, half a minute or so"),
    ("lsvib.engine.", "Tables", "the engine for two-state models, once, about 10 s"),
)


def sentence(module: str, types: str) -> str | None:
    """Return the sentence for a kernel of ``module`` and the names of its arguments' types; None if it has none."""
    return next(
        (f"compiling {words}" for room, word, words in _PARTS if module.startswith(room) and word in types), None
    )


said: set[str] = set()  # sentences of this process


class Notice(event.Listener):
    """Log one sentence for each part of the engine when numba starts to compile the first kernel of it."""

    def __init__(self) -> None:
        self.depth = 0  # kernels that are being compiled, each for the one before

    def on_start(self, event: event.Event) -> None:
        """Say what is compiled, unless it has been said, or is part of what is being compiled."""
        self.depth += 1
        if self.depth > 1:
            return
        kernel, types = event.data["dispatcher"].py_func, event.data["args"]
        words = sentence(kernel.__module__, " ".join(map(str, types)))
        if words is not None and words not in said:
            said.add(words)
            logging.getLogger("lsvib").info(words)

    def on_end(self, event: event.Event) -> None:
        """Say nothing."""
        self.depth -= 1
