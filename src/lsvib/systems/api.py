"""All that can be asked of a system of one's own, by its methods.

What a question needs is loaded when it is asked. Motions begin in a ``mode`` with a ``state`` by name; states and
clocks that it leaves out are zero, and harmonics are at phase 0. Each method raises ``InputError`` for what is not
acceptable, and ``EngineError`` where the system does not say what follows, in one sentence.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from lsvib.numbers import Progress
from lsvib.systems import system

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from lsvib.systems.answers import Ends
    from lsvib.systems.continuation import CycleBranch
    from lsvib.systems.cycles import Cycle
    from lsvib.systems.ends import End

State = Mapping[str, float] | None


class System(system.System):
    __doc__ = system.System.__doc__

    def simulate(self, mode: str, state: State, duration: float, *, samples: int = 1001) -> "xr.Dataset":
        """Return the exact motion from a start, with its events.

        ``duration`` [s], and the number of ``samples``, equidistant in time, both ends included. Returns a dataset over
        ``time`` [s] with all states and the mode, and over ``event`` the time and kind of each event, the mode that it
        enters and the states before and after it.
        """
        from lsvib.systems.answers import simulation

        return simulation(self, mode, state, duration, samples)

    def steady_state(self, mode: str, state: State = None) -> "End":
        """Return what the motion from a start ends on: label, period, multipliers, one period as ``orbit``."""
        from lsvib.systems.ends import end_of

        return end_of(self, mode, state)

    def cycles(
        self,
        starts: Iterable[tuple[str, State]] = (),
        *,
        box: Mapping[str, tuple[float, float]] | None = None,
        count: int = 100,
        seed: int = 0,
    ) -> "Ends":
        """Return all that motions end on, each once, cycles first.

        ``starts``: modes and states; ``box``: least and largest value of some states, between which ``count`` more
        starts are drawn, in all modes, by a generator with this ``seed``. Cycles that repel are not found so.
        """
        from lsvib.systems.answers import all_ends

        return all_ends(self, starts, box, count, seed)

    def follow(
        self,
        cycle: "End | Cycle",
        parameter: str,
        span: tuple[float, float],
        *,
        points: int = 1000,
        progress: Progress | None = None,
    ) -> "CycleBranch":
        """Follow a cycle of this system over a parameter, both ways, at most so many ``points`` each.

        ``span``: its smallest and largest value, with the system's own between them. Returns the branch with its points
        and ``changes``, of which each has a ``name``: fold, period doubling, Neimark–Sacker, grazing, border collision.
        """
        from lsvib.systems.answers import followed

        return followed(self, cycle, parameter, span, points, progress)

    def sweep(
        self,
        mode: str | None = None,
        state: State = None,
        /,
        *,
        progress: Progress | None = None,
        **over: "Sequence[float] | np.ndarray",
    ) -> "xr.Dataset":
        """Return what the motion from a start ends on over values of parameters, all combinations of them.

        It begins in the first mode unless another is named. Returns a dataset over the parameters with the label, the
        period [s], as a multiple of the forcing's as well, the largest multiplier, the extremes of each state and how
        often each event happens in a period; of two parameters that is a chart.
        """
        from lsvib.systems.answers import sweep

        return sweep(self, mode, state, over, progress)

    def map(
        self, grid: Mapping[str, Any], mode: str | None = None, *, progress: Progress | None = None
    ) -> "xr.Dataset":
        """Return what motions from the cells of a grid end on.

        ``grid``: two states, each (start, stop, count), and values of others; the ``mode`` is the first one unless
        another is named. Returns a dataset over both with the label of each cell and the number of its end, and what
        these ends are.
        """
        from lsvib.systems.answers import mapped

        return mapped(self, grid, mode, progress)
