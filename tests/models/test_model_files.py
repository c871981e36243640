"""What is found by the name of a model: its modules, and what a room has of it alone."""

from importlib.util import find_spec

import pytest

from lsvib.datasets import maps_of_models
from lsvib.errors import InputError
from lsvib.models.model import model_names, modules_of, of_model


def test_the_modules_of_a_model_are_its_own_and_those_of_the_rooms():
    """The workflow makes a map anew if one of them changes."""
    assert modules_of("rigid")[0] == "lsvib.models.rigid"
    assert {"lsvib.datasets.maps_of_models.rigid", "lsvib.dynamics.sweep"} < set(modules_of("rigid"))
    assert modules_of("nut") == ("lsvib.models.nut",)
    for name in model_names():
        assert all(find_spec(module) for module in modules_of(name))
    with pytest.raises(InputError, match="model = 'wood' is not one of rigid"):
        modules_of("wood")


def test_a_model_without_a_file_has_what_serves_all():
    found = of_model(maps_of_models, "rigid", "surroundings", len)
    assert found.__module__ == "lsvib.datasets.maps_of_models.rigid"
    assert of_model(maps_of_models, "nut", "surroundings", len) is len
    assert of_model(maps_of_models, "rigid", "nothing", len) is len
