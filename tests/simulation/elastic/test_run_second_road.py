"""The second road sees what energy does not: a torque, a position, a time that are not those of the motion."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.simulation.elastic.plant import elastic_plant
from lwr_dyn.simulation.elastic.run import second_road
from tests.simulation.elastic.elastic_arms import FRICTION, short_run


def judged(run):
    return second_road(run, elastic_plant(run.setup))


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"friction": FRICTION, "duration": 0.3}])
def test_a_true_run_is_closed(options):
    road = judged(short_run(**options))
    assert road.share <= 1.0
    assert road.judged > 20


@pytest.mark.slow
def test_what_does_not_fit_is_seen():
    run = short_run(friction=FRICTION, duration=0.15)
    moved = run.signals["theta"] + np.eye(7)[2] * 1e-7
    torque = run.tau_applied + np.eye(7)[4] * 1e-3
    changed = {
        "theta": replace(run, signals={**run.signals, "theta": moved}),
        "torque": replace(run, tau_applied=torque),
        "friction at rest": replace(run, tau_friction=run.tau_friction + 1e-3),
        "time": replace(run, t=run.t * (1 + 1e-5)),
        "speed": replace(run, dq=run.dq * (1 + 1e-3)),
    }
    assert {name: judged(each).share > 1.0 for name, each in changed.items()} == dict.fromkeys(changed, True)
    assert judged(changed["torque"]).joint == 4


def test_nothing_left_to_judge_is_no_verdict():
    run = short_run(duration=0.005)
    at_limit = replace(run, q=np.tile(run.setup.plant.arm.upper, (run.t.size, 1)))
    assert judged(at_limit) is None
