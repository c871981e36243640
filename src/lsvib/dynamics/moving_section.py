"""A section of return whose surfaces move with a parameter of the drive."""

import numpy as np

from lsvib.dynamics.cycles import Cycle
from lsvib.dynamics.poincare_map import Section
from lsvib.engine.automaton import Automaton
from lsvib.engine.motion import Motion

_MET = 1e-12  # a surface whose value is below this part of its terms is met by the state of the section


class MovingSection:
    """A section of return whose surfaces move with the parameter; y: its free coordinates, in sizes of the motion."""

    def __init__(self, cycle: Cycle) -> None:
        section = cycle.section
        automaton, self.size = section.automaton, section.size
        self.kind, self.code = section.key[0], automaton.codes[section.key[1]]
        self.returns, self.longest = section.returns, cycle.period
        rows = automaton.tables.surfaces
        values = rows[:, :-1] @ cycle.state + rows[:, -1]
        terms = np.abs(rows[:, :-1]) @ self.size + np.abs(rows[:, -1])
        self._rows, self._tied = _pivots(rows[:, :-1] * self.size, np.flatnonzero(np.abs(values) <= _MET * terms))
        self.free = [i for i in range(self.size.size) if i not in self._tied]

    def place(self, state: np.ndarray) -> np.ndarray:
        """Return y (d) of a state (n)."""
        return state[self.free] / self.size[self.free]

    def state(self, automaton: Automaton, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the state (n) at y on the section of an automaton, and its derivative (n, d)."""
        rows = automaton.tables.surfaces[self._rows]
        state, slope = np.zeros(self.size.size), np.zeros((self.size.size, len(self.free)))
        state[self.free] = place * self.size[self.free]
        slope[self.free, range(len(self.free))] = self.size[self.free]
        if self._tied:
            tied = rows[:, self._tied]
            state[self._tied] = np.linalg.solve(tied, -(rows[:, :-1] @ state + rows[:, -1]))
            slope[self._tied] = np.linalg.solve(tied, -(rows[:, :-1] @ slope))
        return state, slope

    def back(self, automaton: Automaton, place: np.ndarray) -> tuple[Section, Motion] | None:
        """Return a section of return at y and the motion until it is back; None if it does not come back."""
        modes = np.flatnonzero(automaton.codes == self.code)
        if not modes.size:
            return None
        state, _ = self.state(automaton, place)
        key = self.kind, int(modes[0])
        section = Section(automaton, key, state, self.size, self.returns, self.longest)
        motion = section.come_back(state)
        if motion is None or motion.time.size == 0 or motion.time[0] == 0.0:
            return None
        return section, motion


def _pivots(rows: np.ndarray, met: np.ndarray) -> tuple[list[int], list[int]]:
    """Independent rows (of those in ``met``) and the coordinate that each is solved for, by full pivoting."""
    left, chosen, tied = {int(k): rows[k] / np.linalg.norm(rows[k]) for k in met}, [], []
    while left:
        k, row = max(left.items(), key=lambda item: np.abs(item[1]).max())
        column = int(np.argmax(np.abs(row)))
        if abs(row[column]) < _MET:
            break
        chosen.append(k)
        tied.append(column)
        del left[k]
        left = {other: value - value[column] / row[column] * row for other, value in left.items()}
    return chosen, tied
