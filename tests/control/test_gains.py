"""Gains of a second-order loop, and the threshold at which a sampled damping chatters, against a simulated joint."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import UNSTABLE, damping_per_sample, second_order_gains
from lwr_dyn.errors import OptionError
from lwr_dyn.papers.assembly import arm_from_paper
from lwr_dyn.papers.catalog import template
from lwr_dyn.papers.reader import parse_paper
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import StandStill


@pytest.mark.parametrize(("factor", "grows"), [(0.98, False), (1.02, True)])
def test_just_above_the_threshold_the_speed_grows(factor, grows):
    arm = arm_from_paper(parse_paper(template("own.toml", "own", "RR"), "own.toml"))
    dynamics = lwr_dyn.dynamics_of(arm)
    q = np.array([0.0, 0.4])
    unit = damping_per_sample(dynamics, np.ones(2), q[None], 1000.0)
    Kd = np.full(2, factor * UNSTABLE / unit)
    assert damping_per_sample(dynamics, Kd, q[None], 1000.0) == pytest.approx(factor * UNSTABLE)

    def damper(t, q, dq, q_ref, dq_ref, ddq_ref):
        return dynamics.gravity_vector(q) - Kd * dq

    run = simulate(arm, damper, StandStill(q, 0.2), dq0=[1e-6, -2e-6], saturate=False)
    speed = np.abs(run.dq).max(axis=1)
    assert (speed[-1] > speed[0]) is np.bool_(grows)


def test_gains_are_the_second_order_formulas_and_refuse_what_is_not_positive():
    gains = second_order_gains([2.0, 0.5], omega_n=10.0, xi=0.7)
    assert gains.Kp == pytest.approx([200.0, 50.0])
    assert gains.Kd == pytest.approx([28.0, 7.0])
    for bad in ({"omega_n": 0.0}, {"xi": -1.0}, {"omega_n": float("nan")}):
        with pytest.raises(OptionError, match="allowed: a number above 0"):
            second_order_gains([1.0], **bad)
    with pytest.raises(OptionError):
        second_order_gains([1.0, 0.0])
