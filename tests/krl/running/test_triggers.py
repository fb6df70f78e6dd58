"""BRAKE more than once in one motion: it stops each time on its path, and its triggers keep their places."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.krl.running.cell import cell_of
from lwr_dyn.krl.running.program_run import run_program
from tests.krl.short_programs import HOME, SPEEDS, program_of

MAIN = [
    *SPEEDS, HOME, "INTERRUPT DECL 5 WHEN $IN[7] DO h( )", "INTERRUPT ON 5",
    "TRIGGER WHEN PATH = -120 DELAY = 0 DO $OUT[4]=TRUE", "LIN_REL {Y 400}", "WAIT SEC 1", "END", "DEF h( )", "BRAKE",
    "WAIT SEC 0.5",
]  # fmt: skip


@pytest.mark.parametrize("second", [1.53, 1.56, 1.8, 2.4])
def test_brake_stops_a_motion_that_goes_on_after_brake(arm, second):
    """The first one at 1 s; the second one while the arm gets up to speed, and later."""
    times = ((1.0, True), (1.1, False), (second, True), (second + 0.1, False))
    replies = [{"after_s": t, "set": {"$IN[7]": on}} for t, on in times]
    cell = cell_of({"inputs": {"7": False}, "reply": replies})
    run = run_program(program_of(*MAIN), arm, cell=cell)
    kinds = [x.kind for x in run.executed]
    assert kinds == ["PTP (start)", "LIN_REL", "BRAKE", "WAIT", "LIN_REL", "BRAKE", "WAIT", "LIN_REL", "WAIT"]
    t = np.linspace(0.0, run.duration, 3000)
    motion = run.timeline.sample(t)
    start = lwr_dyn.forward_kinematics(arm, run.motion.q[0])[:3, 3]
    away = lwr_dyn.forward_kinematics(arm, motion.q)[:, :3, 3] - start
    assert np.abs(away[:, [0, 2]]).max() < 1e-9
    assert (np.diff(away[:, 1]) > -1e-12).all()
    assert away[-1, 1] == pytest.approx(0.4, abs=1e-9)
    for x in (x for x in run.executed if x.kind == "WAIT"):
        assert np.abs(motion.dq[(t > x.begin) & (t < x.end)]).max() < 1e-12
    slope = np.diff(motion.q, axis=0) / np.diff(t)[:, None]
    assert np.abs(slope - 0.5 * (motion.dq[1:] + motion.dq[:-1])).max() < 0.05 * np.abs(motion.dq).max()
    (fired,) = [x for x in run.events if x.kind == "trigger"]
    place = lwr_dyn.forward_kinematics(arm, run.timeline.sample(np.array([fired.time])).q[0])[:3, 3]
    assert 1e3 * (place - start)[1] == pytest.approx(280, abs=0.01)
