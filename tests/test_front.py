"""Functions of `import lwr_dyn` answer bad input with one clear line."""

import sys

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError, MissingPackageError
from lwr_dyn.trajectory.references.joint_moves import hold

ARM = lwr_dyn.load("lwr4plus")
BAD = {
    "a name for an arm, text": (lambda: lwr_dyn.urdf_text("lwr4plus"), "arm: 'lwr4plus'; allowed: an arm"),
    "a name for an arm, engine": (lambda: lwr_dyn.dynamics_of("lwr4plus"), "arm: 'lwr4plus'"),
    "a name for an arm, pose": (lambda: lwr_dyn.forward_kinematics("lwr4plus", np.zeros(7)), "arm: 'lwr4plus'"),
    "a name for an arm, inverse": (lambda: lwr_dyn.inverse_kinematics("lwr4plus", np.eye(4)), "arm: 'lwr4plus'"),
    "a name for an arm, run": (lambda: lwr_dyn.simulate("lwr4plus", None, None), "arm: 'lwr4plus'"),
    "no controller": (lambda: lwr_dyn.simulate(ARM, None, hold(ARM, np.zeros(7), 0.1)), "controller: None; allowed:"),
    "no reference": (lambda: lwr_dyn.simulate(ARM, lambda *x: np.zeros(7), None), "reference: None; allowed:"),
    "no engine": (lambda: lwr_dyn.dynamics_of(ARM, None), "no engine named 'None'"),
    "a number for a reading": (lambda: lwr_dyn.load("lwr4plus", 3), "no reading of lwr4plus named '3'"),
    "a null in a path": (lambda: lwr_dyn.load("a\0b.toml"), "a null character"),
    "no runs": (lambda: lwr_dyn.replay(None, "x.html"), "runs: None; allowed: a run or a list of runs"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case):
    call, message = BAD[case]
    with pytest.raises(LwrDynError) as fault:
        call()
    assert message in str(fault.value)
    assert "\n" not in str(fault.value)


def test_a_function_whose_extra_is_missing_names_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    for name in [name for name in sys.modules if name.startswith("lwr_dyn.codegen")]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(MissingPackageError, match=r"pip install 'lwr_dyn\[batch\]'"):
        lwr_dyn.batch_dynamics(ARM)


def test_a_run_of_an_arm_that_was_changed_is_replayed_with_that_arm(arm, tmp_path):
    locked = arm.with_locked_joint("joint_3", 0.0)
    hold = lwr_dyn.reference("hold", locked, q=[0.1] * 6, duration=0.01)
    run = lwr_dyn.simulate(locked, lwr_dyn.controller("pid", locked), hold)
    lwr_dyn.replay(run, tmp_path / "x.html")
    assert (tmp_path / "x.html").is_file()
