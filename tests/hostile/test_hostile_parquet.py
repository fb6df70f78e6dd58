"""Parquet logs that pyarrow refuses with exceptions of its own, in its head or in its pages: one error of ours."""

import re

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from lwr_dyn.foundation.errors import FileAccessError, LogError
from lwr_dyn.identification.logs.joint_log import read_log

T = np.arange(50) * 0.01
GOOD = {"time [s]": T, "q1 [rad]": np.sin(T), "tau1 [N m]": np.cos(T)}


def written(path, columns, names=None):
    sink = pyarrow.BufferOutputStream()
    table = pyarrow.table(columns, names=names) if names else pyarrow.table(columns)
    parquet.write_table(table, sink, compression="ZSTD")
    path.write_bytes(sink.getvalue().to_pybytes())
    return path


def flipped(data, at):
    return data[:at] + bytes(255 - x for x in data[at : at + 20]) + data[at + 20 :]


def length_of_head(data):
    return int.from_bytes(data[-8:-4], "little")


DAMAGED = {
    "the last bytes are missing": lambda data: data[:-9],
    "the head is longer than the file": lambda data: data[:-8] + b"\xff\xff\xff\x7fPAR1",
    "the head is zero": lambda data: data[: -8 - length_of_head(data)] + bytes(length_of_head(data)) + data[-8:],
    "the head of a page is damaged": lambda data: flipped(data, 4),
    "a page cannot be decompressed": lambda data: flipped(data, 30),
    "the second column's page is damaged": lambda data: flipped(data, data.index(b"\x28\xb5\x2f\xfd", 250)),
}


@pytest.mark.parametrize("damage", DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_file_is_refused_by_its_name(damage, tmp_path):
    path = written(tmp_path / "x.parquet", GOOD)
    read_log(path)
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(FileAccessError, match=r"x\.parquet: not a whole Parquet file; allowed: a log"):
        read_log(path)


MAPS = pyarrow.array([[("a", 1.0)]] * 50, type=pyarrow.map_(pyarrow.string(), pyarrow.float64()))
TWICE = ["time [s]", "q1 [rad]", "q1 [rad]", "tau1 [N m]"]
COLUMNS = {
    **{f"column q1 [rad]: of type {kind}": (GOOD | {"q1 [rad]": column}, None) for kind, column in {
        "list<": [["1.0", "2.0"]] * 50, "struct<": [{"a": 1.0}] * 50, "map<": MAPS, "string": ["a"] * 50,
        "binary": [b"a"] * 50}.items()},
    # a list of numbers is columns of other names
    "q1 missing; the file has time [s], q1 [rad].0, q1 [rad].1, tau1": (GOOD | {"q1 [rad]": [[1.0, 2.0]] * 50}, None),
    "column q1: stands twice": ([T] * 4, TWICE),
}  # fmt: skip


@pytest.mark.parametrize("says", COLUMNS)
def test_a_column_without_numbers_or_name_of_its_own_is_named(says, tmp_path):
    with pytest.raises(LogError, match=re.escape(says)) as refused:
        read_log(written(tmp_path / "x.parquet", *COLUMNS[says]))
    assert ("; needed: numbers" in str(refused.value)) == ("type" in says)
