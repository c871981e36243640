"""The tables of many drives at once, in extended precision, against those of each drive in balls."""

import numpy as np
import pytest
from references.drives import catalogue_drive

from lsvib.dynamics.sweep import ending_of
from lsvib.engine.exact.modal_form import linear_mode, modal_flow
from lsvib.engine.kernels import event_loop
from lsvib.engine.kernels.layout import A0, A1, BETA
from lsvib.models.many import ManyDrives, automata
from lsvib.models.model import automaton_of

DRIVES = 40


def drawn():
    """Drives such as a catalogue offers, with a start of each, and the automata that are made for all at once."""
    found = [catalogue_drive("threads", 9, i, 1) for i in range(DRIVES)]
    values = {name: np.array([getattr(drive, name) for drive, _ in found]) for name in dict(found[0][0])}
    together = automata(ManyDrives(values))
    return [(drive, starts[0], one) for (drive, starts), (_, _, one) in zip(found, together, strict=True)]


def test_tables_are_those_of_each_drive(monkeypatch):
    built = []
    monkeypatch.setattr("lsvib.engine.exact.modal_form.modal_mode", built.append)
    cases = drawn()
    assert not built  # none of these drives needs balls
    monkeypatch.undo()
    for drive, start, many in cases:
        exact = automaton_of(drive)
        for name in ("surfaces", "condition_row"):
            np.testing.assert_allclose(getattr(many.tables, name), getattr(exact.tables, name), rtol=1e-15)
        flow, true = many.tables.flow, exact.tables.flow
        assert np.array_equal(flow.pairs, true.pairs)
        assert np.array_equal(flow.singles, true.singles)
        pairs, singles = true.oscillators.shape[1], true.rates.shape[1]
        columns = [A0, A1, BETA]
        np.testing.assert_allclose(flow.oscillators[:, :pairs, columns], true.oscillators[..., columns], rtol=1e-15)
        np.testing.assert_allclose(flow.rates[:, :singles], true.rates, rtol=1e-15)
        assert many.condition < 2 * exact.condition
        for mode, code in enumerate(many.codes):
            state = np.where([False, code in many.rest_codes, False, False], -drive.input_speed, start)
            for time in (1e-5, 1e-3, 1e-2):
                moved, right = np.empty(4), np.empty(4)
                event_loop.advance(flow, mode, state, time, moved)
                event_loop.advance(true, mode, state, time, right)
                assert (np.abs(moved - right) <= 2e-12 * np.maximum(np.abs(right), np.abs(state))).all()


def test_what_motions_end_on_is_what_they_end_on_by_the_tables_of_each_drive():
    for drive, start, many in drawn()[:15]:
        quick = ending_of(drive, many, start)
        right = ending_of(drive, automaton_of(drive), start)
        assert quick.attractor == right.attractor
        for name in ("amplitude", "period", "peak_normal_force"):
            assert getattr(quick, name) == pytest.approx(getattr(right, name), rel=1e-9, nan_ok=True)


def test_forms_that_do_not_hold_are_given_up():
    """Equal rates in pairs of their own, a chain of zeros, no number; beside them a field that holds."""
    good, twice = np.array([4.0, 9.0, 4.0, 4.0]), np.array([25.0, 9.0, np.nan, 0.0])
    rows = [(0, 1, 0, 0, 0), (-good, -0.1, 0, 0, 0), (0, 0, 0, 1, 0), (0, 0, -twice, 0 * twice - 0.1 * (twice > 0), 0)]
    mode = linear_mode(rows, (1.0,) * 4, None, "a damping")
    assert np.isfinite(mode.condition).tolist() == [True, False, False, False]
    assert modal_flow([mode]).pairs[0].tolist() == [2]
