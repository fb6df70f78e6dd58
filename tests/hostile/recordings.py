"""Generators of logs and run files, for `readers.py`."""

from __future__ import annotations

import functools
import io
import json
import random
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import lwr_dyn
from tests.hostile.changes import changed, flipped


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "surrogateescape"))
    return path


def _rows(rng: random.Random) -> list[list[str]]:
    t = np.cumsum(np.full(rng.choice((3, 12, 40)), 0.01))
    columns = np.column_stack([t, *(np.sin(t * k) for k in range(1, 7))])
    return [[f"{x:.6g}" for x in row] for row in columns]


def _heads(rng: random.Random) -> list[str]:
    plain = ["time", "q1", "q2", "q3", "tau1", "tau2", "tau3"]
    united = ["time [s]", "q1 [deg]", "q2 [rad]", "q3 [deg]", "tau1 [N m]", "tau2 [N m]", "tau3 [mN m]"]
    speed = ["time", "q1", "tau1", "dq1", "q2", "tau2", "dq2"]
    return rng.choice((plain, united, speed))


def motion_csv(folder: Path, rng: random.Random) -> None:
    """A motion as CSV, and the reference that it makes."""
    from lwr_dyn.trajectory.references.recorded_motion import csv_reference

    t = np.cumsum(np.full(rng.choice((8, 12, 20)), 0.05))
    joints = rng.random() < 0.6
    q = 0.2 * np.sin(np.outer(t, range(1, 8))) + [0.0, 0.5, 0.0, -1.2, 0.0, 0.6, 0.0]
    poses = np.column_stack([-0.4 + 0.1 * t, 0.1 * t, 0.3 + 0.0 * t, np.full((t.size, 3), 0.1)])
    names = [f"q{k}" for k in range(1, 8)] if joints else ["x", "y", "z", "roll", "pitch", "yaw"]
    unit = rng.choice(("", " [deg]", " [rad]")) if joints else ""
    rows = [[f"{x:.6g}" for x in row] for row in np.column_stack([t, q if joints else poses])]
    head = ["time", *(name + unit for name in names)]
    text = "\n".join(",".join(row) for row in [head, *rows])
    path = written(folder, "x.csv", changed(text, rng) if rng.random() < 0.6 else text)
    arm = lwr_dyn.load("lwr4plus")
    csv_reference(arm, file=str(path)).sample(np.linspace(-0.1, 1.0, 20))


def log_csv(folder: Path, rng: random.Random) -> None:
    """A log as CSV."""
    from lwr_dyn.identification.logs.joint_log import read_log

    lines = [",".join(row) for row in [_heads(rng), *_rows(rng)]]
    text = rng.choice(("", "", "# a log\n", "\ufeff")) + "\n".join(lines) + "\n"
    read_log(written(folder, "x.csv", changed(text, rng, "nnnnnnnnnvvrwdsx")))


def log_parquet(folder: Path, rng: random.Random) -> None:
    """A log as Parquet, its columns of several types, or its bytes changed."""
    import pyarrow
    from pyarrow import parquet

    from lwr_dyn.identification.logs.joint_log import read_log

    names, columns = _heads(rng), [list(map(float, x)) for x in zip(*_rows(rng), strict=True)]
    table = {name: _retyped(pyarrow, column, rng) for name, column in zip(names, columns, strict=True)}
    if rng.random() < 0.2:
        table[rng.choice(("x", "q9", "空", "q1 [kg]", "dq1"))] = table[names[1]]
    if rng.random() < 0.15:
        del table[rng.choice(names)]
    sink = io.BytesIO()
    parquet.write_table(pyarrow.table(table), sink, compression=rng.choice(("NONE", "SNAPPY", "ZSTD")))
    data = sink.getvalue()
    read_log(written(folder, "x.parquet", flipped(data, rng) if rng.random() < 0.3 else data))


def _retyped(pyarrow: Any, column: list[float], rng: random.Random) -> Any:
    if rng.random() < 0.02:
        column = [None if rng.random() < 0.1 else x for x in column]  # type: ignore[misc]
    if rng.random() < 0.02:
        column = [*column[:-1], float(rng.choice(("nan", "inf", "1e308", "-1")))]
    if rng.random() > 0.03:
        return pyarrow.array(column, type=rng.choice((pyarrow.float64(), pyarrow.float64(), pyarrow.float32())))
    listed = pyarrow.list_(pyarrow.float64())
    kind = rng.choice((pyarrow.string(), pyarrow.int32(), listed, pyarrow.bool_(), pyarrow.null()))
    whole = [int(x) if x is not None and abs(x) < 9 else 0 for x in column]
    values: Any = {"string": [str(x) for x in column], "int32": whole}.get(str(kind))
    return pyarrow.array(values if values is not None else [None] * len(column), type=kind)


@functools.cache
def _run_arrays() -> dict[str, Any]:
    from tests.pages.replay.replayed import lagging_run

    with tempfile.TemporaryDirectory() as place:
        lagging_run(lwr_dyn.load("lwr4plus"), 0.04, "pd-gravity", k=20, duration=0.4).save(f"{place}/x.npz")
        with np.load(f"{place}/x.npz") as stored:
            return {name: stored[name] for name in stored.files}


def run_file(folder: Path, rng: random.Random) -> None:
    """A run file: its arrays, its record, or its bytes changed; what a page says of it."""
    from lwr_dyn.arms.loading import arm_of
    from lwr_dyn.model.run import Run
    from lwr_dyn.pages.replay.replayed_runs import facts

    arrays = dict(_run_arrays())
    for _ in range(rng.choice((0, 1, 1, 2))):
        _change_array(arrays, rng)
    if rng.random() < 0.6:
        arrays["record"] = np.frombuffer(_record(arrays["record"].tobytes(), rng), dtype=np.uint8)
    sink = io.BytesIO()
    (np.savez if rng.random() < 0.7 else np.savez_compressed)(sink, **arrays)
    data = sink.getvalue()
    run = Run.load(written(folder, "x.npz", flipped(data, rng) if rng.random() < 0.2 else data))
    facts(run)
    if rng.random() < 0.02:
        arm_of(run)


def _change_array(arrays: dict[str, Any], rng: random.Random) -> None:
    name = rng.choice([x for x in arrays if x != "record"] or ["q"])
    array, kind = np.array(arrays.get(name, 0.0)), rng.randrange(12)
    if kind < 6 and array.dtype.kind != "U":
        array = array * rng.choice((0.5, -1.0, 1e6, 1.0))
    elif kind == 6:
        array = array[: rng.randrange(20)]
    elif kind == 7:
        array = array.astype(rng.choice(("f4", "i8", "U8", "c16", "?")))
    elif kind == 8:
        array = np.full(array.shape, float(rng.choice(("nan", "inf", "1e308"))))
    elif kind == 9:
        arrays.pop(name, None)
        return
    elif kind == 10:
        array, name = np.zeros(rng.choice((0, 20, 21, (20, 7)))), rng.choice(("work_x", "other", "t", "work_"))
    else:
        array = array.reshape(-1)
    arrays[name] = array


def _record(data: bytes, rng: random.Random) -> bytes:
    record = json.loads(data)
    meta = record["meta"]
    others = (None, 5, "x", [], {}, ["x"], {"lock": 5}, {"engine": "x"}, True, 1e308, "lwr4plus", {"name": "空"})
    names = ("loaded_with", "reading", "note", "payload", "audit", "file", "task", "title", "x", "y", "z")
    for _ in range(rng.choice((1, 1, 2))):
        value, key = rng.choice(others), rng.choice((*meta, *names))
        target = meta if rng.random() < 0.85 else record
        target[key if target is meta else rng.choice(("events", "schema", "meta", "more"))] = value
    if rng.random() < 0.3 and isinstance(record.get("events"), list):
        cells = ((0.1, 1e308, "x", None), ("stop", "空", 5), (None, 1, 9, -1), (None, 0.5))
        record["events"] = [*record["events"], [rng.choice(x) for x in cells]]
    text = json.dumps(record)
    return (changed(text, rng) if rng.random() < 0.1 else text).encode("utf-8", "replace")
