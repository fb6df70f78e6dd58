"""Columns of CSV and Parquet files come back to the last bit, and a damaged file is one line."""

import sys

import numpy as np
import pytest
from pyarrow import parquet

from lwr_dyn.foundation import column_files
from lwr_dyn.foundation.column_files import NOTES, SUFFIXES, read_columns, read_head, table_bytes
from lwr_dyn.foundation.errors import FileAccessError, LogError, MissingPackageError

NAMES = ("time", "q1", "q2")
COLUMNS = [np.array([0.0, 0.1, 0.2]), np.array([1e-300, -1.0 / 3.0, 2.5]), np.array([5e15, 0.1 + 0.2, -0.0])]

FAULTS = {
    "": "head: the file is empty; needed: a line of column names, then rows",
    "# a comment\na,b\n": "rows: none below the column names; needed: rows of numbers",
    "a,b\n1,2\n3,x\n": "row 2 (line 3), column b: 'x'; needed: a number",
    "a,b\n1,2\n3\n": "row 2 (line 3): not as many cells as columns; needed: 2 cells in every row",
    "a,b\n1,2,3\n": "row 1 (line 2): 3 cells; needed: 2 cells in every row, as many as column names",
}


def read(path, wanted):
    return read_columns(path, read_head(path), wanted)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_columns_come_back_to_the_last_bit(tmp_path, suffix):
    path = tmp_path / f"log{suffix}"
    path.write_bytes(table_bytes(NAMES, COLUMNS, suffix))
    assert read_head(path).names == NAMES
    assert read(path, [2, 0]).tobytes() == np.column_stack([COLUMNS[2], COLUMNS[0]]).tobytes()


@pytest.mark.parametrize("text", FAULTS)
def test_a_fault_names_its_line(tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(LogError) as caught:
        read(path, [0, 1])
    assert str(caught.value) == f"{path}: {FAULTS[text]}"


def test_lines_before_the_names_are_counted(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text('# a robot\n\n"a", b\n1,2\n', encoding="utf-8")
    head = read_head(path)
    assert (head.names, head.lines) == (("a", "b"), 3)


@pytest.mark.parametrize(
    ("name", "content", "error", "words"),
    [
        ("log.txt", b"a\n1\n", FileAccessError, r"ends in '\.txt'"),
        ("log.csv", b"\xff\xfe\x00", LogError, "head: not text; needed: a CSV file in UTF-8"),
        ("none.csv", None, FileAccessError, "no such file"),
        ("log.parquet", "cut", FileAccessError, "not a whole Parquet file"),
    ],
)
def test_other_and_damaged_files_are_refused(tmp_path, name, content, error, words):
    if content == "cut":
        content = table_bytes(NAMES, COLUMNS, ".parquet")[:-10]
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(error, match=words):
        read_head(tmp_path / name)


def lists_file(folder, cells, kind):
    """A column t, and one of lists: `kind` (pyarrow) -> their type."""
    import pyarrow

    table = {"t": pyarrow.array([0.0, 0.1, 0.2]), "state": pyarrow.array(cells, kind(pyarrow))}
    parquet.write_table(pyarrow.table(table), folder / "log.parquet")
    return folder / "log.parquet"


KINDS = {
    "fixed": lambda x: x.list_(x.float32(), 2), "list": lambda x: x.list_(x.float64()),
    "large": lambda x: x.large_list(x.int64()),
}  # fmt: skip


def test_a_parquet_file_without_rows_or_without_its_reader_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "log.parquet"
    path.write_bytes(table_bytes(NAMES, [np.zeros(0)] * 3, ".parquet"))
    with pytest.raises(LogError, match="rows: none; needed: rows of numbers"):
        read(path, [0])
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingPackageError, match=r"pyarrow is not installed.*logs"):
        read_head(path)


@pytest.mark.parametrize("form", KINDS)
def test_lists_of_numbers_are_a_column_an_entry(tmp_path, form):
    path = lists_file(tmp_path, [[1, 2], [3, 4], [5, 6]], KINDS[form])
    assert read_head(path).names == ("t", "state.0", "state.1")
    assert read(path, [2, 0]).tolist() == [[2.0, 0.0], [4.0, 0.1], [6.0, 0.2]]


@pytest.mark.parametrize(("cells", "found"), [([[1.0, 2.0], [3.0], [5.0, 6.0]], 1), ([[1.0, 2.0], None, [5.0]], 0)])
def test_lists_of_unequal_length_are_refused(tmp_path, cells, found):
    path = lists_file(tmp_path, cells, KINDS["list"])
    with pytest.raises(LogError, match=f"row 2, column state: {found} numbers; needed: 2, as in the first row"):
        read(path, [0, 1])


def test_lists_of_texts_and_long_ones_stay_one_column(tmp_path):
    path = lists_file(tmp_path, [["a"], ["b"], ["c"]], lambda x: x.list_(x.string()))
    assert read_head(path).names == ("t", "state")
    with pytest.raises(LogError, match="column state: of type list"):
        read(path, [1])
    assert read_head(lists_file(tmp_path, [[0] * 1001] * 3, KINDS["large"])).names == ("t", "state")
    assert len(read_head(lists_file(tmp_path, [[0] * 1000] * 3, KINDS["large"])).names) == 1001
    assert read_head(lists_file(tmp_path, [[], [1], [2]], KINDS["large"])).names == ("t", "state")


def test_heads_and_tables_are_read_up_to_their_bounds(tmp_path, monkeypatch):
    path = tmp_path / "log.csv"
    path.write_text("a," * 600_000 + "a\n")
    assert len(read_head(path).names) == 500_001  # of a million letters
    path = tmp_path / "log.parquet"
    path.write_bytes(table_bytes(NAMES, COLUMNS, ".parquet", ["one", "two"]))
    head = read_head(path)
    monkeypatch.setattr(column_files, "LARGEST", 3 * 2 * 8)
    assert read_columns(path, head, [0, 1]).shape == (3, 2)
    with pytest.raises(LogError, match="rows: 3; needed: at most 48 bytes of numbers"):
        read_columns(path, head, [0, 1, 2])
    assert parquet.read_schema(path).metadata[NOTES.encode()] == b"one\ntwo"
    assert table_bytes(["a"], [np.array([0.5])], ".csv", ["one", "two"]) == b"# one\n# two\na\n0.5\n"
