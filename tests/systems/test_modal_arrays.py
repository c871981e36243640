"""The tables of many drives at once, in extended precision, against those of each drive in balls."""

import numpy as np
import pytest
from references.drives import catalogue_drive

from lsvib.drives.automata import automaton_of
from lsvib.drives.many import ManyDrives, groups
from lsvib.systems.exact.modal_form import linear_mode
from lsvib.systems.kernels import event_loop
from lsvib.systems.kernels.layout import A0, A1, BETA, ModalFlow

DRIVES = 40


def drawn(kind):
    """Drives such as a catalogue offers, with a start of each, and all of them as arrays."""
    found = [catalogue_drive(kind, 9, i, 1) for i in range(DRIVES)]
    values = {name: np.array([getattr(drive, name) for drive, _ in found]) for name in dict(found[0][0])}
    return [drive for drive, _ in found], np.array([starts[0] for _, starts in found]), ManyDrives(values)


@pytest.mark.parametrize("kind", ["threads", "nut"])
def test_tables_are_those_of_each_drive(monkeypatch, kind):
    """Also with a nut, whose modes at rest have two rates of zero."""
    drives, starts, many = drawn(kind)
    built = []
    monkeypatch.setattr("lsvib.systems.exact.modal_form.modal_mode", built.append)
    found = [*groups(many, np.arange(DRIVES))]
    assert not built  # none of these drives needs balls
    monkeypatch.undo()
    assert all(group.safe.all() for group in found)
    for group, place in ((one, place) for one in found for place in range(one.members.size)):
        member, tables = group.members[place], group.automaton.tables
        drive, start = drives[member], starts[member]
        exact = automaton_of(drive)
        for name in ("surfaces", "condition_row"):
            np.testing.assert_allclose(getattr(tables, name)[place], getattr(exact.tables, name), rtol=1e-13)
        flow, true = ModalFlow(*(table[place] for table in tables.flow)), exact.tables.flow
        assert np.array_equal(flow.pairs, true.pairs)
        assert np.array_equal(flow.singles, true.singles)
        pairs, singles = true.oscillators.shape[1], true.rates.shape[1]
        columns = [A0, A1, BETA]
        np.testing.assert_allclose(flow.oscillators[:, :pairs, columns], true.oscillators[..., columns], rtol=1e-15)
        np.testing.assert_allclose(flow.rates[:, :singles], true.rates, rtol=1e-15)
        assert group.automaton.condition[place] < 2 * exact.condition
        for mode, code in enumerate(exact.codes):
            state = np.where([False, code in exact.marks["rest"], False, False], -drive.input_speed, start)
            for time in (1e-5, 1e-3, 1e-2):
                moved, right = np.empty(4), np.empty(4)
                event_loop.advance(flow, mode, state, time, moved)
                event_loop.advance(true, mode, state, time, right)
                assert (np.abs(moved - right) <= 2e-12 * np.maximum(np.abs(right), np.abs(state))).all()


def test_forms_that_do_not_hold_are_given_up():
    """Equal rates in pairs of their own, a chain of zeros, no number; beside them a field that holds."""
    good, twice = np.array([4.0, 9.0, 4.0, 4.0]), np.array([25.0, 9.0, np.nan, 0.0])
    rows = [(0, 1, 0, 0, 0), (-good, -0.1, 0, 0, 0), (0, 0, 0, 1, 0), (0, 0, -twice, 0 * twice - 0.1 * (twice > 0), 0)]
    mode = linear_mode(rows, (1.0,) * 4, None, "a damping")
    assert np.isfinite(mode.condition).tolist() == [True, False, False, False]
    assert mode.together([mode], [()])[0].pairs[0].tolist() == [2]
