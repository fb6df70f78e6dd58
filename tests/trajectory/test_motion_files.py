"""Rows of CSV files: columns with units in SI, and refusals with file, line and column."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.trajectory.motion_files import read_rows

GOOD = "# a comment\n\ntime [ms], x [mm], note, q1\n0, 1, a, 2\n\n500, 3, b, 4\n"

FAULTS = {
    "": "content: empty; allowed: a line of column names, then a row for each place",
    "x,y\n1,2\n": "rows: 1; allowed: 2 to 3 places",
    "x,x\n1,2\n3,4\n": "column x: stands twice; allowed: each column once",
    "x [km]\n1\n2\n": "unit of column x: 'km'; allowed: m, mm",
    "x [mm],y\n1,2\n3,4\n": "unit of column y: none; allowed: a unit in all columns of a kind, or in none",
    "x,y [mm]\n1,2\n3,4\n": "unit of column x: none; allowed: a unit in all columns of a kind, or in none",
    "x,y\n1,2\n3\n": "line 3: 1 cells; allowed: 2, as columns",
    "x,y\n1,2\n3,nan\n": "line 3, column y: 'nan'; allowed: a finite number up to 100",
    "# a\nx,y\n1,2\n101,1\n": "line 4, column x: '101'; allowed: a finite number up to 100",
}


def written(folder, text):
    path = folder / "rows.csv"
    path.write_text(text, encoding="utf-8")
    return path


def rows_of(path):
    return read_rows(path, PaperError, "places", "place", 2, 3)


def numbers_of(path):
    rows = rows_of(path)
    return rows.numbers(rows.known(), 100.0)


def test_known_columns_are_numbers_in_si(tmp_path):
    rows = rows_of(written(tmp_path, GOOD))
    known = rows.known()
    assert known == {"time": (0, "ms"), "x": (1, "mm"), "q1": (3, None)}
    columns = rows.numbers(known)
    assert {name: column.tolist() for name, column in columns.items()} == {
        "time": [0.0, 0.5], "x": [1e-3, 3e-3], "q1": [2.0, 4.0],
    }  # fmt: skip
    assert np.array_equal(rows.numbers({"x": known["x"]})["x"], columns["x"])


def test_other_columns_are_left_out_or_refused(tmp_path):
    rows = rows_of(written(tmp_path, GOOD))
    assert "note" not in rows.known()
    with pytest.raises(PaperError, match=r"rows.csv: column: 'note'; allowed: x, y"):
        rows.known("x, y")


@pytest.mark.parametrize("text", FAULTS)
def test_a_fault_is_one_line(tmp_path, text):
    path = written(tmp_path, text)
    with pytest.raises(PaperError) as caught:
        numbers_of(path)
    assert str(caught.value) == f"{path}: {FAULTS[text]}"


def test_bytes_that_are_no_text_are_refused(tmp_path):
    path = tmp_path / "rows.csv"
    path.write_bytes(b"\xff\xfe\x00x")
    with pytest.raises(PaperError, match="content: not text; allowed: a CSV file in UTF-8"):
        rows_of(path)
