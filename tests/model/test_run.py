"""A run file gives the run back to the last bit; anything else is one clear error."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.model import run as run_module
from lwr_dyn.model.caveats import ALL, DYNAMICS
from lwr_dyn.model.run import Event, Motion, Run, reference_argument, run_used, short_repr


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


def test_a_run_file_holds_the_bytes_that_the_run_gives(run, tmp_path):
    run.save(tmp_path / "x.npz")
    assert (tmp_path / "x.npz").read_bytes() == run.to_npz()


def test_its_representation_is_short(run):
    assert repr(run) == "Run(lwr4plus, n=7, 3001 samples to t = 6 s, 3 events)"


def test_another_record_shares_the_arrays(run):
    other = run.with_meta({**run.meta, "hint": "loop: another"})
    assert (run.hint, other.hint) == ("", "loop: another")
    assert repr(other).endswith("3 events; loop: another)")
    assert other.q is run.q
    assert other.work is run.work
    assert "hint" not in run.meta


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


def short(**changes):
    """A run of two joints and three times, each number another."""
    numbers = iter(np.arange(1.0, 200.0))
    table = {name: np.array([[next(numbers) for _ in range(2)] for _ in range(3)]) for name in TABLES}
    given = {"t": np.array([0.0, 0.5, 1.5]), "energy": np.array([7.0, 8.0, 9.0]), "work": {"actuator": np.ones(3)}}
    return Run(**{**table, **given, "meta": {"joint_units": ["rad", "m"]}, **changes})


TABLES = ("q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction")
NAMES = {
    "q": ("q1 [rad]", "q2 [m]"), "dq": ("dq1 [rad/s]", "dq2 [m/s]"), "q_ref": ("q_ref1 [rad]", "q_ref2 [m]"),
    "dq_ref": ("dq_ref1 [rad/s]", "dq_ref2 [m/s]"), "tau_command": ("tau_command1 [N m]", "tau_command2 [N]"),
    "tau_applied": ("tau1 [N m]", "tau2 [N]"), "tau_friction": ("tau_friction1 [N m]", "tau_friction2 [N]"),
}  # fmt: skip


def test_columns_have_their_names_with_units_and_their_numbers():
    one = short(signals={"pushed": np.array([[1.0], [2.0], [3.0]]), "pair": np.arange(6.0).reshape(3, 2)})
    wanted = {"time [s]": one.t}
    wanted |= {name: getattr(one, key)[:, j] for key, names in NAMES.items() for j, name in enumerate(names)}
    wanted |= {
        "energy [J]": one.energy,
        "work_actuator [J]": one.work["actuator"],
        "pushed": one.signals["pushed"][:, 0],
    }
    wanted |= {"pair1": one.signals["pair"][:, 0], "pair2": one.signals["pair"][:, 1]}
    found = one.to_columns()
    assert list(found) == list(wanted)
    assert all(np.array_equal(found[name], wanted[name]) for name in wanted)
    assert all(np.shares_memory(found[name], wanted[name]) and not found[name].flags.writeable for name in found)
    assert list(short(meta={}).to_columns())[:4] == ["time [s]", "q1", "q2", "dq1"]
    assert one.to_dataframe()["dq2 [m/s]"].tolist() == one.dq[:, 1].tolist()


def test_signals_and_work_come_back_and_their_arrays_are_checked(tmp_path):
    path = tmp_path / "x.npz"
    one = short(signals={"pair": np.arange(6.0).reshape(3, 2)}, work={"actuator": np.ones(3), "stop": np.zeros(3)})
    one.save(path)
    back = Run.load(path)
    assert np.array_equal(back.signals["pair"], one.signals["pair"])
    assert {name: x.tolist() for name, x in back.work.items()} == {"actuator": [1.0] * 3, "stop": [0.0] * 3}
    for wrong in ({"signal_pair": np.ones((2, 2))}, {"work_stop": np.zeros(2)}, {"energy": np.zeros((3, 1))},
                  {"t": np.zeros(2)}, {"q": np.array([["a", "b"]] * 3)},
                  {"tau_applied": np.zeros((3, 3))}):  # fmt: skip
        one.save(path)
        stored(path, **wrong)
        with pytest.raises(FileAccessError, match="not a whole run file; allowed: a run file"):
            Run.load(path)
    for times in ([0.0, 0.0, 1.0], [0.0, 1.0, 0.5]):
        short(t=np.array(times)).save(path)
        with pytest.raises(FileAccessError, match="times that do not rise from sample to sample"):
            Run.load(path)


@pytest.mark.parametrize("event", [(0.5, "stop", None, None), (0.5, "stop", 1, 0.25), (1, "end", 0, -3)])
def test_events_of_a_record_are_kept(event, tmp_path):
    short().save(tmp_path / "x.npz")
    stored(tmp_path / "x.npz", record=record(events=[event]))
    assert Run.load(tmp_path / "x.npz").events == (Event(*event),)


@pytest.mark.parametrize(
    "changes",
    [
        {"events": [(np.nan, "stop", None, None)]}, {"events": [(0.0, 3, None, None)]}, {"events": [(0.0, "stop")]},
        {"events": [(0.0, "stop", 2, None)]}, {"events": [(0.0, "stop", -1, None)]},
        {"events": [(0.0, "s", True, None)]},
        {"events": [(0.0, "stop", 0.0, None)]}, {"events": [(0.0, "stop", 0, np.inf)]}, {"meta": {"robot": 3}},
        {"meta": {"joint_units": ["rad"]}}, {"meta": {"joint_units": ["rad"] * 3}}, {"meta": {"audit": []}},
        {"meta": None},
    ],
)  # fmt: skip
def test_a_record_of_another_kind_is_refused(changes, tmp_path):
    short().save(tmp_path / "x.npz")
    stored(tmp_path / "x.npz", record=record(**changes))
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(tmp_path / "x.npz")


def test_a_run_larger_than_it_may_be_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    short(meta={"note": {"text": "a" * 5000}}).save(tmp_path / "x.npz")
    size = 8 * (3 + 7 * 6 + 3 + 3) + 8 * np.load(tmp_path / "x.npz")["record"].size
    monkeypatch.setattr(run_module, "LARGEST", size)
    Run.load(tmp_path / "x.npz")
    monkeypatch.setattr(run_module, "LARGEST", size - 1)
    with pytest.raises(FileAccessError):
        Run.load(tmp_path / "x.npz")


def test_a_long_record_is_short_and_a_reference_is_known_from_a_function():
    text = short_repr(Motion(np.zeros(2), *np.zeros((3, 2, 4))))
    assert text == "Motion(t=array(2,), q=array(2, 4), dq=array(2, 4), ddq=array(2, 4))"
    reference_argument(SimpleNamespace(sample=None))
    with pytest.raises(OptionError, match=r"reference: the function short; allowed: lwr_dyn.reference\(function, arm"):
        reference_argument(short)
    with pytest.raises(OptionError, match=r"reference: 3; allowed: a Reference, with `sample\(t\)` and `duration`"):
        reference_argument(3)
    assert run_used(short()) == DYNAMICS
    assert run_used(short(meta={"elasticity": {}})) == ALL
    assert (short().n, short().audit, short(meta={"audit": {"a": 1}}).audit) == (2, {}, {"a": 1})
    assert repr(short()) == "Run(unknown robot, n=2, 3 samples to t = 1.5 s, 0 events)"
