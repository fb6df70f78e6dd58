"""Columns of CSV and Parquet files come back to the last bit, and a damaged file is one line."""

import numpy as np
import pytest

from lwr_dyn.foundation.column_files import SUFFIXES, read_columns, read_head, table_bytes
from lwr_dyn.foundation.errors import FileAccessError, LogError

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


def test_other_files_are_refused(tmp_path):
    with pytest.raises(FileAccessError, match=r"ends in '\.txt'"):
        read_head(tmp_path / "log.txt")
    text = tmp_path / "log.csv"
    text.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(LogError, match="head: not text; needed: a CSV file in UTF-8"):
        read_head(text)


def test_a_damaged_parquet_file_is_refused(tmp_path):
    path = tmp_path / "log.parquet"
    path.write_bytes(table_bytes(NAMES, COLUMNS, ".parquet")[:-10])
    with pytest.raises(FileAccessError, match="not a whole Parquet file"):
        read_head(path)


def lists_file(path, cells, kind):
    import pyarrow
    from pyarrow import parquet

    table = {"t": pyarrow.array([0.0, 0.1, 0.2]), "state": pyarrow.array(cells, kind)}
    parquet.write_table(pyarrow.table(table), path)
    return path


@pytest.mark.parametrize("form", ["fixed", "list", "large"])
def test_lists_of_numbers_are_a_column_an_entry(tmp_path, form):
    import pyarrow

    kinds = {
        "fixed": pyarrow.list_(pyarrow.float32(), 2),
        "list": pyarrow.list_(pyarrow.float64()),
        "large": pyarrow.large_list(pyarrow.int64()),
    }
    cells = [[1, 2], [3, 4], [5, 6]]
    path = lists_file(tmp_path / "log.parquet", cells, kinds[form])
    assert read_head(path).names == ("t", "state.0", "state.1")
    assert read(path, [2, 0]).tolist() == [[2.0, 0.0], [4.0, 0.1], [6.0, 0.2]]


@pytest.mark.parametrize(("cells", "found"), [([[1.0, 2.0], [3.0], [5.0, 6.0]], 1), ([[1.0, 2.0], None, [5.0]], 0)])
def test_lists_of_unequal_length_are_refused(tmp_path, cells, found):
    import pyarrow

    path = lists_file(tmp_path / "log.parquet", cells, pyarrow.list_(pyarrow.float64()))
    with pytest.raises(LogError, match=f"row 2, column state: {found} numbers; needed: 2, as in the first row"):
        read(path, [0, 1])


def test_lists_of_texts_and_long_ones_stay_one_column(tmp_path):
    import pyarrow

    path = lists_file(tmp_path / "log.parquet", [["a"], ["b"], ["c"]], pyarrow.list_(pyarrow.string()))
    assert read_head(path).names == ("t", "state")
    with pytest.raises(LogError, match="column state: of type list"):
        read(path, [1])
    picture = lists_file(tmp_path / "log.parquet", [[0] * 2000] * 3, pyarrow.list_(pyarrow.int64()))
    assert read_head(picture).names == ("t", "state")
