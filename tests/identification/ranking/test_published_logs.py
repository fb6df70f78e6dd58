"""Logs by address: what is written of them, the two here, and files recognised by their digest."""

import shutil
from importlib.resources import files

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import robots
from lwr_dyn.foundation.errors import LogError, UnknownNameError
from lwr_dyn.identification.ranking import published_logs as module
from lwr_dyn.identification.ranking.published_logs import (
    digest_of_file,
    published_log,
    published_logs,
    recognised,
)

FOLDER = files("lwr_dyn.identification.ranking") / "logs"
LOGS = published_logs()


@pytest.mark.parametrize("name", LOGS)
def test_each_log_states_its_source_and_is_of_a_robot_here(name):
    log = LOGS[name]
    assert log.robot in robots()
    assert len(log.commit) == 40
    assert log.licence
    assert log.load
    assert log.gains
    assert all(len(one.sha256) == 64 for one in log.files)


def test_only_logs_under_a_licence_that_allows_it_are_here():
    here = {log.committed for log in LOGS.values() if log.committed}
    assert here | {"NOTICE"} == {path.name for path in FOLDER.iterdir()}
    assert all(log.licence.startswith("BSD-3") for log in LOGS.values() if log.committed)
    notice = (FOLDER / "NOTICE").read_text()
    assert "Copyright (c) 2025, Automatic Control Group (UNISA)" in notice
    assert all(name in notice for name in here)


@pytest.mark.parametrize("name", ["panda_salerno", "ur10_salerno"])
def test_a_log_that_is_here_is_the_one_of_its_digest_by_name_and_by_file(name, tmp_path):
    log, read = published_log(name)
    assert digest_of_file(FOLDER / log.committed) == log.sha256
    other = tmp_path / "renamed.csv"
    shutil.copy(FOLDER / log.committed, other)
    assert recognised(other) is log
    np.testing.assert_array_equal(published_log(str(other))[1].q, read.q)


def test_a_changed_file_is_not_recognised(tmp_path):
    path = tmp_path / "panda.csv"
    path.write_bytes((FOLDER / "panda_salerno.csv").read_bytes() + b"\n")
    assert recognised(path) is None
    with pytest.raises(UnknownNameError):
        published_log(str(path))


def test_a_log_that_is_not_here_says_where_it_is(tmp_path):
    with pytest.raises(LogError, match=r"exciting_traj_positions.txt.*github.com/marcocognetti.*24d85ce.*GPL-3.0"):
        published_log("panda_gaz", tmp_path)


@pytest.mark.parametrize("name", ["ur10e_30s_target", "ur10_salerno_validation"])
def test_a_log_of_computed_torques_is_refused(name):
    with pytest.raises(LogError, match="computed, not measured"):
        published_log(name)


def test_fetched_files_are_recognised_under_any_name_and_brought_to_the_joints(tmp_path, monkeypatch):
    rng = np.random.default_rng(0)
    qm, taum = rng.normal(size=(2, 50, 2))
    for name, table in (("a", qm), ("b", taum)):
        np.savetxt(tmp_path / name, table, delimiter=",", header="x,y", comments="")
    ratios, home = np.array([[30.0, 0.0], [20.0, -20.0]]), np.array([0.1, -0.2])
    of = {key: module.LogFile(key, digest_of_file(tmp_path / name), "numbers", 2, 1, {key: (1, 2)}, (11, 50))
          for key, name in (("q", "a"), ("tau", "b"))}  # fmt: skip
    log = module.PublishedLog("two", "r", "", "here", "0" * 40, "mine", "measured", "", "", 0.01, 5.0, 40,
                              tuple(of.values()), factors=np.array([1.0, 2.0]), ratios=ratios, home=home)  # fmt: skip
    monkeypatch.setattr(module, "published_logs", lambda: {"two": log})
    _, read = published_log("two", tmp_path)
    np.testing.assert_allclose((read.q - home) @ ratios.T, qm[10:49], rtol=1e-12)
    np.testing.assert_allclose(read.tau, taum[10:49] @ ratios * [1.0, 2.0], rtol=1e-12)


def test_repeated_times_are_dropped_and_the_clock_is_even(tmp_path, monkeypatch):
    t = np.repeat(np.arange(0.0, 1.0, 0.01), 2)[:, None]
    np.savetxt(tmp_path / "t", np.hstack([t, 3 * t, 5 * t]))
    columns = {"time": (1, 1), "q": (2, 2), "tau": (3, 3)}
    one = module.LogFile("t", digest_of_file(tmp_path / "t"), "numbers", 3, 0, columns)
    log = module.PublishedLog("t", "r", "", "here", "", "mine", "measured", "", "", 0.004, 5.0, 40, (one,))
    monkeypatch.setattr(module, "published_logs", lambda: {"t": log})
    read = published_log("t", tmp_path)[1]
    np.testing.assert_allclose(np.diff(read.t), 0.004)
    np.testing.assert_allclose(read.tau[:, 0], 5 * read.t, atol=1e-12)
