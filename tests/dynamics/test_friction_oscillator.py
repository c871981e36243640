"""The friction oscillator of bSTAB and pybasin on the engine: the share of starts that end in sliding.

A mass on a belt that runs at the speed V, tied by a spring and a damper of the ratio ξ (units of mass and stiffness),

    x″ = −x − 2 ξ x′ − sgn(x′ − V) μ(|x′ − V|),      μ(v) = μ_d + (μ_sd − 1) μ_d exp(−v / v_0),

sticks to the belt while |x + 2 ξ V| ≤ μ_sd μ_d. With the parameters of bSTAB's case, sliding at x = μ(V) attracts
beside stick–slip. The shares are those that bSTAB finds from 5000 starts in the box −2 ≤ x ≤ 2, 0 ≤ x′ ≤ 2 (0.312 ±
0.0066 at V = 1.5), printed by pybasin for other speeds. The model is no drive: its tables are made here.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from references.sizes import sizes

from lsvib.drives.automata import divided
from lsvib.systems.attractor import Attractor, KnownCycles, end_of_motion, steady_state
from lsvib.systems.automaton import Branch, Guard, Mode, Surface, Transition, assemble
from lsvib.systems.continuation import follow_cycle
from lsvib.systems.cycles import cycle_of
from lsvib.systems.exact.taylor_form import TaylorMode, still_mode
from lsvib.systems.kernels.layout import FIRST_MODEL_KIND
from lsvib.systems.kernels.layout import Test as Is

DAMPING, DYNAMIC, STATIC_RATIO, FADING_SPEED = 0.05, 0.5, 2.0, 0.5
STOP, RELEASE, PASSAGE = range(FIRST_MODEL_KIND, FIRST_MODEL_KIND + 3)
STARTS = 5000  # of bSTAB, and of pybasin, for each speed


def friction(speed):
    return DYNAMIC + (STATIC_RATIO - 1) * DYNAMIC * math.exp(-speed / FADING_SPEED)


def oscillator(belt):
    """The automaton of the states x − μ(V) and x′; slip below the belt's speed is divided at x′ = 0."""
    law = np.array([0, math.inf, DYNAMIC, 0, friction(0) - DYNAMIC, 1 / FADING_SPEED, 1])  # one piece
    steady, hold = friction(belt), STATIC_RATIO * DYNAMIC
    field = np.array([[0.0, 1.0, 0.0], [-1.0, -2 * DAMPING, -steady]])

    def slip(side):
        push, speed = np.array([0.0, -side]), np.array([0.0, side, -side * belt])
        return TaylorMode(field=field, push=push, contact=np.array([0.0, 0.0, 1.0]), speed=speed, pieces=law[None])

    def stops(mode, row):
        return Branch(mode, STOP, ((row, Is.POSITIVE),))

    over = 1, 2 * DAMPING, steady - hold  # x + 2 ξ x′ beyond what friction holds
    under = -1, -2 * DAMPING, -steady - hold
    surfaces = {"belt": Surface((0, 1, -belt), 1), "hold": Surface(over, 0)}
    modes = {
        "below": Mode(0, slip(-1), (Guard("belt", -1, "stop"),)),
        "above": Mode(1, slip(1), (Guard("belt", 1, "stop"),)),
        "stick": Mode(2, still_mode([(0, 1, 0), (0, 0, 0)]), (Guard("hold", -1, "release"),)),
    }
    standing = stops("below", over), stops("above", under), Branch("stick", STOP)
    moving = stops("below", (0, -1, belt)), stops("above", (0, 1, -belt))
    transitions = {
        "entry": Transition((*moving, *standing)),
        "stop": Transition(standing),
        "release": Transition((Branch("below", RELEASE),)),
    }
    divided("below", PASSAGE, modes, transitions, surfaces, np.zeros(2))
    return assemble(
        states=("x", "v"), surfaces=surfaces, modes=modes, transitions=transitions, observables={},
        shortest_stay=1e-13, marks={"rest": frozenset([2])}, passive=True,
    )  # fmt: skip


def share_of_sliding(belt, starts, seed=20261126):
    """Share of random starts in bSTAB's box that end in sliding; all others stick and slip."""
    automaton, rng = oscillator(belt), np.random.default_rng(seed)
    steady, found = friction(belt), []
    cycle = steady_state(automaton, [2.0 - steady, 2.0])
    known = KnownCycles.of([cycle] if cycle.orbit else [], automaton, 0)
    for x, v in zip(rng.uniform(-2, 2, starts), rng.uniform(0, 2, starts), strict=True):
        found.append(end_of_motion(automaton, [x - steady, v], known=known)[0].label)
    assert set(found) <= {Attractor.STEADY_SLIDING, Attractor.STICK_SLIP_CYCLE}
    return found.count(Attractor.STEADY_SLIDING) / starts


def spread(share, starts):
    """Four standard errors of the difference between a share of so many starts and one of bSTAB's."""
    return 4 * math.sqrt(share * (1 - share) * (1 / starts + 1 / STARTS))


SHARES = {1.1: 0, 1.25: 0.084, 1.4: 0.211, 1.5: 0.312, 1.55: 0.364, 1.7: 0.491, 1.775: 0.555, 1.85: 1, 2.0: 1}
FEW, MORE, ALL = [(1.1, 200), (1.5, 2000), (1.85, 200)], [(1.4, STARTS), (1.7, STARTS)], (1.25, 1.55, 1.775, 2.0)


@pytest.mark.parametrize("case", sizes(FEW, MORE, [(belt, STARTS) for belt in ALL]))
def test_share_of_sliding(case):
    belt, starts = case
    assert abs(share_of_sliding(belt, starts) - SHARES[belt]) <= spread(SHARES[belt], starts)


def test_a_cycle_is_followed_to_where_sliding_loses_its_stability():
    """That of any automaton: it folds between the shares of 1.775 and 1.85, and then shrinks to the Hopf point."""
    cycle = cycle_of(steady_state(oscillator(1.0), [2.0, 2.0]))
    assert cycle.itinerary[-2:] == ((str(STOP), "stick"), (str(RELEASE), "below"))
    branch = follow_cycle(cycle, oscillator, "belt", 1.0, (0.99, 2.0), 200, None)
    assert 1.775 < branch.folds[0] < 1.85
    hopf = FADING_SPEED * math.log((STATIC_RATIO - 1) * DYNAMIC / (2 * DAMPING * FADING_SPEED))  # μ′ = −2 ξ
    assert branch.changes[-1].value == pytest.approx(hopf, rel=1e-8)
    assert steady_state(replace(oscillator(1.0), marks={}), [2.0, 2.0]).label == Attractor.OTHER_CYCLE
