"""Rows of CSV files: columns with units in SI, and refusals with file, line and column."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError, PaperError
from lwr_dyn.trajectory.motion_files import WaypointError, read_rows, read_waypoints

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


def written_waypoints(tmp_path, text):
    path = tmp_path / "w.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_units_in_brackets_become_si(tmp_path):
    head = "x [mm], y [m], z [m], roll [deg], pitch [rad], yaw [deg]"
    rows = "100,0.2,0.3,180,0,0\n1,2,3,0,0,90\n"
    points = read_waypoints(written_waypoints(tmp_path, f"# a square\n{head}\n\n{rows}"))
    np.testing.assert_allclose(points.poses[0, :3, 3], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(points.poses[0, :3, :3], np.diag([1, -1, -1]), atol=1e-15)
    np.testing.assert_allclose(points.poses[1, :3, 0], [0, 1, 0], atol=1e-15)


def test_places_joints_and_times(tmp_path):
    places = read_waypoints(written_waypoints(tmp_path, "time,x,y,z\n0,1,2,3\n1.5,4,5,6\n"))
    np.testing.assert_array_equal(places.places, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(places.times, [0.0, 1.5])
    joints = read_waypoints(written_waypoints(tmp_path, "q2 [deg], q1 [rad]\n180,1\n0,2\n")).joint_positions(2, "w.csv")
    np.testing.assert_allclose(joints, [[1, np.pi], [2, 0]])


WAYPOINTS_FAULTS = {
    "": r"content: empty",
    "x,y,z\n1,2,3\n": r"rows: 1; allowed: 2 to 10000",
    "x,y\n1,2\n3,4\n": r"columns: x, y; allowed: x, y, z",
    "time\n0\n1\n": r"columns: time alone; allowed: x, y, z",
    "x,y,z,roll\n1,2,3,4\n1,2,3,4\n": r"columns: x, y, z, roll",
    "x,y,z,q1\n1,2,3,4\n1,2,3,4\n": r"columns",
    "q2,q3\n1,2\n1,2\n": r"columns: q2, q3",
    "x,y,z,speed\n1,2,3,4\n1,2,3,4\n": r"column: 'speed'",
    "x,y,z,x\n1,2,3,4\n1,2,3,4\n": r"column x: stands twice",
    "x [deg],y,z\n1,2,3\n1,2,3\n": r"unit of column x: 'deg'; allowed: m, mm",
    "q1 [deg],q2\n1,2\n1,2\n": r"unit of column q2: none; allowed: a unit in all columns of a kind, or in none",
    "x,y,z\n1,2,3\n1,two,3\n": r"line 3, column y: 'two'; allowed: a finite number",
    "x,y,z\n1,2,3\n1,nan,3\n": r"line 3, column y: 'nan'",
    "x,y,z\n1,2,3\n1,2\n": r"line 3: 2 cells; allowed: 3",
    "time,x,y,z\n1,1,2,3\n1,1,2,4\n": r"row 2, time: 1 s after 1 s; allowed: rising times",
}


@pytest.mark.parametrize("text", WAYPOINTS_FAULTS, ids=[repr(text[:20]) for text in WAYPOINTS_FAULTS])
def test_a_fault_is_named_with_its_place(tmp_path, text):
    with pytest.raises(WaypointError, match=WAYPOINTS_FAULTS[text]):
        read_waypoints(written_waypoints(tmp_path, text))


def test_a_file_that_is_no_text_or_not_there(tmp_path):
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00x")
    with pytest.raises(WaypointError, match="not text"):
        read_waypoints(tmp_path / "b.csv")
    with pytest.raises(FileAccessError):
        read_waypoints(tmp_path / "none.csv")


def test_another_number_of_joints(tmp_path):
    points = read_waypoints(written_waypoints(tmp_path, "q1,q2\n0,0\n1,1\n"))
    with pytest.raises(WaypointError, match="q1 to q2; allowed: q1 to q7"):
        points.joint_positions(7, "w.csv")
