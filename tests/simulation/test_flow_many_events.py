"""More events in one interval than are followed: those that are, and the word that says so."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.simulation.flow import Flow
from lwr_dyn.simulation.integrators import rk4
from lwr_dyn.simulation.plant import plant_of
from tests.simulation.sample_runs import one_joint


@pytest.mark.parametrize(("half", "is_followed"), [(1e-5, False), (1e-3, True)])
def test_fifty_impacts_in_one_interval_are_followed(half, is_followed):
    """A force that turns round at each stop drives a joint of 2 kg to and fro in its range, without friction."""
    arm = one_joint(mass=2.0, lower=-half, upper=half)
    flow = Flow(plant_of(arm, lwr_dyn.dynamics_of(arm)), rk4(1))

    def turning_round(t, q, dq, memory):
        stops = sum(event.kind == "stop" for event in flow.events)
        return np.array([8.0 * (-1) ** stops]), np.zeros(0)

    y = flow.advance(turning_round, 0.0, np.array([-half, 0.0, 0.0, 0.0]), 0.5)
    kinds, crossing = [event.kind for event in flow.events], np.sqrt(half)  # 2 half = 4 t^2 / 2
    assert np.isfinite(y).all()
    assert ("more events than followed" in kinds) != is_followed
    assert kinds.count("stop") == (int(0.5 / crossing) if is_followed else 50)
    if not is_followed:
        assert flow.events[-1].t == pytest.approx(50 * crossing, rel=1e-6)
