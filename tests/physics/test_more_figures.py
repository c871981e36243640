"""Figures 8.3 and 8.8, and the ablation: every check passes, each can fail, and the figure is drawn."""

import numpy as np
import pytest
from reference.figures import assert_drawn_from_file, assert_each_check_fails_on_some, dataset_of, scale, set_to

from lsvib.analysis.stability import Stability
from lsvib.datasets import ablation, fig8_03


def test_each_check_of_figure_8_8_can_fail():
    spoilers = [
        scale("critical_mass", 1.03),
        scale("loss_of_stability", 1 + 1e-9, 0),
        set_to("real_part", 1.0, 0, 0),
        set_to("real_part", 1.0, slice(None), -1),
    ]
    assert_each_check_fails_on_some("fig8_08", dataset_of("fig8_08"), spoilers)


@pytest.mark.parametrize("figure", ["fig8_03", "fig8_08"])
def test_is_drawn(figure, tmp_path):
    assert_drawn_from_file(figure, dataset_of(figure), tmp_path / "a.nc")


def test_each_check_of_figure_8_3_can_fail(monkeypatch):
    """One of them judges the closed form itself, at the places of the dataset: it is spoiled instead of the data."""

    def wrong_eigenvalues(dataset):
        right = fig8_03.eigenvalues
        monkeypatch.setattr(fig8_03, "eigenvalues", lambda *arguments: right(*arguments) * (1 + 1e-6))
        return dataset

    spoilers = [
        set_to("stability", Stability.UNSTABLE_NODE, -1, -1),
        set_to("stability", Stability.STABLE_FOCUS, 0, 0),
        scale("node_focus_damping", 1 + 1e-11, 0),
        wrong_eigenvalues,
    ]
    assert_each_check_fails_on_some("fig8_03", dataset_of("fig8_03"), spoilers)


def test_ablation(monkeypatch, tmp_path):
    """Times are put in by hand: one run on a busy machine proves nothing, and to compile takes ten seconds."""
    monkeypatch.setattr(ablation, "compilation", lambda kinds: (10 * len(kinds), 3.0 * len(kinds)))
    dataset = ablation.build({"duration": 0.05, "repeats": 1, "compile": ["planar", "modal"]})
    assert dataset.specialisations.values.tolist() == [10, 20]
    for name in ("run_time", "build_time", "import_time"):
        assert (dataset[name] > 0).all()
    dataset.run_time[:], dataset.build_time[:] = np.array([1e-3, 2e-3]), np.array([1e-3, 2e-3])
    spoilers = [
        set_to("same_events", 0, 0),
        set_to("difference", 1e-11, -1),
        set_to("run_time", 3e-3, 1, 0),
        set_to("build_time", 3e-3, 1, 0),
        set_to("loads", 1),
    ]
    assert_each_check_fails_on_some("ablation", dataset, spoilers)
    assert_drawn_from_file("ablation", dataset, tmp_path / "a.nc")
