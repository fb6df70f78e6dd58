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
from lwr_dyn.model import run as run_module
from lwr_dyn.model.run import Run, format_of
from lwr_dyn.model.run_formats import csv_bytes, matlab_bytes, parquet_bytes
from tests.random_arms import random_arm


@pytest.fixture(scope="module")
def run(arm):
    """A run whose numbers have all their digits."""
    move = lwr_dyn.reference("point-to-point", arm, start=[0.0] * 7, end=[0.1] * 7, duration=0.3)
    return lwr_dyn.simulate(arm, lwr_dyn.controller("pd-gravity", arm), move)


def test_a_simulated_sliding_joint_is_recorded():
    arm = random_arm(1, "PR")
    hold = lwr_dyn.reference("hold", arm, q=[0.1] * arm.n, duration=0.01)
    run = lwr_dyn.simulate(arm, lambda *_: np.zeros(arm.n), hold)
    assert run.meta["joint_units"] == ["m", "rad"]
    assert {"q1 [m]", "q2 [rad]"} <= set(run.to_columns())


def test_pandas_and_arrow_take_the_columns_as_they_are_and_without_pandas_the_error_says_so(run, monkeypatch):
    columns = run.to_columns()
    for table in (pandas.DataFrame(columns), run.to_dataframe(), pyarrow.table(columns).to_pandas()):
        assert list(table) == list(columns)
        assert all(np.array_equal(table[name], values) for name, values in columns.items())
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingPackageError, match=r"lwr_dyn\[notebook\]'; without it: columns = run.to_columns\(\)"):
        run.to_dataframe()


def test_files_hold_all_columns_and_a_log_reader_gets_every_bit_back(run, arm, tmp_path):
    paths = [tmp_path / f"x{suffix}" for suffix in (".csv", ".parquet")]
    for path in paths:
        run.save(path)
        log = read_log(path, arm=arm)
        for name, values in (("t", run.t), ("q", run.q), ("dq", run.dq), ("tau", run.tau_applied)):
            np.testing.assert_array_equal(getattr(log, name), values)
    names = paths[0].read_text().splitlines()[0].split(",")
    read = dict(zip(names, np.loadtxt(paths[0], delimiter=",", skiprows=1).T, strict=True))
    arrow = parquet.read_table(paths[1])
    assert list(read) == arrow.column_names == list(run.to_columns())
    for name, values in run.to_columns().items():
        np.testing.assert_array_equal(read[name], values)
        np.testing.assert_array_equal(arrow[name], values)


def test_matlab_gets_matrices_and_the_record_the_same_bytes_of_the_same_run(run):
    back = loadmat(BytesIO(matlab_bytes(run)))
    for name in ("t", "q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction", "energy"):
        np.testing.assert_array_equal(back[name], getattr(run, name).reshape(run.t.size, -1))
    work = back["work"][0, 0]
    assert {name: work[name][:, 0].tolist() for name in work.dtype.names} == {
        k: x.tolist() for k, x in run.work.items()
    }
    assert json.loads(str(back["record"][0])) == json.loads(json.dumps(run.meta))
    assert [str(x).strip() for x in back["joint_units"]] == ["rad"] * 7
    assert "joint_units" not in loadmat(BytesIO(matlab_bytes(replace(run, meta={}))))
    assert csv_bytes(run) == csv_bytes(run)
    assert matlab_bytes(run) == matlab_bytes(run)
    assert matlab_bytes(run)[:116] == b"MATLAB 5.0 MAT-file, written by lwr_dyn".ljust(116)


def test_an_ending_names_its_format_and_what_it_needs(monkeypatch):
    found = [format_of(f"x{ending}") for ending in (".npz", ".csv", ".parquet", ".mat")]
    assert found == [None, csv_bytes, parquet_bytes, matlab_bytes]
    monkeypatch.setattr(run_module, "find_spec", lambda name: None)
    assert format_of("x.mat") is matlab_bytes
    for ending, package in ((".parquet", "pyarrow"), (".mcap", "rosbags")):
        with pytest.raises(MissingPackageError, match=rf"{package}.*lwr_dyn\[logs\]"):
            format_of(f"x{ending}")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("run.txt", "ends in '.txt'; allowed: a path that ends in one of .npz, .csv, .parquet, .mat, .mcap"),
        ("run", "ends in 'nothing'; allowed"),
        ("none/run.csv", "no directory none"),
    ],
)
def test_a_path_that_cannot_be_written_is_refused(name, words, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileAccessError, match=words):
        run.save(name)
    assert list(tmp_path.iterdir()) == []


def test_only_a_run_file_loads(run, tmp_path):
    run.save(tmp_path / "x.csv")
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(tmp_path / "x.csv")
