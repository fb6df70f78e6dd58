"""The threshold at which sampled damping chatters, against a simulated joint."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.sampled_damping import UNSTABLE, sampled_damping
from lwr_dyn.papers.assembly import arm_from_paper
from lwr_dyn.papers.catalog import template
from lwr_dyn.papers.reader import parse_paper
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.simulation.swing import Rest


@pytest.mark.parametrize(("factor", "grows"), [(0.98, False), (1.02, True)])
def test_just_above_the_threshold_the_speed_grows(factor, grows):
    arm = arm_from_paper(parse_paper(template("own.toml", "own", "RR"), "own.toml"))
    dynamics = lwr_dyn.dynamics_of(arm)
    q = np.array([0.0, 0.4])
    unit = sampled_damping(dynamics, np.ones(2), q[None], 1000.0)
    Kd = np.full(2, factor * UNSTABLE / unit)
    assert sampled_damping(dynamics, Kd, q[None], 1000.0) == pytest.approx(factor * UNSTABLE)

    def damper(t, q, dq, q_ref, dq_ref, ddq_ref):
        return dynamics.gravity_vector(q) - Kd * dq

    run = simulate(arm, damper, Rest(q, 0.2), dq0=[1e-6, -2e-6], saturate=False)
    speed = np.abs(run.dq).max(axis=1)
    assert (speed[-1] > speed[0]) is np.bool_(grows)
