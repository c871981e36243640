"""Mirror symmetry of random motions, and energy of those of the rigid drive.

The energy that a motion takes up and gives off is that of :mod:`benchmarks.sweeps.energy_balance`. It balances to 1e-11
of the largest energy or work in it: N is a quotient by Γ_s, whose rounding is amplified by I/Γ_s, up to 1e3 here. The
errors seen stay below 1e-13.
"""

from contextlib import suppress
from itertools import chain

import numpy as np
from references.comparisons import RULES
from references.drives import drive_with_parts, random_drive, random_start

from benchmarks.sweeps.energy_balance import balance
from lsvib.drives.automata import automaton_of
from lsvib.drives.model import model_of
from lsvib.errors import EngineError, InputError
from lsvib.systems.motion import follow


def motions(count):
    """Random drives, rules and motions, some of these from θ′ = 0, with what follows them."""
    rng = np.random.default_rng(20261128)
    for _ in range(count):
        drive, (u, w), rule = random_drive(rng), random_start(rng), RULES[rng.integers(2)]
        start = (u, -drive.input_speed if rng.random() < 0.1 else w), rng.uniform(1e-3, 0.05)
        yield drive, rule, follow(automaton_of(drive, resume=rule), *start, max_events=200), start


def motions_with_parts(seeds):
    """The same of drives with parts and laws, but for those that are refused."""
    for drive, start in map(drive_with_parts, seeds):
        with suppress(InputError, EngineError):
            yield drive, "contact_sign", follow(automaton_of(drive), start, 0.05, max_events=200), (start, 0.05)


def test_mirror_symmetry_is_exact():
    """(state, R, Ω) → −(state, R, Ω): the same bits with the other sign, for every operation is odd or even."""
    opposite = {"FORWARD": "BACKWARD", "BACKWARD": "FORWARD", "POSITIVE": "NEGATIVE", "NEGATIVE": "POSITIVE"}
    for drive, rule, motion, (start, duration) in chain(motions(300), motions_with_parts(range(40))):
        mirrored = drive.replace(axial_force=-drive.axial_force, input_speed=-drive.input_speed)
        automaton = automaton_of(mirrored) if drive.parts else automaton_of(mirrored, resume=rule)
        image = follow(automaton, -np.array(start), duration, max_events=200)
        for name in ("time", "kind"):
            np.testing.assert_array_equal(getattr(image, name), getattr(motion, name))
        for name in ("sign", "before", "after", "end_state"):
            np.testing.assert_array_equal(getattr(image, name), -getattr(motion, name))
        modes = model_of(drive).modes
        names = [[modes(int(m.automaton.codes[i])).name for i in m.mode] for m in (motion, image)]
        assert names[1] == ["_".join(opposite.get(word, word) for word in name.split("_")) for name in names[0]]


def test_energy_balances():
    for drive, _, motion, _ in motions(200):
        found = balance(motion, drive)
        assert found.residual <= 1e-11 + 4 * found.rounding, drive
        assert found.rounding <= 1e-10
