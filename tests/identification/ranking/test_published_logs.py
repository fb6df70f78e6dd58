"""Logs by address: what is written of them, the two here, files recognised by their digest; the one filter."""

import shutil
from importlib.resources import files

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import robots
from lwr_dyn.foundation.errors import LogError, OptionError, PaperError, UnknownNameError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.ranking import published_logs as module
from lwr_dyn.identification.ranking.filtered_log import EDGE, FilterRule, filtered_log, trained_and_tested
from lwr_dyn.identification.ranking.published_logs import digest_of_file, published_log, published_logs, recognised

FOLDER = files("lwr_dyn.identification.ranking") / "logs"
LOGS = published_logs()


def test_each_log_states_its_source_and_is_of_a_robot_here():
    for log in LOGS.values():
        assert log.robot in robots()
        assert {len(log.commit), *(len(one.sha256) for one in log.files)} == {40, 64}
        assert all((log.licence, log.load, log.gains))


@pytest.mark.parametrize(
    ("text", "own", "where"),
    [
        ("[[log]]", "mass = 1\n[[log]]", "mass"), ("[[log]]", "[[log]]\nmass = 1", r"log\[0\]\.mass"),
        ("files = [{ path", "files = [{ mass = 1, path", r"log\[0\]\.files\[0\]\.mass"),
    ],
)  # fmt: skip
def test_a_field_that_nothing_reads_is_refused(text, own, where, tmp_path, monkeypatch):
    whole = (FOLDER.parent / "logs.toml").read_text("utf-8")
    (tmp_path / "logs.toml").write_text(whole.replace(text, own, 1), "utf-8")
    monkeypatch.setattr(module, "_FOLDER", tmp_path)
    with pytest.raises(PaperError, match=f"logs.toml: {where}: unknown field"):
        published_logs.__wrapped__()


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


def made_log(name, files, step, **given):
    """A log without words about it."""
    head = (name, "r", "", "here", "", "mine", "measured", "", "")
    return module.PublishedLog(*head, step, 5.0, 40, tuple(files), **given)


def test_fetched_files_are_recognised_under_any_name_and_brought_to_the_joints(tmp_path, monkeypatch):
    rng = np.random.default_rng(0)
    qm, taum = rng.normal(size=(2, 50, 2))
    for name, table in (("a", qm), ("b", taum)):
        np.savetxt(tmp_path / name, table, delimiter=",", header="x,y", comments="")
    ratios, home = np.array([[30.0, 0.0], [20.0, -20.0]]), np.array([0.1, -0.2])
    files = [module.LogFile(key, digest_of_file(tmp_path / name), "numbers", 2, 1, {key: (1, 2)}, (11, 50))
             for key, name in (("q", "a"), ("tau", "b"))]  # fmt: skip
    log = made_log("two", files, 0.01, factors=np.array([1.0, 2.0]), ratios=ratios, home=home)
    monkeypatch.setattr(module, "published_logs", lambda: {"two": log})
    _, read = published_log("two", tmp_path)
    np.testing.assert_allclose((read.q - home) @ ratios.T, qm[10:49], rtol=1e-12)
    np.testing.assert_allclose(read.tau, taum[10:49] @ ratios * [1.0, 2.0], rtol=1e-12)


def test_repeated_times_are_dropped_and_the_clock_is_even(tmp_path, monkeypatch):
    t = np.repeat(np.arange(0.0, 1.0, 0.01), 2)[:, None]
    np.savetxt(tmp_path / "t", np.hstack([t, 3 * t, 5 * t]))
    columns = {"time": (1, 1), "q": (2, 2), "tau": (3, 3)}
    log = made_log("t", [module.LogFile("t", digest_of_file(tmp_path / "t"), "numbers", 3, 0, columns)], 0.004)
    monkeypatch.setattr(module, "published_logs", lambda: {"t": log})
    read = published_log("t", tmp_path)[1]
    np.testing.assert_allclose(np.diff(read.t), 0.004)
    np.testing.assert_allclose(read.tau[:, 0], 5 * read.t, atol=1e-12)


def sine(t, noise=0.0):
    q = np.sin(3.0 * t)[:, None]
    return JointLog("sine", (1,), t, q + noise * np.random.default_rng(0).normal(size=q.shape), 2.0 * q)


def test_a_slow_motion_passes_the_filter_with_its_derivatives_and_trains_before_it_tests():
    found = filtered_log(sine(np.arange(0.0, 5.0, 0.002)), FilterRule())
    for name, wanted, error in (("q", np.sin, 1e-4), ("dq", lambda x: 3 * np.cos(x), 1e-3),
                                ("ddq", lambda x: -9 * np.sin(x), 5e-3)):  # fmt: skip
        np.testing.assert_allclose(getattr(found, name)[:, 0], wanted(3 * found.t), atol=error)
    np.testing.assert_allclose(found.tau, 2 * found.q, atol=1e-12)
    np.testing.assert_allclose(np.diff(found.t), 0.01)
    assert (found.t[0], found.t[-1]) == (EDGE, pytest.approx(4.998 - EDGE, abs=0.01))
    train, test = trained_and_tested(found, 0.6)
    assert len(train) == int(0.6 * len(found))
    assert np.concatenate([train.t, test.t]).tolist() == found.t.tolist()


def test_noise_beyond_the_cutoff_is_taken_away():
    t = np.arange(0.0, 5.0, 0.001)
    rough = [np.std(np.diff(filtered_log(sine(t, 1e-3), FilterRule(f)).ddq[:, 0], 2)) for f in (5.0, 40.0)]
    assert rough[0] < 0.05 * rough[1]


def test_rounded_times_are_an_even_clock_and_a_gap_splits_a_log():
    t = np.arange(150) / 30.0
    exact, rounded = (filtered_log(sine(x), FilterRule(5.0)) for x in (t, t.round(4)))
    np.testing.assert_allclose(rounded.q, exact.q, atol=2e-4)
    found = filtered_log(sine(np.concatenate([np.arange(0.0, 3.0, 0.01), np.arange(5.0, 8.0, 0.01)])), FilterRule())
    np.testing.assert_allclose(found.ddq[:, 0], -9 * np.sin(3 * found.t), atol=5e-2)
    assert not ((found.t > 2.5) & (found.t < 5.5 - 1e-9)).any()


def test_forty_rows_are_needed_after_half_a_second_is_cut_off_at_both_ends():
    t = np.arange(0.0, 5.0, 0.01)
    assert len(filtered_log(sine(t[:140]), FilterRule())) == 40
    with pytest.raises(LogError, match=r"sine: rows: 139, .* a recording with 40 rows after 0\.5 s are cut off"):
        filtered_log(sine(t[:139]), FilterRule())
    with pytest.raises(LogError, match="finite"):
        filtered_log(JointLog("x", (1,), t, np.zeros((t.size, 1)), np.full((t.size, 1), np.nan)), FilterRule())


@pytest.mark.parametrize(
    "bad", [{"cutoff": 0.0}, {"cutoff": np.inf}, {"spacing": -1.0}, {"share": 0.95}, {"share": 0.05}]
)
def test_filters_that_cannot_be_are_refused(bad):
    for share in (0.1, 0.9):
        FilterRule(share=share)
    ((name, value),) = bad.items()
    with pytest.raises(OptionError, match=f"filter {name}: {value}; allowed: "):
        FilterRule(**bad)
