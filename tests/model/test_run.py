"""A run file gives the run back to the last bit; anything else is one clear error."""

import json
from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.model.run import Event, Run


@pytest.fixture
def run(two_runs):
    return replace(two_runs[0], events=(Event(2.5, "torque limit", 1), Event(3.0, "stop", 2, 0.25), Event(4.0, "end")))


def test_a_run_file_gives_the_run_back(run, tmp_path):
    run.save(tmp_path / "x.npz")
    back = Run.load(tmp_path / "x.npz")
    for name in ("t", "q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction", "energy"):
        np.testing.assert_array_equal(getattr(back, name), getattr(run, name))
    assert set(back.work) == set(run.work)
    assert (back.events, back.meta) == (run.events, run.meta)
    assert not back.q.flags.writeable


def test_its_representation_is_short(run):
    assert repr(run) == "Run(lwr4plus, n=7, 3001 samples to t = 6 s, 3 events)"


def stored(path, **changes):
    """A run file with some of its arrays replaced; None takes one away."""
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files} | changes
    np.savez(path, **{name: value for name, value in arrays.items() if value is not None})


def record(**changes):
    return np.frombuffer(json.dumps({"schema": 1, "events": [], "meta": {}} | changes).encode(), dtype=np.uint8)


FAULTS = {
    "an array lost": ({"dq": None}, "not a whole run file"),
    "rows lost": ({"dq": np.zeros((3, 7))}, "not a whole run file"),
    "not a number": ({"q": np.full((3001, 7), np.nan)}, "not a whole run file"),
    "no record": ({"record": None}, "not a whole run file"),
    "another schema": ({"record": record(schema=2)}, "run file of schema 2; allowed: schema 1"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_broken_file_is_refused(fault, run, tmp_path):
    changes, words = FAULTS[fault]
    run.save(tmp_path / "x.npz")
    stored(tmp_path / "x.npz", **changes)
    with pytest.raises(FileAccessError, match=words):
        Run.load(tmp_path / "x.npz")


def test_a_missing_and_a_cut_file_are_refused(run, tmp_path):
    with pytest.raises(FileAccessError, match="no such file"):
        Run.load(tmp_path / "none.npz")
    run.save(tmp_path / "x.npz")
    (tmp_path / "x.npz").write_bytes((tmp_path / "x.npz").read_bytes()[:500])
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(tmp_path / "x.npz")
