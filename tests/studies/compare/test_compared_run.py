"""A part of a run has the samples of the run, with its own time, events and stops."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.studies.compare.compared_run import since, thinned


@pytest.fixture(scope="module")
def run(arm):
    move = lwr_dyn.reference("point-to-point", arm, start=[0.0] * 7, end=[0.05] * 7, duration=0.3)
    return lwr_dyn.simulate(arm, lwr_dyn.controller("pid", arm), move)


def test_the_rest_of_a_run_has_its_samples_and_its_own_time(run, arm):
    rest = since(run, 0.1)
    np.testing.assert_array_equal(rest.q, run.q[100:])
    np.testing.assert_allclose(rest.t, run.t[:201], atol=1e-15)
    tip = [lwr_dyn.forward_kinematics(arm, q)[:, :3, 3] for q in (run.q[100:], run.q_ref[100:])]
    largest = 1e3 * np.linalg.norm(tip[0] - tip[1], axis=1).max()
    assert metrics(rest, arm).tip_max_mm == pytest.approx(largest, rel=1e-12)
    assert since(run, 0.0) is run


def test_events_and_stops_before_it_are_left_out(arm):
    there = arm.upper - 0.01
    hold = lwr_dyn.reference("hold", arm, q=there, duration=0.3)
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("pid", arm), hold, q0=there, dq0=[2.0] * 7)
    assert metrics(run, arm).stops.met
    last = max(event.t for event in run.events)
    assert not metrics(since(run, last + 0.05), arm).stops.met


def test_thinned_keeps_both_ends(run):
    few = thinned(run, 100.0)
    np.testing.assert_allclose(few.t, np.linspace(0.0, 0.3, 31), atol=1e-12)
    np.testing.assert_array_equal(few.q_ref, run.q_ref[::10])
    assert few.work["actuator"].shape == (31,)
    assert thinned(few, 100.0) is few


@pytest.mark.parametrize("start", [-1.0, 0.3, 5.0, float("nan")])
def test_a_start_outside_the_run_is_refused(run, start):
    with pytest.raises(LwrDynError, match=r"since: .* s; allowed: a time from 0 to below 0.3 s"):
        since(run, start)
