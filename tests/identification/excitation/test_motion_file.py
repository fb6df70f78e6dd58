"""A motion as a file: a reference, a log, a run; and one that may not be run says so in its file."""

import dataclasses

import numpy as np
import pytest
from pyarrow.parquet import read_schema

import lwr_dyn
from lwr_dyn.foundation.column_files import NOTES
from lwr_dyn.identification.excitation.design import design_excitation
from lwr_dyn.identification.excitation.motion_file import run_of_excitation, write_excitation
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.model.run import Run
from lwr_dyn.trajectory.references.recorded_motion import csv_reference


@pytest.fixture(scope="module")
def designed(lwr):
    return design_excitation(lwr, starts=1)


@pytest.mark.slow
def test_its_file_is_a_reference_and_a_log(designed, lwr, tmp_path):
    table = tmp_path / "e.csv"
    write_excitation(table, designed)
    reference, exact = csv_reference(lwr, file=str(table)), designed.motion
    t = np.linspace(0.0, 10.0, 777)
    read, designed_motion = reference.sample(t), exact.sample(t)
    assert np.abs(read.q - designed_motion.q).max() < 1e-7
    assert np.abs(read.dq - designed_motion.dq).max() < 1e-5
    log = read_log(table, arm=lwr, needs=("q",))
    assert np.array_equal(log.q, designed.sampled(100.0).q)
    assert np.array_equal(log.dq, designed.sampled(100.0).dq)


@pytest.mark.slow
def test_as_a_run_it_has_the_torques_of_the_table(designed, lwr, tmp_path):
    path = tmp_path / "e.npz"
    write_excitation(path, designed, 50.0)
    run = Run.load(path)
    tau = lwr_dyn.dynamics_of(lwr, "newton-euler").inverse_dynamics(run.q, run.dq, designed.sampled(50.0).ddq)
    assert np.abs(run.tau_applied - tau).max() < 1e-9
    assert run.meta["robot"] == "lwr4plus"
    assert run.t.size == run_of_excitation(designed, 50.0).t.size == 501


def test_a_motion_that_may_not_be_run_says_so_in_its_file(designed, lwr, tmp_path):
    bad = dataclasses.replace(designed, faults=("the flange and the floor are 0.1 m too near at 2.00 s",))
    table, run, parquet = tmp_path / "e.csv", tmp_path / "e.npz", tmp_path / "e.parquet"
    write_excitation(table, bad)
    write_excitation(parquet, bad)
    said = read_schema(parquet).metadata[NOTES.encode()]
    assert said == b"DO NOT RUN IT: the flange and the floor are 0.1 m too near at 2.00 s"
    assert np.array_equal(read_log(parquet, arm=lwr, needs=("q",)).q, bad.sampled(100.0).q)
    write_excitation(parquet, designed)
    assert NOTES.encode() not in (read_schema(parquet).metadata or {})
    write_excitation(run, bad)
    assert table.read_text().startswith("# DO NOT RUN IT: the flange and the floor are 0.1 m too near at 2.00 s\ntime")
    assert np.array_equal(read_log(table, arm=lwr, needs=("q",)).q, bad.sampled(100.0).q)
    assert csv_reference(lwr, file=str(table)).duration == 10.0
    assert "the flange and the floor are 0.1 m too near" in Run.load(run).meta["task"]
