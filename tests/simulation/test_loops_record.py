"""What a run writes: works of a log from its definition, the warning of active friction, the error of divergence."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import DivergenceError
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.simulation.contact import ACTIVE_FRICTION
from lwr_dyn.simulation.loops import Log, active_friction
from lwr_dyn.simulation.setup import Loop, prepare
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import StandStill, one_joint


def pushed(t, q, dq, q_ref, dq_ref, ddq_ref):
    return np.array([3.0])


def setup(friction="none", **options):
    return prepare(one_joint(), pushed, StandStill(np.zeros(1), 0.003), Loop(friction=friction, **options))


def test_a_blank_log_has_the_start_and_nothing_else():
    log = Log.blank(setup(q0=[0.2], dq0=[-1.0]))
    assert log.states.shape == (4, 2, 1)
    assert log.states[0].tolist() == [[0.2], [-1.0]]
    assert not log.states[1:].any()
    assert (log.done, log.friction) == (0, None)
    assert Log.blank(setup([JointFriction(Direction(1.0, 0.0), Direction(1.0, 0.0))])).friction.shape == (4, 1)


def test_under_hold_the_work_is_torque_times_travel_and_continuous_runs_bring_their_own():
    log = Log.blank(setup())
    log.states[:, 0, 0] = [0.0, 0.1, 0.4, 0.4]
    log.applied[:, 0] = [2.0, -1.0, 5.0, 7.0]
    log.works[:, 1] = [0.0, -0.1, -0.2, -0.4]
    log.works[:, 0] = [0.0, 1.0, 1.0, 1.0]
    log.done = 3
    np.testing.assert_allclose(log.work()["actuator"], [0.0, 0.2, -0.1])
    np.testing.assert_allclose(log.work()["friction"], [0.0, -0.1, -0.3])
    assert log.work()["stop"].tolist() == [0.0, 0.0, 0.0]
    log.continuous = True
    np.testing.assert_allclose(log.work()["actuator"], [0.0, 1.0, 2.0])


def test_friction_that_feeds_energy_in_is_reported_once_per_joint_and_direction():
    t = np.arange(5.0)
    dq = np.array([[1.0, 1.0], [2.0, 0.0], [3.0, 0.0], [-1.0, 1.0], [-2.0, 1.0]])
    tau = np.array([[1.0, 1.0], [-1.0, 9.0], [-1.0, -9.0], [-1.0, 0.0], [1.0, 1.0]])
    found = [(event.t, event.kind, event.joint, event.value) for event in active_friction(t, dq, tau)]
    assert found == [(1.0, ACTIVE_FRICTION, 0, 2.0), (4.0, ACTIVE_FRICTION, 0, -2.0)]


def test_a_run_that_diverges_names_joint_and_time_and_keeps_what_was_computed():
    def broken(t, q, dq, q_ref, dq_ref, ddq_ref):
        return np.array([np.nan if t > 0.0015 else 1e9])

    with pytest.raises(DivergenceError, match=r"joint_1.*; allowed: ") as fault:
        simulate(one_joint(), broken, StandStill(np.zeros(1), 0.01))
    run = fault.value.run
    assert run.t.size >= 1
    assert run.meta["diverged"]["t"] == fault.value.t == run.t[-1]
    assert run.meta["diverged"]["joint"] == "joint_1"
    assert np.isfinite(run.q).all()
