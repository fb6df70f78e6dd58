"""A reference twice: its parts, its smoothness, and the parts of its run."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Event
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.trajectory.references.ist import Twice, part_of
from lwr_dyn.trajectory.references.joint_moves import point_to_point

ARM = lwr_dyn.load("lwr4plus")
ONCE = point_to_point(ARM, [np.zeros(7), np.linspace(0.2, 0.8, 7)], [2.0])
MOVE = Twice(ONCE, 1.5)


def test_both_passes_are_the_reference():
    t = np.linspace(0.0, 2.0, 41)
    once = ONCE.sample(t)
    for start in (0.0, MOVE.second):
        again = MOVE.sample(t + start)
        for name in ("q", "dq", "ddq"):
            np.testing.assert_allclose(getattr(again, name), getattr(once, name), rtol=0, atol=1e-13)
    assert (MOVE.second, MOVE.duration) == (3.5, 5.5)


def test_the_way_back_is_a_quintic_with_true_derivatives():
    t = np.linspace(2.0, 3.5, 1501)
    motion, h = MOVE.sample(t), t[1] - t[0]
    np.testing.assert_allclose(motion.q[750], np.linspace(0.2, 0.8, 7) / 2, atol=1e-12)
    for x, slope in ((motion.q, motion.dq), (motion.dq, motion.ddq)):
        np.testing.assert_allclose((x[2:] - x[:-2]) / (2 * h), slope[1:-1], atol=1e-4)
    np.testing.assert_allclose(motion.ddq[[0, -1]], 0.0, atol=1e-10)
    np.testing.assert_allclose(np.abs(motion.dq).max(axis=0), 1.875 * np.linspace(0.2, 0.8, 7) / 1.5, rtol=1e-6)


@pytest.mark.slow
def test_a_part_of_a_run_is_a_run():
    controller = lwr_dyn.controller("inverse-dynamics", ARM)
    run = lwr_dyn.simulate(ARM, controller, MOVE, payload=1.0)
    second = part_of(run, MOVE.second)
    assert (second.t[0], second.t[-1], second.t.size) == (0.0, pytest.approx(2.0), 2001)
    np.testing.assert_array_equal(second.q, run.q[3500:])
    assert second.work["actuator"][0] == 0.0
    assert second.work["actuator"][-1] == pytest.approx(run.work["actuator"][-1] - run.work["actuator"][3500])
    assert metrics(second, ARM).tip_rms_mm > 0.0
    learnt = lwr_dyn.simulate(ARM, lwr_dyn.controller("adaptive", ARM), MOVE)
    np.testing.assert_array_equal(
        part_of(learnt, 3.5).signals["adapted_payload"], learnt.signals["adapted_payload"][3500:]
    )
    assert part_of(run, 0.0, 2.0).t.size == 2001
    eventful = replace(run, events=(Event(1.0, "slip", 2), Event(4.5, "stick", 3)))
    assert part_of(eventful, MOVE.second).events == (Event(1.0, "stick", 3),)  # counted from the part's own start
    with pytest.raises(OptionError, match="part of a run"):
        part_of(run, 9.0)


def test_the_task():
    move = lwr_dyn.reference("ist-clear-twice", ARM, back=2.0)
    assert (move.duration, move.about["task"]) == (30.0, "ist-clear-twice")
    with pytest.raises(OptionError, match="back"):
        Twice(ONCE, 0.0)
