"""The paper's path under the paper's controllers: limits kept, energy balanced, the exact model followed."""

from functools import cache

import pytest

from lwr_dyn.simulation.audit import ENERGY_TOLERANCE, audit
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.ist import ist_reference
from tests.simulation.sample_runs import controllers, lwr, lwr_dynamics


@cache
def reference():
    return ist_reference(lwr())


@pytest.mark.slow
@pytest.mark.parametrize("name", controllers())
def test_limits_are_kept_and_energy_balances(name):
    run = simulate(lwr(), controllers()[name], reference())
    assert audit(run, lwr_dynamics("newton-euler")).worst_energy <= ENERGY_TOLERANCE
    assert metrics(run, lwr()).within_limits
    assert run.events == ()


def test_feed_forward_on_the_exact_model_keeps_the_tip_within_a_hundredth_of_a_millimetre():
    run = simulate(lwr(), controllers()["inverse-dynamics"], reference())
    assert metrics(run, lwr()).tip_max_mm < 0.01
    assert run.meta["reference"]["about"]["task"] == "ist"
