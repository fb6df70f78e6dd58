"""A run file gives the run back to the last bit; anything else is one clear error."""

import io
import json
import zipfile
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.model import run as run_module
from lwr_dyn.model.caveats import ALL, DYNAMICS
from lwr_dyn.model.run import Event, Motion, Run, reference_argument, run_used, short_repr

TABLES = ("q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction")
NAMES = {
    "q": ("q1 [rad]", "q2 [m]"), "dq": ("dq1 [rad/s]", "dq2 [m/s]"), "q_ref": ("q_ref1 [rad]", "q_ref2 [m]"),
    "dq_ref": ("dq_ref1 [rad/s]", "dq_ref2 [m/s]"), "tau_command": ("tau_command1 [N m]", "tau_command2 [N]"),
    "tau_applied": ("tau1 [N m]", "tau2 [N]"), "tau_friction": ("tau_friction1 [N m]", "tau_friction2 [N]"),
}  # fmt: skip
EVENTS = (Event(0.5, "torque limit", 1), Event(1.0, "stop", 0, -0.25), Event(1.5, "end"))
PAIR = np.arange(6.0).reshape(3, 2)


def short(**changes):
    """A run of two joints and three times, each number another."""
    numbers = iter(np.arange(1.0, 200.0))
    table = {name: np.array([[next(numbers) for _ in range(2)] for _ in range(3)]) for name in TABLES}
    given = {"t": np.array([0.0, 0.5, 1.5]), "energy": np.array([7.0, 8.0, 9.0]), "work": {"actuator": np.ones(3)}}
    return Run(**{**table, **given, "meta": {"joint_units": ["rad", "m"]}, **changes})


def contents(run):
    arrays = {name: getattr(run, name) for name in ("t", *TABLES, "energy")}
    lists = [{name: x.tolist() for name, x in group.items()} for group in (arrays, run.work, run.signals)]
    return lists, run.events, run.meta


def record(**changes):
    return np.frombuffer(json.dumps({"schema": 1, "events": [], "meta": {}} | changes).encode(), dtype=np.uint8)


@pytest.fixture
def stored(tmp_path):
    """The path of a run file some of whose arrays are others; None takes one away."""

    def write(**changes):
        short(signals={"pair": PAIR}).save(tmp_path / "x.npz")
        with np.load(tmp_path / "x.npz") as file:
            arrays = {name: file[name] for name in file.files} | changes
        np.savez(tmp_path / "x.npz", **{name: value for name, value in arrays.items() if value is not None})
        return tmp_path / "x.npz"

    return write


def test_a_run_file_gives_the_run_back_with_headers_of_the_second_version_too(tmp_path, stored):
    work = {"actuator": np.ones(3), "stop": np.zeros(3)}
    run = short(signals={"pair": PAIR}, work=work, events=EVENTS, meta={"robot": "own", "audit": {"a": 1}})
    run.save(tmp_path / "x.npz")
    assert (tmp_path / "x.npz").read_bytes() == run.to_npz()
    back = Run.load(tmp_path / "x.npz")
    assert contents(back) == contents(run)
    assert not any(x.flags.writeable for x in (back.t, back.q, back.energy, back.work["stop"], back.signals["pair"]))
    assert repr(back) == "Run(own, n=2, 3 samples to t = 1.5 s, 3 events)"
    with zipfile.ZipFile(stored()) as old, zipfile.ZipFile(tmp_path / "y.npz", "w") as new:
        for name in old.namelist():
            stream = io.BytesIO()
            np.lib.format.write_array(stream, np.lib.format.read_array(old.open(name)), version=(2, 0))
            new.writestr(name, stream.getvalue())
    assert contents(Run.load(tmp_path / "y.npz")) == contents(short(signals={"pair": PAIR}))


def test_another_record_shares_the_arrays():
    run = short()
    other = run.with_meta({**run.meta, "hint": "loop: another"})
    assert (run.hint, other.hint, other.n, run.audit) == ("", "loop: another", 2, {})
    assert repr(run) == "Run(unknown robot, n=2, 3 samples to t = 1.5 s, 0 events)"
    assert repr(other) == "Run(unknown robot, n=2, 3 samples to t = 1.5 s, 0 events; loop: another)"
    assert other.q is run.q
    assert other.work is run.work
    assert "hint" not in run.meta
    assert repr(short(**{name: np.zeros((0, 2)) for name in TABLES}, t=np.zeros(0))).endswith(
        "0 samples to t = 0 s, 0 events)"
    )


EMPTY = {name: np.zeros((3, 0)) for name in TABLES} | {"record": record(), "signal_pair": None}
FAULTS = [
    {"dq": None}, {"record": None}, {"dq": np.zeros((2, 2))}, {"tau_applied": np.zeros((3, 3))}, {"t": np.zeros(2)},
    {"energy": np.zeros((3, 1))}, {"work_stop": np.zeros(2)}, {"signal_pair": np.ones((2, 2))}, EMPTY,
    {"q": np.full((3, 2), np.nan)}, {"q": np.array([["a", "b"]] * 3)}, {"q": np.zeros((3, 2), dtype=complex)},
    *({"record": record(events=[event])} for event in (
        (np.nan, "stop", None, None), (0.0, 3, None, None), (0.0, "stop"), (0.0, "stop", 2, None),
        (0.0, "stop", -1, None), (0.0, "stop", True, None), (0.0, "stop", 0.0, None), (0.0, "stop", 0, np.inf))),
    *({"record": record(meta=meta)} for meta in (None, {"joint_units": ["rad"]}, {"joint_units": ["rad"] * 3})),
]  # fmt: skip


@pytest.mark.parametrize("changes", FAULTS, ids=lambda x: " ".join(x) if len(x) < 3 else "no joint")
def test_a_broken_file_is_refused(changes, stored):
    with pytest.raises(FileAccessError, match="not a whole run file; allowed: a run file"):
        Run.load(stored(**changes))


@pytest.mark.parametrize("event", [(0.5, "stop", None, None), (0.5, "stop", 1, 0.25), (1, "end", 0, -3)])
def test_events_of_a_record_are_kept(event, stored):
    assert Run.load(stored(record=record(events=[event]))).events == (Event(*event),)


KINDS = {
    **dict.fromkeys(("robot", "reading", "file", "digest", "task", "hint"), "x"),
    **{name: {} for name in ("plant", "note", "loaded_with", "audit", "payload")},
    "joint_units": ["rad", "m"],
}


def test_facts_of_the_record_are_of_their_kind_or_absent(stored):
    for meta in (KINDS, dict.fromkeys(KINDS), {"other": 3}):
        assert Run.load(stored(record=record(meta=meta))).meta == meta
    for name in KINDS:
        with pytest.raises(FileAccessError, match="not a whole run file"):
            Run.load(stored(record=record(meta=KINDS | {name: 3})))


def test_other_files_are_refused_in_their_own_words(tmp_path, stored):
    for changes, words in (
        ({"record": record(schema=2)}, "run file of schema 2; allowed: schema 1"),
        ({"t": np.array([0.0, 0.0, 1.0])}, "times that do not rise from sample to sample"),
        ({"t": np.array([0.0, 1.0, 0.5])}, "times that do not rise from sample to sample"),
    ):
        with pytest.raises(FileAccessError, match=words):
            Run.load(stored(**changes))
    with pytest.raises(FileAccessError, match="no such file"):
        Run.load(tmp_path / "none.npz")
    path = stored()
    path.write_bytes(path.read_bytes()[:500])
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(path)


def test_columns_have_their_names_with_units_and_their_numbers():
    one = short(signals={"pushed": np.array([[1.0], [2.0], [3.0]]), "pair": PAIR})
    wanted = {"time [s]": one.t}
    wanted |= {name: getattr(one, key)[:, j] for key, names in NAMES.items() for j, name in enumerate(names)}
    wanted |= {"energy [J]": one.energy, "work_actuator [J]": one.work["actuator"]}
    wanted |= {"pushed": one.signals["pushed"][:, 0]}
    wanted |= {"pair1": one.signals["pair"][:, 0], "pair2": one.signals["pair"][:, 1]}
    found = one.to_columns()
    assert list(found) == list(wanted)
    assert all(np.array_equal(found[name], wanted[name]) for name in wanted)
    assert all(np.shares_memory(found[name], wanted[name]) and not found[name].flags.writeable for name in found)
    assert list(short(meta={}).to_columns())[:4] == ["time [s]", "q1", "q2", "dq1"]


def test_a_run_larger_than_it_may_be_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    short(meta={"note": {"text": "a" * 5000}}).save(tmp_path / "x.npz")
    size = 8 * (3 + 7 * 6 + 3 + 3) + 8 * np.load(tmp_path / "x.npz")["record"].size
    monkeypatch.setattr(run_module, "LARGEST", size)
    Run.load(tmp_path / "x.npz")
    monkeypatch.setattr(run_module, "LARGEST", size - 1)
    with pytest.raises(FileAccessError):
        Run.load(tmp_path / "x.npz")


@dataclass
class Shown:
    """A record with a field of each sort."""

    array: object = field(default_factory=lambda: np.zeros((2, 3)))
    nothing: object = None
    text: str = "word " * 30
    one: tuple = (1,)
    more: dict = field(default_factory=lambda: {1: 2, 3: 4})
    other: object = field(default_factory=SimpleNamespace)
    hidden: int = field(default=1, repr=False)


def test_a_record_is_shown_in_at_most_five_lines():
    text = short_repr(Motion(np.zeros(2), *np.zeros((3, 2, 4))))
    assert text == "Motion(t=array(2,), q=array(2, 4), dq=array(2, 4), ddq=array(2, 4))"
    words = " ".join(["'word", *["word"] * 9, "[...],"])
    whole = f"Shown(array=array(2, 3), nothing=None, text={words} one=1 entry, more=2 entries, other=SimpleNamespace)"
    assert " ".join(short_repr(Shown()).split()) == whole
    many = type("Many", (), {"__dataclass_fields__": Run.__dataclass_fields__})()
    for name in Run.__dataclass_fields__:
        setattr(many, name, "z" * 55)
    lines = [f"  {name}='{'z' * 55}'," for name in ("t", "q", "dq", "q_ref", "dq_ref")]
    assert short_repr(many) == f"Many({lines[0].strip()}\n" + "\n".join(lines[1:]) + " ...)"
    firsts = [short_repr(Shown("y" * 41, "y" * k, *[2.0**0.5] * 4)).split("\n")[0] for k in (42, 43)]
    assert [len(first) for first in firsts] == [110, 56]  # a line has at most 110 characters


def test_a_reference_is_known_from_a_function_and_a_run_says_what_it_stands_on():
    reference_argument(SimpleNamespace(sample=None))
    for given, words in (
        (short, r"reference: the function short; allowed: lwr_dyn.reference\(function, arm"),
        (3, r"reference: 3; allowed: a Reference, with `sample\(t\)` and `duration`"),
    ):
        with pytest.raises(OptionError, match=words):
            reference_argument(given)
    assert [run_used(short(meta=meta)) for meta in ({}, {"elasticity": {}})] == [DYNAMICS, ALL]
    assert short(meta={"audit": {"a": 1}}).audit == {"a": 1}
