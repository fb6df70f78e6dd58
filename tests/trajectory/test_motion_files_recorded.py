"""The CSV of a motion: units by its header, other columns left out, and one clear line for what cannot be read."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.model.spatial import from_rpy
from lwr_dyn.trajectory.motion_files import MotionFileError, read_motion

ROWS = "".join(f"{0.1 * k:.1f},{k},{-k}\n" for k in range(6))
GOOD = "time,q1,q2\n" + ROWS


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "motion.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_joint_positions(written):
    motion = read_motion(written("\ufeff# a comment\n\n" + GOOD))
    assert motion.t == pytest.approx(0.1 * np.arange(6))
    assert motion.joints == pytest.approx(np.outer(np.arange(6), [1.0, -1.0]))
    assert not motion.in_degrees
    assert motion.poses is None


def test_the_header_tells_degrees_and_milliseconds(written):
    motion = read_motion(written("time [ms], q1 [deg], q2 [mm]\n" + ROWS))
    assert motion.t == pytest.approx(1e-4 * np.arange(6))
    assert motion.joints == pytest.approx(np.outer(np.arange(6), [np.pi / 180.0, -1e-3]))
    assert motion.in_degrees


def test_the_motion_begins_with_the_first_row(written):
    assert read_motion(written(GOOD.replace("time,q1,q2\n0.0,0,0\n", "time,q1,q2\n-5,0,0\n"))).t[:2] == pytest.approx(
        [0.0, 5.1]
    )


def test_other_columns_are_left_out_and_named(written):
    table = "time [s],tau1 [N m],q1 [rad],q_ref1 [rad]\n" + "".join(f"{k},9,{k},8\n" for k in range(7))
    motion = read_motion(written(table))
    assert motion.joints == pytest.approx(np.arange(7.0)[:, None])
    assert motion.left_out == ("tau1 [N m]", "q_ref1 [rad]")


def test_poses(written):
    head = "time,x [mm],y [mm],z [mm],roll [deg],pitch [deg],yaw [deg]\n"
    motion = read_motion(written(head + "".join(f"{k},{k},0,5,90,0,{k}\n" for k in range(6))))
    assert motion.poses[3, :3, 3] == pytest.approx([3e-3, 0.0, 5e-3])
    assert motion.poses[3, :3, :3] == pytest.approx(from_rpy(np.radians([90.0, 0.0, 3.0])))
    assert motion.joints is None


BAD = [
    ("", "content: empty"),
    ("time,q1\n0,1\n", "rows: 1; allowed: 6 to 1000000 moments"),
    (GOOD.replace("q2", "q3"), "column q2: missing"),
    (GOOD.replace("time", "when"), "column time: missing; allowed: time, and q1, q2, ... or x, y, z"),
    (GOOD.replace("q1,q2", "a,b"), "column x: missing"),
    (GOOD.replace("q2", "q1"), "column q1: stands twice"),
    (GOOD.replace("q2", "q2 [grad]"), "unit of column q2: 'grad'; allowed: rad, deg, m, mm"),
    (GOOD.replace("q2", "q2 [deg]"), "unit of column q1: none; allowed: a unit in all"),
    (GOOD.replace("0.3,3,-3", "0.2,3,-3"), "line 5, column time: 0.2 s after 0.2 s; allowed: rising times"),
    (GOOD.replace("0.3,3,-3", "0.1,3,-3"), "line 5, column time: 0.1 s after 0.2 s"),
    (GOOD.replace("0.3,3,-3", "0.3,nan,-3"), "line 5, column q1: 'nan'; allowed: a finite number"),
    (GOOD.replace("0.3,3,-3", "0.3,,-3"), "line 5, column q1: ''"),
    (GOOD.replace("0.3,3,-3", "0.3,1_0,-3"), "line 5, column q1: '1_0'"),
    (GOOD.replace("0.3,3,-3", "0.3,3"), "line 5: 2 cells; allowed: 3, as columns"),
]


@pytest.mark.parametrize(("text", "words"), BAD)
def test_what_cannot_be_read_is_said_in_one_line(written, text, words):
    with pytest.raises(MotionFileError) as caught:
        read_motion(written(text))
    assert words in str(caught.value)
    assert "motion.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_file_and_no_text(tmp_path):
    with pytest.raises(FileAccessError):
        read_motion(tmp_path / "none.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00time")
    with pytest.raises(MotionFileError, match="not text"):
        read_motion(tmp_path / "binary.csv")
