"""CSV files of places and motions: columns with units in SI, and refusals with file, line and column."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError, PaperError
from lwr_dyn.model.spatial import from_rpy
from lwr_dyn.trajectory.motion_files import (
    MotionFileError,
    WaypointError,
    Waypoints,
    read_motion,
    read_rows,
    read_waypoints,
)


def read_numbers(path):
    rows = read_rows(path, PaperError, "places", "place", 2, 3)
    return rows.numbers(rows.known(), 100.0)


READERS = {read_numbers: PaperError, read_waypoints: WaypointError, read_motion: MotionFileError}
WAYPOINTS = "x, y, z and perhaps roll, pitch, yaw; or q1, q2, ...; and perhaps time"
MOTION = "time, and q1, q2, ... or x, y, z, roll, pitch, yaw"
UNITS = "none; allowed: a unit in all columns of a kind, or in none"
ROWS = "".join(f"{0.1 * k:.1f},{k},{-k}\n" for k in range(6))
MOVED = "time,q1,q2\n" + ROWS
FAULTS = [
    (read_numbers, "", "content: empty; allowed: a line of column names, then a row for each place"),
    (read_numbers, "x,y\n1,2\n", "rows: 1; allowed: 2 to 3 places"),
    (read_numbers, "x\n1\n2\n3\n4\n", "rows: 4; allowed: 2 to 3 places"),
    (read_numbers, "x,x\n1,2\n3,4\n", "column x: stands twice; allowed: each column once"),
    (read_numbers, "x [km]\n1\n2\n", "unit of column x: 'km'; allowed: m, mm"),
    (read_numbers, "x [mm],y\n1,2\n3,4\n", f"unit of column y: {UNITS}"),
    (read_numbers, "x,y [mm]\n1,2\n3,4\n", f"unit of column x: {UNITS}"),
    (read_numbers, "roll [deg],yaw\n1,2\n3,4\n", f"unit of column yaw: {UNITS}"),
    (read_numbers, "x,y\n1,2\n3\n", "line 3: 1 cells; allowed: 2, as columns"),
    (read_numbers, "x,y\n1,2\n3,nan\n", "line 3, column y: 'nan'; allowed: a finite number up to 100"),
    (read_numbers, "# a\nx,y\n1,2\n101,1\n", "line 4, column x: '101'; allowed: a finite number up to 100"),
    (read_numbers, "x\n100\n-100.1\n", "line 3, column x: '-100.1'; allowed: a finite number up to 100"),
    (read_waypoints, "x,y,z\n1,2,3\n", "rows: 1; allowed: 2 to 10000 waypoints"),
    (read_waypoints, "x,y\n1,2\n3,4\n", f"columns: x, y; allowed: {WAYPOINTS}"),
    (read_waypoints, "time\n0\n1\n", f"columns: time alone; allowed: {WAYPOINTS}"),
    (read_waypoints, "x,y,z,roll\n1,2,3,4\n1,2,3,4\n", f"columns: x, y, z, roll; allowed: {WAYPOINTS}"),
    (read_waypoints, "x,y,z,q1\n1,2,3,4\n1,2,3,4\n", f"columns: x, y, z, q1; allowed: {WAYPOINTS}"),
    (read_waypoints, "q2,q3\n1,2\n1,2\n", f"columns: q2, q3; allowed: {WAYPOINTS}"),
    (read_waypoints, "x,y,z,speed\n1,2,3,4\n1,2,3,4\n", f"column: 'speed'; allowed: {WAYPOINTS}"),
    (read_waypoints, "q1 [deg],q2\n1,2\n1,2\n", f"unit of column q2: {UNITS}"),
    (read_waypoints, "x,y,z\n1,2,3\n1,two,3\n", "line 3, column y: 'two'; allowed: a finite number"),
    (read_waypoints, "time,x,y,z\n0,1,2,3\n1,1,2,3\n1,1,2,4\n", "row 3, time: 1 s after 1 s; allowed: rising times"),
    (read_motion, "time,q1\n0,1\n", "rows: 1; allowed: 6 to 1000000 moments"),
    (read_motion, "time,q1\n0,1\n" * 3, "rows: 5; allowed: 6 to 1000000 moments"),
    (read_motion, MOVED.replace("q2", "q3"), f"column q2: missing; allowed: {MOTION}"),
    (read_motion, MOVED.replace("time", "when"), f"column time: missing; allowed: {MOTION}"),
    (read_motion, MOVED.replace("q1,q2", "a,b"), f"column x: missing; allowed: {MOTION}"),
    (read_motion, MOVED.replace("q2", "q1"), "column q1: stands twice; allowed: each column once"),
    (read_motion, MOVED.replace("q2", "q2 [grad]"), "unit of column q2: 'grad'; allowed: rad, deg, m, mm"),
    (read_motion, MOVED.replace("q2", "q2 [deg]"), f"unit of column q1: {UNITS}"),
    (read_motion, MOVED.replace("0.3,3", "0.2,3"), "line 5, column time: 0.2 s after 0.2 s; allowed: rising times"),
    (read_motion, MOVED.replace("0.3,3", "0.1,3"), "line 5, column time: 0.1 s after 0.2 s; allowed: rising times"),
    (read_motion, MOVED.replace("0.3,3", "0.2000009,3"),
     "line 5, column time: 0.200001 s after 0.2 s; allowed: rising times"),
    (read_motion, MOVED.replace("0.3,3,-3", "0.3,,-3"), "line 5, column q1: ''; allowed: a finite number up to 1e+09"),
    (read_motion, MOVED.replace("0.3,3,-3", "0.3,1_0,-3"),
     "line 5, column q1: '1_0'; allowed: a finite number up to 1e+09"),
    (read_motion, MOVED.replace("0.3,3,-3", "0.3,1.1e9,-3"),
     "line 5, column q1: '1.1e9'; allowed: a finite number up to 1e+09"),
    (read_motion, MOVED.replace("0.3,3,-3", "0.3,3"), "line 5: 2 cells; allowed: 3, as columns"),
]  # fmt: skip


def written(folder, text):
    path = folder / "rows.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(("reader", "text", "words"), FAULTS, ids=[words for *_, words in FAULTS])
def test_a_fault_is_one_line_with_its_place(tmp_path, reader, text, words):
    path = written(tmp_path, text)
    with pytest.raises(READERS[reader]) as caught:
        reader(path)
    assert str(caught.value) == f"{path}: {words}"


@pytest.mark.parametrize("reader", READERS)
def test_a_file_that_is_no_text_or_not_there(tmp_path, reader):
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00x")
    with pytest.raises(READERS[reader], match="content: not text; allowed: a CSV file in UTF-8"):
        reader(tmp_path / "b.csv")
    with pytest.raises(FileAccessError, match=r"allowed: a readable \.csv file of (places|waypoints|a motion)"):
        reader(tmp_path / "none.csv")


def test_known_columns_are_numbers_in_si_and_others_are_left_out_or_refused(tmp_path):
    path = written(tmp_path, "# a comment\n\ntime [ms], x [mm], note, q1\n0, 1, a, 2\n\n500, 3, b, 4\n")
    rows = read_rows(path, PaperError, "places", "place", 2, 3)
    assert rows.known() == {"time": (0, "ms"), "x": (1, "mm"), "q1": (3, None)}
    columns = {name: column.tolist() for name, column in rows.numbers(rows.known()).items()}
    assert columns == {"time": [0.0, 0.5], "x": [1e-3, 3e-3], "q1": [2.0, 4.0]}
    with pytest.raises(PaperError, match=r"rows.csv: column: 'note'; allowed: x, y"):
        rows.known("x, y")


def test_waypoints_are_poses_places_or_joint_positions_perhaps_with_times(tmp_path):
    head = "x [mm], y [m], z [m], roll [deg], pitch [rad], yaw [deg]"
    poses = read_waypoints(written(tmp_path, f"# a square\n{head}\n\n100,0.2,0.3,180,0,0\n1,2,3,0,0,90\n"))
    np.testing.assert_allclose(poses.poses[:, :3, 3], [[0.1, 0.2, 0.3], [1e-3, 2.0, 3.0]])
    turned = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    np.testing.assert_allclose(poses.poses[:, :3, :3], [np.diag([1, -1, -1]), turned], atol=1e-15)
    assert (poses.places, poses.joints, poses.times) == (None, None, None)
    copy = poses.tip_poses()
    copy[:] = 0.0
    assert poses.poses.any()
    places = read_waypoints(written(tmp_path, "time,x,y,z\n0,1,2,3\n1.5,4,5,6\n"))
    np.testing.assert_array_equal(places.places, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(places.times, [0.0, 1.5])
    np.testing.assert_array_equal(places.tip_poses()[1], [[1, 0, 0, 4], [0, 1, 0, 5], [0, 0, 1, 6], [0, 0, 0, 1]])
    joints = read_waypoints(written(tmp_path, "q2 [deg], q1 [rad]\n180,1\n0,2\n"))
    np.testing.assert_allclose(joints.joint_positions(2, "w.csv"), [[1, np.pi], [2, 0]])
    for points, n in ((joints, 2), (Waypoints(), 0)):
        with pytest.raises(WaypointError, match=f"w.csv: columns: q1 to q{n}; allowed: q1 to q7") as fault:
            points.joint_positions(7, "w.csv")
        assert fault.value.file == "w.csv"
    assert Waypoints().tip_poses().shape == (0, 4, 4)


def test_joint_positions_of_a_motion_that_begins_with_the_first_row(tmp_path):
    motion = read_motion(written(tmp_path, "\ufeff# a comment\n\n" + MOVED.replace("0.0,0,0", "-5,0,0")))
    assert motion.t == pytest.approx([0.0, 5.1, 5.2, 5.3, 5.4, 5.5])
    assert motion.joints == pytest.approx(np.outer(np.arange(6), [1.0, -1.0]))
    assert (motion.poses, motion.in_degrees, motion.left_out) == (None, False, ())


def test_the_header_tells_degrees_and_milliseconds(tmp_path):
    motion = read_motion(written(tmp_path, "time [ms], q1 [deg], q2 [mm]\n" + ROWS))
    assert motion.t == pytest.approx(1e-4 * np.arange(6))
    assert motion.joints == pytest.approx(np.outer(np.arange(6), [np.pi / 180.0, -1e-3]))
    assert motion.in_degrees


def test_other_columns_of_a_motion_are_left_out_and_named(tmp_path):
    table = "time [s],tau1 [N m],q1 [rad],q_ref1 [rad]\n" + "".join(f"{k},9,{k},8\n" for k in range(7))
    motion = read_motion(written(tmp_path, table))
    assert motion.joints == pytest.approx(np.arange(7.0)[:, None])
    assert motion.left_out == ("tau1 [N m]", "q_ref1 [rad]")


def test_poses_of_a_motion(tmp_path):
    head = "time,x [mm],y [mm],z [mm],roll [deg],pitch [deg],yaw [deg]\n"
    motion = read_motion(written(tmp_path, head + "".join(f"{k},{k},0,5,90,0,{k}\n" for k in range(6))))
    assert motion.poses[3, :3, 3] == pytest.approx([3e-3, 0.0, 5e-3])
    assert motion.poses[3, :3, :3] == pytest.approx(from_rpy(np.radians([90.0, 0.0, 3.0])))
    assert motion.joints is None
