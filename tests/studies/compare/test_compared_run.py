"""A part of a run has the samples of the run, with its own time, events and stops."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.studies.compare.compared_run import TorqueCuts, check_same, since, thinned, torque_cuts


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
    assert [thinned(run, rate).t.size for rate in (800.0, 500.0, 300.0)] == [301, 151, 101]
    np.testing.assert_array_equal(thinned(run, 300.0).q, run.q[::3])


@pytest.mark.parametrize("start", [-1.0, 0.3, 5.0, float("nan")])
def test_a_start_outside_the_run_is_refused(run, start):
    with pytest.raises(LwrDynError, match=r"since: .* s; allowed: a time from 0 to below 0.3 s"):
        since(run, start)


def test_cuts_are_those_of_the_joint_that_is_cut_most_and_of_equals_of_the_one_that_switches_most():
    command = np.array(
        [[9, 2, -9, 0, 9, -9, 5, 9], [0, 7, 0, 0, 0, 0, 0, 0], [-4, 4, -4, 4, -4, 4, 1, 1]], dtype=float
    ).T
    arm = SimpleNamespace(effort=np.array([5.0, np.inf, 3.0]))
    for columns, share, switches in (([0, 1, 2], 6 / 8, 5), ([0, 1], 5 / 8, 4), ([1], 0.0, 0)):
        part = SimpleNamespace(effort=arm.effort[columns])
        assert torque_cuts(SimpleNamespace(tau_command=command[:, columns]), part) == TorqueCuts(share, switches)
    even = SimpleNamespace(tau_command=np.array([[9.0, 9.0], [9.0, -9.0], [0.0, 0.0]]))
    assert torque_cuts(even, SimpleNamespace(effort=np.ones(2))) == TorqueCuts(2 / 3, 1)
    assert str(TorqueCuts(0.256, 12)) == "cut in 26 % of the time, 12 times from one limit to the other"


@pytest.mark.parametrize(("share", "switches", "shakes"), [(0.03, 11, True), (0.02, 11, False), (0.03, 10, False)])
def test_a_loop_shakes_that_is_cut_for_long_and_switches_often(share, switches, shakes):
    assert TorqueCuts(share, switches).shakes is shakes


def test_references_are_the_same_to_a_nanometre_and_a_nanosecond(run):
    """301 samples, compared at a tenth of those of the slower run, 31 at least."""
    same = [{"q_ref": run.q_ref + 0.9e-9}, {"t": run.t * (1 + 1e-9)}]
    some = np.where(np.arange(301) % 10 == 0, 0.0, 5e-4)
    same += [{"t": run.t + some}]
    for change in same:
        check_same(run, "a", replace(run, **change), "b")
    few = np.where(np.arange(301) % 11 == 0, 0.0, 5e-4)
    few[-1] = 0.0
    far = run.q_ref.copy()
    far[100, 3] += 3e-9
    for change, words in (
        ({"q_ref": far}, "a and b: different references, 3e-09 rad or m apart at t = 0.1 s"),
        ({"t": run.t * (1 + 1e-8)}, "a and b: different references, 0.3 s and 0.3 s long"),
        ({"t": run.t + few}, "a and b: few common times"),
    ):
        with pytest.raises(LwrDynError, match=words):
            check_same(run, "a", replace(run, **change), "b")
