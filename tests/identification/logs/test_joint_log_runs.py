"""A run file is a log: its torques are those that act, not those held from a sample on."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, LogError
from lwr_dyn.identification.logs.joint_log import log_of_run, read_log


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    arm = lwr_dyn.load("lwr4plus")
    start, end = np.zeros(7), np.full(7, 0.5)
    move = lwr_dyn.reference("point-to-point", arm, start=start, end=end, duration=0.5)
    found = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), move)
    path = tmp_path_factory.mktemp("run") / "run.npz"
    found.save(path)
    return found, path


def test_a_run_file_is_read_at_each_sample_with_the_torque_around_it(run):
    found, path = run
    log = read_log(path, arm=lwr_dyn.load("lwr4plus"))
    mine = log_of_run(found, 1000.0)
    assert (log.source, log.joints) == (str(path), tuple(range(1, 8)))
    assert (log.t == found.t).all()
    assert (log.q == found.q).all()
    assert (log.tau == mine.tau).all()
    held, k = found.tau_applied, 100
    assert log.tau[k] == pytest.approx((held[k - 1] + held[k]) / 2)
    assert np.abs(log.tau - held).max() > 1e-3


def test_another_robot_s_run_and_what_a_run_does_not_have_are_refused(run, tmp_path):
    _, path = run
    with pytest.raises(LogError, match="joints 1, 2, 3, 4, 5, 6, 7"):
        read_log(path, arm=lwr_dyn.load("kr30ha"))
    with pytest.raises(LogError, match=r"no qm1.. in a run"):
        read_log(path, needs=("qm", "i"))
    (tmp_path / "x.npz").write_bytes(b"no run")
    with pytest.raises(FileAccessError, match=r"x\.npz"):
        read_log(tmp_path / "x.npz")
