"""Each coefficient of the equations of motion, wrong by 0.5 %, stops a figure that it is in or fails a check of it."""

import pytest
import xarray as xr
from references.figure_checks import checks_of, dataset_of

from lsvib.errors import LsvibError
from lsvib.figures.configuration import default_figures
from lsvib.models import mechanics, modes, rigid
from lsvib.models.drive import forget

pytestmark = pytest.mark.slow

WRONG = 0.995
QUANTITIES = {"Γ": "effective_inertia", "N": "normal_force", "C": "effective_damping", "ξ": "friction_factor"}
_NO_FORCE = "the contact force is not in it"
_UNDAMPED = "it has no damping but that of the support, as a parameter"
_SOLVED = "under a friction law Newton's laws are solved body by body, without the formula of it"
NOT_IN = {  # figures whose datasets a quantity does not change at all, and why
    "Γ": {
        "nut_stability": "the critical values depend on where Γ vanishes, not on its size",
        **dict.fromkeys(("falling_friction", "measured_drive"), _SOLVED),
    },
    "N": {
        **dict.fromkeys(("fig8_01", "fig8_02"), "its contact force χ is an equation of its own (8.7)"),
        **dict.fromkeys(("fig8_03", "fig8_08", "fig8_15", "contact_stability", "nut_stability"), _NO_FORCE),
        "basin_sweep": "it depends on where N vanishes, not on its size",
        "limit_process": "impulses follow from the momentum, not from N",
    },
    "C": {
        **dict.fromkeys(("fig8_01", "fig8_02"), "while the contact moves the torque is constant"),
        **dict.fromkeys(("fig8_08", "fig8_15"), _UNDAMPED),
        **dict.fromkeys(("falling_friction", "measured_drive"), _SOLVED),
    },
    "ξ": {},
}


@pytest.fixture
def right(figure):
    return dataset_of(figure)


@pytest.fixture(params=QUANTITIES)
def quantity(request, right, monkeypatch):
    """One of the quantities, made wrong where drives, automata and thresholds take it from, once ``right`` is built."""
    name = QUANTITIES[request.param]
    if name == "normal_force":
        for model in (rigid, modes):
            monkeypatch.setattr(model, "assemble", _observing_wrongly(model.assemble))
    else:
        formula, whole = getattr(mechanics, name), mechanics.LinearParts.polynomial
        monkeypatch.setattr(mechanics, name, lambda *values: formula(*values) * WRONG)
        if (power := {"Γ": 0, "C": 1}.get(request.param)) is not None:  # the coefficient that is made of it
            monkeypatch.setattr(mechanics.LinearParts, "polynomial", lambda parts: _wrong_at(whole(parts), power))
    forget()
    yield request.param
    forget()


def _wrong_at(polynomial, place):
    # a quotient of integers, which every kind of number takes
    return tuple(x * 199 / 200 if k == place and x.__class__ is not int else x for k, x in enumerate(polynomial))


def _observing_wrongly(assemble):
    """The rows of N over the state, of all modes, wrong."""

    def wrong(*, observables, **parts):
        rows = {mode: tuple(x * WRONG for x in row) for mode, row in observables["normal_force"].items()}
        return assemble(observables={**observables, "normal_force": rows}, **parts)

    return wrong


@pytest.mark.parametrize("figure", default_figures())
def test_a_wrong_coefficient_fails_a_check(figure, right, quantity):
    try:
        dataset = dataset_of.__wrapped__(figure)  # not the one that is kept
        failed = [check.claim for check in checks_of(figure, dataset) if not check.passed]
    except LsvibError as error:  # friction that does not fit the contact force: compliant threads chatter without end
        dataset, failed = None, [str(error)]
    if figure in NOT_IN[quantity]:
        xr.testing.assert_equal(dataset, right)
    else:
        assert failed, f"no check of {figure} notices {quantity}: give it one, or say in NOT_IN why it cannot"
    print(f"{quantity} | {figure} | {'; '.join(failed) or NOT_IN[quantity][figure]}")
