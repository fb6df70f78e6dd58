"""CSV files of places and motions: columns with units in SI, and refusals with file, line and column."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError, PaperError
from lwr_dyn.model.spatial import from_rpy
from lwr_dyn.trajectory.motion_files import MotionFileError, WaypointError, read_motion, read_rows, read_waypoints

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


def test_units_in_brackets_become_si(tmp_path):
    head = "x [mm], y [m], z [m], roll [deg], pitch [rad], yaw [deg]"
    rows = "100,0.2,0.3,180,0,0\n1,2,3,0,0,90\n"
    points = read_waypoints(written(tmp_path, f"# a square\n{head}\n\n{rows}"))
    np.testing.assert_allclose(points.poses[0, :3, 3], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(points.poses[0, :3, :3], np.diag([1, -1, -1]), atol=1e-15)
    np.testing.assert_allclose(points.poses[1, :3, 0], [0, 1, 0], atol=1e-15)


def test_places_joints_and_times(tmp_path):
    places = read_waypoints(written(tmp_path, "time,x,y,z\n0,1,2,3\n1.5,4,5,6\n"))
    np.testing.assert_array_equal(places.places, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(places.times, [0.0, 1.5])
    joints = read_waypoints(written(tmp_path, "q2 [deg], q1 [rad]\n180,1\n0,2\n")).joint_positions(2, "w.csv")
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
        read_waypoints(written(tmp_path, text))


def test_a_file_that_is_no_text_or_not_there(tmp_path):
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00x")
    with pytest.raises(WaypointError, match="not text"):
        read_waypoints(tmp_path / "b.csv")
    with pytest.raises(FileAccessError):
        read_waypoints(tmp_path / "none.csv")


def test_another_number_of_joints(tmp_path):
    points = read_waypoints(written(tmp_path, "q1,q2\n0,0\n1,1\n"))
    with pytest.raises(WaypointError, match="q1 to q2; allowed: q1 to q7"):
        points.joint_positions(7, "w.csv")


ROWS = "".join(f"{0.1 * k:.1f},{k},{-k}\n" for k in range(6))
MOTION = "time,q1,q2\n" + ROWS


def test_joint_positions(tmp_path):
    motion = read_motion(written(tmp_path, "\ufeff# a comment\n\n" + MOTION))
    assert motion.t == pytest.approx(0.1 * np.arange(6))
    assert motion.joints == pytest.approx(np.outer(np.arange(6), [1.0, -1.0]))
    assert not motion.in_degrees
    assert motion.poses is None


def test_the_header_tells_degrees_and_milliseconds(tmp_path):
    motion = read_motion(written(tmp_path, "time [ms], q1 [deg], q2 [mm]\n" + ROWS))
    assert motion.t == pytest.approx(1e-4 * np.arange(6))
    assert motion.joints == pytest.approx(np.outer(np.arange(6), [np.pi / 180.0, -1e-3]))
    assert motion.in_degrees


def test_the_motion_begins_with_the_first_row(tmp_path):
    assert read_motion(written(tmp_path, MOTION.replace("time,q1,q2\n0.0,0,0\n", "time,q1,q2\n-5,0,0\n"))).t[
        :2
    ] == pytest.approx([0.0, 5.1])


def test_other_columns_are_left_out_and_named(tmp_path):
    table = "time [s],tau1 [N m],q1 [rad],q_ref1 [rad]\n" + "".join(f"{k},9,{k},8\n" for k in range(7))
    motion = read_motion(written(tmp_path, table))
    assert motion.joints == pytest.approx(np.arange(7.0)[:, None])
    assert motion.left_out == ("tau1 [N m]", "q_ref1 [rad]")


def test_poses(tmp_path):
    head = "time,x [mm],y [mm],z [mm],roll [deg],pitch [deg],yaw [deg]\n"
    motion = read_motion(written(tmp_path, head + "".join(f"{k},{k},0,5,90,0,{k}\n" for k in range(6))))
    assert motion.poses[3, :3, 3] == pytest.approx([3e-3, 0.0, 5e-3])
    assert motion.poses[3, :3, :3] == pytest.approx(from_rpy(np.radians([90.0, 0.0, 3.0])))
    assert motion.joints is None


MOTION_FAULTS = [
    ("", "content: empty"),
    ("time,q1\n0,1\n", "rows: 1; allowed: 6 to 1000000 moments"),
    (MOTION.replace("q2", "q3"), "column q2: missing"),
    (MOTION.replace("time", "when"), "column time: missing; allowed: time, and q1, q2, ... or x, y, z"),
    (MOTION.replace("q1,q2", "a,b"), "column x: missing"),
    (MOTION.replace("q2", "q1"), "column q1: stands twice"),
    (MOTION.replace("q2", "q2 [grad]"), "unit of column q2: 'grad'; allowed: rad, deg, m, mm"),
    (MOTION.replace("q2", "q2 [deg]"), "unit of column q1: none; allowed: a unit in all"),
    (MOTION.replace("0.3,3,-3", "0.2,3,-3"), "line 5, column time: 0.2 s after 0.2 s; allowed: rising times"),
    (MOTION.replace("0.3,3,-3", "0.1,3,-3"), "line 5, column time: 0.1 s after 0.2 s"),
    (MOTION.replace("0.3,3,-3", "0.3,nan,-3"), "line 5, column q1: 'nan'; allowed: a finite number"),
    (MOTION.replace("0.3,3,-3", "0.3,,-3"), "line 5, column q1: ''"),
    (MOTION.replace("0.3,3,-3", "0.3,1_0,-3"), "line 5, column q1: '1_0'"),
    (MOTION.replace("0.3,3,-3", "0.3,3"), "line 5: 2 cells; allowed: 3, as columns"),
]


@pytest.mark.parametrize(("text", "words"), MOTION_FAULTS)
def test_what_cannot_be_read_is_said_in_one_line(tmp_path, text, words):
    with pytest.raises(MotionFileError) as caught:
        read_motion(written(tmp_path, text))
    assert words in str(caught.value)
    assert "rows.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_file_and_no_text(tmp_path):
    with pytest.raises(FileAccessError):
        read_motion(tmp_path / "none.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00time")
    with pytest.raises(MotionFileError, match="not text"):
        read_motion(tmp_path / "binary.csv")
