"""What a session prints of an answer is short: its name and its numbers, no tables."""

import pytest

from lsvib import Drive
from lsvib.basins.boundary import basin
from lsvib.dynamics.attractor import steady_state
from lsvib.engine.motion import follow
from lsvib.models.rigid import rigid_automaton

DRIVE = Drive(mass=11.0, support_damping=1e-3, axial_force=-10.0)
FAR = [0.5, -40.0]
ANSWERS = {
    "Automaton": lambda: rigid_automaton(DRIVE),
    "Motion": lambda: follow(rigid_automaton(DRIVE), FAR, 1.0),
    "SteadyState": lambda: steady_state(rigid_automaton(DRIVE), FAR),
    "Cycle": lambda: DRIVE.cycles().cycles[0],
    "Basin": lambda: basin(DRIVE),
}


@pytest.mark.parametrize("name", ANSWERS)
def test_an_answer_is_printed_in_a_few_lines(name):
    answer = ANSWERS[name]()
    assert getattr(answer, "orbit", answer) is not None
    assert repr(answer).startswith(f"{name}(")
    assert len(repr(answer)) < 400, repr(answer)
