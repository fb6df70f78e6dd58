"""The tasks `line` and `waypoints` by name: waypoints are met at their times, bad options."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.spatial import rot_z, to_rpy
from lwr_dyn.trajectory.cartesian.legs import OFF_CURVE, SPEED_SHARE, STARTS, _first_positions
from lwr_dyn.trajectory.cartesian.tracking import PathStopError
from lwr_dyn.trajectory.motion_files import WaypointError, read_waypoints

SQUARE = """x [mm], y [mm], z [mm], roll [deg], pitch [deg], yaw [deg]
-400, -100, 300, 180, 0, 0
-400,  100, 300, 180, 0, 0
-500,  100, 300, 180, 0, 30
"""
START = [0.0, 0.5, 0.0, -1.5, 0.0, 1.1, 0.0]


@pytest.fixture
def file(tmp_path):
    def write(text):
        path = tmp_path / "w.csv"
        path.write_text(text)
        return str(path)

    return write


def timed(text, times):
    head, *rows = text.splitlines()
    return "\n".join(["time, " + head, *(f"{t}, {row}" for t, row in zip(times, rows, strict=True))])


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["lwr4plus", "kr30ha"])
def test_timed_waypoints_are_met_at_their_times_and_at_rest(file, robot):
    arm = lwr_dyn.load(robot)
    text = SQUARE if robot == "lwr4plus" else SQUARE.replace(" 300,", " 1300,").replace("-400,", "-1000,", 2)
    path = file(timed(text, (0.0, 4.0, 9.0)))
    motion = lwr_dyn.reference("waypoints", arm, waypoints=path).sample([0.0, 4.0, 9.0])
    np.testing.assert_allclose(lwr_dyn.forward_kinematics(arm, motion.q), read_waypoints(path).poses, atol=OFF_CURVE)
    np.testing.assert_allclose(motion.dq, 0.0, atol=1e-12)


def test_a_smooth_curve_passes_the_waypoints_at_speed(arm, file):
    path = file(SQUARE)
    reference = lwr_dyn.reference("waypoints", arm, waypoints=path, through=True)
    poses = lwr_dyn.forward_kinematics(arm, reference.sample(np.linspace(0.0, reference.duration, 4001)).q)
    for waypoint in read_waypoints(path).poses:
        assert np.abs(poses - waypoint).max(axis=(1, 2)).min() < 1e-3
    assert [leg.duration for leg in reference.legs] == [reference.duration]
    assert reference.about["off_curve"] <= OFF_CURVE


def test_a_start_adds_a_leg_to_the_first_waypoint(arm, file):
    path = file("x,y,z\n-0.45,0.05,0.4\n-0.4,-0.05,0.45\n")
    reference = lwr_dyn.reference("waypoints", arm, waypoints=path, start=START)
    ends = np.cumsum([leg.duration for leg in reference.legs])
    motion = reference.sample([0.0, *ends])
    np.testing.assert_allclose(motion.q[0], START, atol=1e-12)
    places = lwr_dyn.forward_kinematics(arm, motion.q)[1:, :3, 3]
    np.testing.assert_allclose(places, [[-0.45, 0.05, 0.4], [-0.4, -0.05, 0.45]], atol=OFF_CURVE)


@pytest.mark.parametrize(("robot", "text"), [
    ("kr30ha", "x,y,z,roll [deg],pitch [deg],yaw [deg]\n-1,-0.05,1.3,180,0,0\n-1,0.05,1.3,180,0,0\n"),
    ("lwr4plus", "x,y,z\n-0.45,0.05,0.4\n-0.45,0,0.4\n"),
])  # fmt: skip
def test_without_a_start_joint_positions_far_from_their_limits_are_found_for_the_first_waypoint(file, robot, text):
    """Of a pose they are one of the closed form; of a place alone the tip may turn on the way."""
    robot_arm, path = lwr_dyn.load(robot), file(text)
    points = read_waypoints(path)
    reference = lwr_dyn.reference("waypoints", robot_arm, waypoints=path)
    q = reference.sample([0.0, reference.duration]).q
    tips, wanted = lwr_dyn.forward_kinematics(robot_arm, q), points.tip_poses()
    np.testing.assert_allclose(tips[:, :3, 3], wanted[:, :3, 3], atol=OFF_CURVE)
    firsts = _first_positions(robot_arm, points)
    margins = [np.minimum(robot_arm.upper - x, x - robot_arm.lower).min() for x in firsts]
    assert (np.diff(margins) <= 1e-12).all()
    assert min(margins) > 0.0
    assert 2 <= len(firsts) <= STARTS
    assert any(np.allclose(q[0], x, atol=1e-9) for x in firsts)
    np.testing.assert_allclose(
        lwr_dyn.forward_kinematics(robot_arm, firsts)[:, :3, 3], [wanted[0, :3, 3]] * len(firsts)
    )
    if points.poses is not None:
        np.testing.assert_allclose(tips, wanted, atol=OFF_CURVE)
        solutions = lwr_dyn.inverse_kinematics(robot_arm, wanted[0]).solutions
        np.testing.assert_allclose(firsts, [x.q for x in solutions[:STARTS]])


def test_a_line_may_turn_to_another_orientation(arm):
    begin = lwr_dyn.forward_kinematics(arm, START)
    end, rpy = begin[:3, 3] + [0.05, 0.02, 0.1], to_rpy(begin[:3, :3] @ rot_z(0.4))
    reference = lwr_dyn.reference("line", arm, start=START, to_xyz=end, to_rpy=rpy)
    tip = lwr_dyn.forward_kinematics(arm, reference.sample([reference.duration]).q[0])
    np.testing.assert_allclose(tip[:3, 3], end, atol=OFF_CURVE)
    np.testing.assert_allclose(tip[:3, :3], begin[:3, :3] @ rot_z(0.4), atol=2 * OFF_CURVE)


def test_joint_waypoints_keep_the_speed_limits(file):
    arm = lwr_dyn.load("kr30ha")
    head = "q1 [deg],q2 [deg],q3 [rad],q4 [rad],q5 [rad],q6 [rad]"
    path = file(f"{head}\n0,-90,1.5,0,0.5,0\n30,-80,1.5,0,0.5,0\n30,-80,1.2,0,0.9,1\n")
    for smooth in (False, True):
        reference = lwr_dyn.reference("waypoints", arm, waypoints=path, through=smooth)
        assert reference.about == {"task": "waypoints", "file": str(path), "stops": not smooth}
        motion = reference.sample(np.linspace(0.0, reference.duration, 3001))
        assert (np.abs(motion.dq) / arm.velocity).max() == pytest.approx(SPEED_SHARE, abs=1e-3)
        np.testing.assert_allclose(motion.q[-1], [np.pi / 6, -4 * np.pi / 9, 1.2, 0, 0.9, 1], atol=1e-12)


HERE = lwr_dyn.forward_kinematics(lwr_dyn.load("lwr4plus"), START)[:3, 3]
FREE = {"start": START, "to_xyz": [0, 0, 1], "to_rpy": [0, 0, 0], "free_orientation": True}
OUTSIDE = "q1,q2,q3,q4,q5,q6,q7\n0,0,0,0,0,0,0\n0,3,0,0,0,0,0"


@pytest.mark.parametrize(
    ("text", "options", "error", "words"),
    [
        (None, {"start": START, "to_xyz": HERE}, OptionError, "to_xyz: where the tip starts; allowed: another place"),
        (None, {"start": [0, 3, 0, 0, 0, 0, 0], "to_xyz": HERE}, OptionError, "start: joint_2 at 3 rad"),
        (None, FREE, OptionError, "free_orientation: would do nothing"),
        (timed(SQUARE, (0, 1, 2)), {"through": True}, OptionError, "through: with the column time"),
        (OUTSIDE, {}, WaypointError, r"waypoint 2: joint_2 at 3 rad, .* outside its limits"),
        (SQUARE.replace("-400,  100", "-4000,  100"), {}, PathStopError,
         r"the leg from waypoint 1 to 2 stops at .* out of reach"),
        (SQUARE.replace("-400", "-100"), {}, PathStopError,
         r"stops at 50 % of its way, point \(-0.1, 0, 0.3\) m: no arm angle keeps joint_4 within its limits, 0.\d+ r"),
        (SQUARE.replace("-400,  100", "-400, -100"), {}, OptionError, "waypoints 1 and 2: the same pose; allowed: way"),
    ],
)  # fmt: skip
def test_options_that_cannot_be(arm, file, text, options, error, words):
    task = "line" if text is None else "waypoints"
    given = {} if text is None else {"waypoints": file(text)}
    with pytest.raises(error, match=words):
        lwr_dyn.reference(task, arm, **given, **options)


def test_a_run_at_the_tasks_own_pace_keeps_the_speed_limits(file):
    """The joint that sets the pace overshoots under control: that takes a part of the share that is left free."""
    arm = lwr_dyn.load("lwr4plus")
    head = ",".join(f"q{joint} [deg]" for joint in range(1, 8))
    points = file(f"{head}\n0,30,0,-90,0,60,0\n60,40,10,-60,5,70,20\n")
    reference = lwr_dyn.reference("waypoints", arm, waypoints=points)
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), reference, rate=500)
    assert 0.94 < (np.abs(run.dq) / arm.velocity).max() <= 1.0
