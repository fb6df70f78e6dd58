"""Figures of merit of runs written by hand."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.metrics import metrics
from tests.simulation.sample_runs import lwr, one_joint, with_limits


def run_of(q, q_ref, dq=0.0, command=0.0, applied=None):
    t = np.arange(len(q)) * 0.1
    q = np.asarray(q, dtype=float).reshape(len(t), -1)

    def column(value):
        return np.broadcast_to(np.reshape(value, (-1, 1)) if np.ndim(value) == 1 else value, q.shape)

    applied = command if applied is None else applied
    return Run(
        t, q, column(dq), column(q_ref), 0 * q, column(command), column(applied), 0 * q, energy=0 * t,
        work={"actuator": 0 * t},
    )  # fmt: skip


ARM = one_joint(JointKind.REVOLUTE, lever=0.5, lower=-1.0, upper=2.0, velocity=4.0, effort=10.0)


def test_errors_in_mrad():
    figures = metrics(run_of([0.0, 0.0, 0.0, 0.0], [0.001, -0.003, 0.0, 0.004], dq=[0.0, 0.5, 0.0, 0.0]), ARM)
    position, velocity = figures.position_mrad, figures.velocity_mrad_s
    assert position.mean[0] == pytest.approx(0.5)
    assert position.mean_abs[0] == pytest.approx(2.0)
    assert position.max[0] == pytest.approx(4.0)
    assert position.min[0] == pytest.approx(-3.0)
    assert position.rms[0] == pytest.approx(np.sqrt(26 / 4))
    assert velocity.min[0] == pytest.approx(-500.0)  # ref - actual
    assert velocity.mean[0] == pytest.approx(-125.0)


def test_torques_speeds_and_margins():
    run = run_of([0.0, 1.5, -0.9], 0.0, dq=[0.0, -2.0, 1.0], command=[5.0, -20.0, 30.0], applied=[5.0, -10.0, 10.0])
    figures = metrics(run, ARM)
    assert figures.peak_torque[0] == 10.0
    assert figures.peak_command[0] == 30.0
    assert figures.torque_use[0] == 1.0
    assert figures.peak_speed[0] == 2.0
    assert figures.speed_use[0] == 0.5
    assert figures.limit_margin[0] == pytest.approx(0.1)
    assert figures.saturated_s[0] == pytest.approx(0.1)  # the last sample is held for no time
    assert not figures.within_limits
    assert metrics(run_of([0.0, 1.5], 0.0, command=[5.0, 5.0]), ARM).within_limits
    assert not metrics(run_of([0.0, 2.1], 0.0), ARM).within_limits
    assert not metrics(run_of([0.0, 0.0], 0.0, dq=[0.0, 4.1]), ARM).within_limits


def test_unknown_limits_are_nan_and_null():
    arm = one_joint()
    figures = metrics(run_of([0.0, 1.5], 0.0, dq=[1e6, 0.0], command=[1e6, 0.0]), arm)
    assert np.isnan(figures.torque_use[0])
    assert figures.within_limits
    record = json.loads(json.dumps(figures.to_json()))
    assert record["torque_use"] == [None]
    assert record["limit_margin"] == [None]
    assert record["position_mrad"]["mean"] == [-750.0]


def test_tip_error():
    q = np.zeros((3, 7))
    q_ref = q.copy()
    q_ref[1, 1] = 0.01  # the straight arm leans: 0.868 m of lever
    t = np.arange(3) * 0.1
    zero = 0 * q
    run = Run(t, q, zero, q_ref, zero, zero, zero, zero, 0 * t, {})
    lever = 1e3 * lwr_dyn.forward_kinematics(lwr(), np.zeros(7))[2, 3]
    figures = metrics(run, lwr())
    assert figures.tip_max_mm == pytest.approx(2 * lever * np.sin(0.005), rel=1e-12)
    assert figures.tip_rms_mm == pytest.approx(figures.tip_max_mm / np.sqrt(3), rel=1e-12)


def test_a_run_of_another_arm():
    with pytest.raises(ShapeError, match="joints"):
        metrics(run_of([0.0], 0.0), with_limits(lwr(), velocity=1.0))
