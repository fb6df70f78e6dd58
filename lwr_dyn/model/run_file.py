"""What is looked at in a run file before its arrays are unpacked, and in its record before it is believed."""

import math
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

LARGEST = 2_000_000_000
"""[bytes] The longest run file, and the most that its arrays take in memory."""
PER_TIME = ("t", "energy")
"""Arrays with one number a time; the others have one a joint."""
_META: Mapping[str, type] = {
    "robot": str, "reading": str, "file": str, "digest": str, "plant": dict, "task": str,
    "note": dict, "loaded_with": dict, "audit": dict, "payload": dict, "joint_units": list,
}  # fmt: skip
"""Entries of the record that other modules read, if they are there."""


def check_headers(path: Path, names: tuple[str, ...]) -> None:
    """Raise `ValueError`, before anything is unpacked, unless the arrays fit together and are not too large."""
    with zipfile.ZipFile(path) as archive:
        shapes = {name.removesuffix(".npy"): _shape(archive, name) for name in archive.namelist()}
    k, n = shapes["q"]
    expected = {name: (k,) if name in PER_TIME else (k, n) for name in names}
    expected |= {name: (k,) for name in shapes if name.startswith("work_")}
    expected |= {name: (k, shapes[name][-1]) for name in shapes if name.startswith("signal_")}
    wrong = [name for name, shape in expected.items() if shapes[name] != shape]
    if wrong or n < 1 or 8 * sum(map(math.prod, shapes.values())) > LARGEST:
        raise ValueError("shapes")


def _shape(archive: zipfile.ZipFile, name: str) -> tuple[int, ...]:
    with archive.open(name) as stream:
        version = np.lib.format.read_magic(stream)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, dtype = read(stream)
    if dtype.kind not in "fiu":
        raise ValueError(name)
    return tuple(shape)


def checked_record(record: Any, n: int) -> tuple[list[tuple[float, str, int | None, float | None]], dict[str, Any]]:
    """Events and facts of a record; raises `ValueError` or `TypeError` for a value of another kind."""
    events = [_event(row, n) for row in record["events"]]
    meta = {} | record["meta"]
    for name, kind in _META.items():
        if not isinstance(meta.get(name), kind | None):
            raise TypeError(name)
    if len(meta.get("joint_units") or range(n)) != n:
        raise ValueError("joint_units")
    return events, meta


def _event(row: Any, n: int) -> tuple[float, str, int | None, float | None]:
    t, kind, joint, value = row
    if not (isinstance(kind, str) and math.isfinite(t) and (value is None or math.isfinite(value))):
        raise ValueError("event")
    if joint is not None and not (type(joint) is int and 0 <= joint < n):
        raise ValueError("joint")
    return float(t), kind, joint, None if value is None else float(value)
