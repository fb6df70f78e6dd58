"""The torque-free swing of the paper: upright is an equilibrium, an unstable one."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.simulation.audit import audit
from lwr_dyn.simulation.simulate import CASES, free_swing
from tests.simulation.sample_runs import lwr, lwr_dynamics

DRIFT = 1e-8
"""[J] Energy error allowed to a torque-free swing of 2 s by the adaptive integrator."""


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_two_seconds_keep_their_energy(case):
    run = free_swing(lwr(), case, rate=100.0)
    result = audit(run, lwr_dynamics("newton-euler"))
    assert result.worst_energy <= DRIFT
    assert np.ptp(run.energy) <= DRIFT
    assert (run.tau_applied == 0.0).all()


def test_upright_at_rest_is_an_equilibrium_and_reported_as_one():
    run = free_swing(lwr(), "rest", duration=0.5, rate=100.0)
    assert run.meta["note"]["equilibrium"] is True
    assert np.abs(run.q).max() < 1e-2  # B^-1 g is not quite zero: com columns are printed to 1e-8 m
    pull = np.linalg.solve(lwr_dynamics().mass_matrix(np.zeros(7)), -lwr_dynamics().gravity_vector(np.zeros(7)))
    assert run.meta["note"]["acceleration_at_rest"] == pytest.approx(np.abs(pull).max(), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["speed", "offset"])
def test_the_others_are_not_and_move(case):
    run = free_swing(lwr(), case, duration=1.0, rate=100.0)
    assert run.meta["note"]["equilibrium"] is False
    assert np.abs(run.q[-1] - run.q[0]).max() > 0.1


def test_the_offset_grows():
    run = free_swing(lwr(), "offset", duration=0.3, rate=100.0)
    assert np.abs(run.q[0]).max() == pytest.approx(1e-3)
    assert np.abs(run.q[-1]).max() > 2e-3


def test_a_start_of_ones_own():
    run = free_swing(lwr(), "speed", q0=np.full(7, 0.3), dq0=np.zeros(7), duration=0.1, rate=100.0)
    assert (run.q[0] == 0.3).all()
    assert (run.dq[0] == 0.0).all()


@pytest.mark.slow
def test_rk4_with_stops_loses_only_what_the_stops_take():
    run = free_swing(lwr(), "speed", duration=2.0, method="rk4", substeps=8, position_limits=True)
    assert any(event.kind == "stop" for event in run.events)
    assert run.energy[-1] < run.energy[0] - 0.1
    assert audit(run).residual <= 1e-6
    assert metrics_margin(run) >= -1e-9


def metrics_margin(run):
    return min((run.q - lwr().lower).min(), (lwr().upper - run.q).min())


def test_no_such_case():
    with pytest.raises(UnknownNameError, match="rest"):
        free_swing(lwr(), "sideways")
