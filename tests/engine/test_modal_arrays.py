"""Modal forms of many drives at once are those that 60 digits give, to the rounding that the arrays promise."""

import numpy as np
import pytest

from lsvib.drives.many import ManyDrives
from lsvib.drives.parameters import ThreadsParameters
from lsvib.drives.tables_of_models.threads import automata
from lsvib.drives.threads import seated_state, threads_automaton
from lsvib.engine.kernels import columns
from lsvib.engine.kernels.tables import ModalFlow


def drives_of(kind: str, count: int) -> list[ThreadsParameters]:
    rng = np.random.default_rng(5)
    if kind == "contact":
        places = 10.0 ** rng.uniform([4, 0], [9, 9], (count, 2))
        return [ThreadsParameters(mass=9, contact_stiffness=k, contact_damping=c) for k, c in places.tolist()]
    loads = rng.uniform([1, -60], [20, 60], (count, 2))
    return [ThreadsParameters(mass=m, axial_force=force) for m, force in loads.tolist()]


def many_of(drives) -> ManyDrives:
    values = {name: [getattr(drive, name) for drive in drives] for name in ThreadsParameters.model_fields}
    return ManyDrives(values, ThreadsParameters)


@pytest.mark.parametrize("kind", ["contact", "load"])
def test_tables_are_those_of_one_drive(kind):
    """All but the flow to the last bit; of the flow what the modal form does to a state, and its rates.

    The guards of many drives have no exact forms; see ``guard_forms_of``.
    """
    drives = drives_of(kind, 100)
    found = automata(many_of(drives), "contact_sign")
    assert sum(one is not None for one in found) > 95
    for drive, made in list(zip(drives, found, strict=True))[:12]:
        if made is None:
            continue
        (mine, seated), one = made, threads_automaton(drive)
        assert isinstance(one.tables.flow, ModalFlow)
        assert [seated["e"], seated["v"]] == seated_state(drive, 0.0, 0.0)[2:].tolist()
        for name, table in one.tables._asdict().items():
            if name == "guard_parts":
                assert mine.tables.guard_parts.shape == (len(table), 0)
            elif name != "flow":
                np.testing.assert_array_equal(getattr(mine.tables, name), table, err_msg=f"{name} of {drive!r}")
        for name, table in one.observables.items():
            np.testing.assert_array_equal(mine.observables[name], table)
        assert mine.condition == pytest.approx(one.condition, rel=1e-9)
        assert mine.sprag_codes == one.sprag_codes
        flow, other = mine.tables.flow, one.tables.flow
        np.testing.assert_array_equal(flow.field, other.field)
        np.testing.assert_array_equal(flow.pairs, other.pairs)
        np.testing.assert_array_equal(flow.singles, other.singles)
        sizes = np.array([0.1, drive.input_speed, 1e-6, 1e-3, 1.0])
        for mode in range(len(flow.pairs)):
            pairs, singles = flow.pairs[mode], flow.singles[mode]
            mine_order, order = (np.argsort(table.oscillators[mode, :pairs, columns.A0]) for table in (flow, other))
            ours, theirs = flow.oscillators[mode][mine_order], other.oscillators[mode][order]
            np.testing.assert_allclose(ours, theirs, rtol=1e-13)
            np.testing.assert_allclose(flow.rates[mode, :singles], other.rates[mode, :singles], rtol=1e-13)
            places = [2 * np.repeat(o, 2) + np.tile([0, 1], pairs) for o in (mine_order, order)]
            places = [np.append(p, 2 * pairs + np.arange(singles)).astype(int) for p in places]
            into, into_other = flow.to_modal[mode, places[0]], other.to_modal[mode, places[1]]
            error = (np.abs(into - into_other) * sizes).max(axis=1)
            assert (error <= 1e-14 * (np.abs(into_other) @ sizes)).all()
            reach = np.abs(into_other) @ sizes
            out, out_other = (t.from_modal[mode][:, p] for t, p in ((flow, places[0]), (other, places[1])))
            assert ((np.abs(out - out_other) * reach).max(axis=1) <= 1e-14 * (np.abs(out_other) @ reach)).all()


def test_company_changes_no_bit():
    """A drive has the same tables alone and among others."""
    drives = drives_of("contact", 40)
    together = automata(many_of(drives), "contact_sign")
    for k in (3, 17, 30):
        (alone,) = automata(many_of(drives[k : k + 1]), "contact_sign")
        assert (alone is None) == (together[k] is None)
        if alone is not None:
            for mine, other in zip(alone[0].tables.flow, together[k][0].tables.flow, strict=True):
                np.testing.assert_array_equal(mine, other)


def test_what_arrays_cannot_tell_is_left_to_60_digits():
    """Without any damping rates are on the imaginary axis, which no enclosure shows; a double rate is no simple one."""
    undamped = ThreadsParameters(mass=5, support_damping=0.0, translation_damping=0.0, contact_damping=0.0)
    usual = ThreadsParameters(mass=5)
    found = automata(many_of([undamped, usual]), "contact_sign")
    assert found[0] is None
    assert found[1] is not None
