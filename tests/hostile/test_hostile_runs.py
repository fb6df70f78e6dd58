"""Run files that another hand has made: what is in them is looked at before it is unpacked or believed."""

import io
import json
import tracemalloc
import zipfile

import numpy as np
import pytest

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.replay_page import replay_html


@pytest.fixture
def arrays(two_runs, tmp_path):
    two_runs[0].save(tmp_path / "good.npz")
    with np.load(tmp_path / "good.npz") as stored:
        return {name: stored[name] for name in stored.files}


def with_record(arrays, **changes):
    record = json.loads(arrays["record"].tobytes())
    record.update(changes)
    return arrays | {"record": np.frombuffer(json.dumps(record).encode(), dtype=np.uint8)}


def with_meta(arrays, **changes):
    meta = json.loads(arrays["record"].tobytes())["meta"]
    return with_record(arrays, meta=meta | changes)


def saved(arrays, path):
    np.savez_compressed(path, **arrays)
    return path


@pytest.mark.slow
@pytest.mark.parametrize("name", ["work_x", "q", "t", "other"])
def test_large_arrays_are_refused_before_they_are_unpacked(name, arrays, tmp_path):
    """A small file whose zeros take 5 GB in memory."""
    path = saved(arrays, tmp_path / "x.npz")
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (600_000_000,)})
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(tmp_path / "y.npz", "w", zipfile.ZIP_DEFLATED) as new:
        for member in old.namelist():
            if member != f"{name}.npy":
                new.writestr(member, old.read(member))
        with new.open(f"{name}.npy", "w") as stream:
            stream.write(header.getvalue())
            for _ in range(60):
                stream.write(bytes(1_000_000))
    tracemalloc.start()
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(tmp_path / "y.npz")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20_000_000


@pytest.mark.parametrize("kind", ["U4", "S4", "datetime64[s]", "c16", "bool"])
def test_arrays_of_another_kind_are_refused(kind, arrays, tmp_path):
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(saved(arrays | {"q": np.zeros(arrays["q"].shape).astype(kind)}, tmp_path / "x.npz"))


@pytest.mark.slow
def test_what_simulate_writes_is_read_and_drawn(lwr_dyn_command, tmp_path):
    path = str(tmp_path / "x.npz")
    task = ("--task", "hold", "--from-deg", "0,0,0,0,0,0,0", "--duration", "0.01", "--payload", "1")
    assert lwr_dyn_command("simulate", "lwr4plus", *task, "--out", path)[0] == 0
    assert "1 kg at the flange" in replayed(path)


EVENTS = [
    [[float("nan"), "stop", 1, None]], [[1e999, "stop", 1, None]], [["1", "stop", 1, None]], [[1.0, 5, 1, None]],
    [[1.0, "stop", 7, None]], [[1.0, "stop", -1, None]], [[1.0, "stop", True, None]], [[1.0, "stop", 1.5, None]],
    [[1.0, "stop", 1, float("nan")]], [[1.0, "stop", 1, "x"]], [[1.0, "stop"]], [5], "text", {"a": 1}, None,
]  # fmt: skip
RECORDS = [
    b"", b"[]", b"5", b"{", b'{"schema": 1}', b'{"schema": 1, "events": [], "meta": 5}',
    b'{"schema": 1, "events": [], "meta": []}', b"[" * 100_000, b'{"schema": ' + b"9" * 5000 + b"}",
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("given", [*EVENTS, *RECORDS], ids=lambda x: str(x)[:60])
def test_events_and_records_that_no_run_has_are_refused(given, arrays, tmp_path):
    record = arrays | {"record": np.frombuffer(given, dtype=np.uint8)} if isinstance(given, bytes) else None
    with pytest.raises(FileAccessError, match="not a whole run file"):
        Run.load(saved(record or with_record(arrays, events=given), tmp_path / "x.npz"))


def replayed(path):
    run = Run.load(path)
    return replay_html([run], arm_of(run))


META = {
    "loaded_with": [5, ["x"], {"lock": 5}, {"engine": "x"}, {"lock": {"A1": "x"}}, {"tip": 5}, {"lock": {"A1": None}}],
    "reading": [["x"], 5], "robot": [5, {"a": 1}, "a\0b"], "file": [5, "/dev/zero", "x.urdf\0"], "digest": [[]],
    "note": [5, []], "audit": [5, {"closed": True}, {"closed": 1, "inverse_dynamics": 3}],
    "payload": [5, {"com": 5}, {"mass": "x"}], "reference_trace": ["x", [[1], [2, 3]]],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("name", "value"), [(name, x) for name, values in META.items() for x in values], ids=str)
def test_facts_of_another_kind_are_one_error_of_ours(name, value, arrays, tmp_path):
    path = saved(with_meta(arrays, **{name: value}), tmp_path / "x.npz")
    with pytest.raises(LwrDynError):
        replayed(path)
