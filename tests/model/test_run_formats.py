"""A run as a table and in files of other programs gives its numbers back to the last bit."""

import json
import sys
from dataclasses import replace
from io import BytesIO

import numpy as np
import pandas
import pyarrow
import pytest
from pyarrow import parquet
from scipy.io import loadmat

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, MissingPackageError
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.model.run import RUN_FORMATS, Run
from lwr_dyn.model.run_formats import csv_bytes, matlab_bytes
from tests.random_arms import random_arm


@pytest.fixture(scope="module")
def run(arm):
    """A run whose numbers have all their digits."""
    move = lwr_dyn.reference("point-to-point", arm, start=[0.0] * 7, end=[0.1] * 7, duration=0.3)
    return lwr_dyn.simulate(arm, lwr_dyn.controller("pd-gravity", arm), move)


def test_columns_are_views_named_with_their_units(run):
    columns = run.to_columns()
    assert list(columns)[:2] == ["time [s]", "q1 [rad]"]
    assert list(columns)[-4:] == ["energy [J]", "work_actuator [J]", "work_friction [J]", "work_stop [J]"]
    assert np.shares_memory(columns["q3 [rad]"], run.q)
    assert columns["tau2 [N m]"] is not columns["tau_command2 [N m]"]
    np.testing.assert_array_equal(columns["tau2 [N m]"], run.tau_applied[:, 1])
    np.testing.assert_array_equal(columns["dq_ref7 [rad/s]"], run.dq_ref[:, 6])
    assert len(columns) == 1 + 7 * run.n + 1 + len(run.work)
    assert not any(column.flags.writeable for column in columns.values())


def test_a_sliding_joint_is_in_metres_and_an_unknown_one_has_no_unit(run):
    units = ["m", *["rad"] * 6]
    columns = replace(run, meta={"joint_units": units}).to_columns()
    assert {"q1 [m]", "dq1 [m/s]", "tau1 [N]", "q2 [rad]"} <= set(columns)
    assert {"q1", "dq1", "tau1", "time [s]"} <= set(replace(run, meta={}).to_columns())


def test_a_simulated_sliding_joint_is_recorded():
    arm = random_arm(1, "PR")
    hold = lwr_dyn.reference("hold", arm, q=[0.1] * arm.n, duration=0.01)
    run = lwr_dyn.simulate(arm, lambda *_: np.zeros(arm.n), hold)
    assert run.meta["joint_units"] == ["m", "rad"]
    assert {"q1 [m]", "q2 [rad]"} <= set(run.to_columns())


def test_pandas_and_arrow_take_the_columns_as_they_are(run):
    for table in (pandas.DataFrame(run.to_columns()), run.to_dataframe(), pyarrow.table(run.to_columns()).to_pandas()):
        assert table.shape == (run.t.size, len(run.to_columns()))
        np.testing.assert_array_equal(table["tau_friction4 [N m]"], run.tau_friction[:, 3])


def test_without_pandas_the_error_says_what_to_use(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingPackageError, match=r"lwr_dyn\[notebook\]'; without it: columns = run.to_columns\(\)"):
        run.to_dataframe()


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_log_reader_gets_every_bit_back(suffix, run, arm, tmp_path):
    path = tmp_path / f"run{suffix}"
    run.save(path)
    log = read_log(path, arm=arm)
    for name, values in (("t", run.t), ("q", run.q), ("dq", run.dq), ("tau", run.tau_applied)):
        np.testing.assert_array_equal(getattr(log, name), values)


def test_all_columns_are_in_the_files(run, tmp_path):
    for suffix in (".csv", ".parquet"):
        run.save(tmp_path / f"x{suffix}")
    names = (tmp_path / "x.csv").read_text().splitlines()[0].split(",")
    read = dict(zip(names, np.loadtxt(tmp_path / "x.csv", delimiter=",", skiprows=1).T, strict=True))
    arrow = parquet.read_table(tmp_path / "x.parquet")
    for name, values in run.to_columns().items():
        np.testing.assert_array_equal(read[name], values)
        np.testing.assert_array_equal(arrow[name], values)


def test_matlab_gets_matrices_and_the_record(run):
    back = loadmat(BytesIO(matlab_bytes(run)), simplify_cells=False)
    for name in ("q", "dq_ref", "tau_applied"):
        np.testing.assert_array_equal(back[name], getattr(run, name))
    np.testing.assert_array_equal(back["t"][:, 0], run.t)
    np.testing.assert_array_equal(back["work"]["actuator"][0, 0][:, 0], run.work["actuator"])
    assert json.loads(str(back["record"][0]))["robot"] == "lwr4plus"


def test_the_same_run_gives_the_same_bytes(run):
    assert csv_bytes(run) == csv_bytes(run)
    first = matlab_bytes(run)
    assert b"Created on" not in first
    assert first == matlab_bytes(run)


BAD = {
    "another ending": ("run.txt", "ends in '.txt'; allowed: a path that ends in one of .npz, .csv, .parquet,"),
    "no ending": ("run", "ends in 'nothing'; allowed"),
    "no folder": ("none/run.csv", "no directory none"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_path_that_cannot_be_written_is_refused(case, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name, words = BAD[case]
    with pytest.raises(FileAccessError, match=words):
        run.save(name)
    assert list(tmp_path.iterdir()) == []


def test_only_a_run_file_loads(run, tmp_path):
    run.save(tmp_path / "x.csv")
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(tmp_path / "x.csv")


def test_a_record_with_another_number_of_units_is_refused(run, tmp_path):
    replace(run, meta={"joint_units": ["rad"]}).save(tmp_path / "x.npz")
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(tmp_path / "x.npz")


def test_each_format_is_loaded(run):
    assert all(len(RUN_FORMATS.load(name)(run)) > 1000 for name in RUN_FORMATS.names)
