"""The CSV file of waypoints: units, kinds of columns, and one clear line for each fault."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.trajectory.motion_files import WaypointError, read_waypoints


def written(tmp_path, text):
    path = tmp_path / "w.csv"
    path.write_text(text, encoding="utf-8")
    return path


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


FAULTS = {
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


@pytest.mark.parametrize("text", FAULTS, ids=[repr(text[:20]) for text in FAULTS])
def test_a_fault_is_named_with_its_place(tmp_path, text):
    with pytest.raises(WaypointError, match=FAULTS[text]):
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
