"""The figure of a momentum observer, of a run and of the same run from its file."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.run_figures import observer_figure
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.simulation.walls_and_pushes import Push
from tests.simulation.sample_runs import joint_waves, lwr


def test_levels_estimate_and_truth(tmp_path):
    law = lwr_dyn.controller("inverse-dynamics+observer", lwr())
    push = Push(lwr(), (20.0, 0.0, 0.0), start=0.02, duration=0.06)
    run = simulate(lwr(), law, joint_waves(), duration=0.1, external=push)
    run.save(tmp_path / "run.npz")
    for one in (run, Run.load(tmp_path / "run.npz")):
        figure = observer_figure(one, [1, 3])
        assert [panel.title for panel in figure.panels] == ["joint_2", "joint_4"]
        true, estimate = figure.panels[1].curves
        np.testing.assert_array_equal(estimate.y, run.signals["external_torque"][:, 3])
        np.testing.assert_array_equal(true.y, run.signals["tau_external"][:, 3])
        level = law.threshold.level(np.full(7, 50.0), 1e-3)[3]
        assert [edge.value for edge in figure.panels[1].levels] == pytest.approx([level, -level], rel=1e-9)
    assert len(observer_figure(run).panels) == 7


def test_a_run_without_an_observer_is_refused():
    run = simulate(lwr(), lwr_dyn.controller("inverse-dynamics", lwr()), joint_waves(), duration=0.01)
    with pytest.raises(MissingDataError, match="momentum observer"):
        observer_figure(run)
