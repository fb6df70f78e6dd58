"""The tasks `line` and `waypoints` by name: waypoints are met at their times, bad options."""

import numpy as np
import pytest
from click.testing import CliRunner

import lwr_dyn
from lwr_dyn.cli.main import group
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.trajectory.cartesian.legs import OFF_CURVE, SPEED_SHARE
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


def test_a_smooth_curve_passes_the_waypoints_at_speed(file):
    arm, path = lwr_dyn.load("lwr4plus"), file(SQUARE)
    reference = lwr_dyn.reference("waypoints", arm, waypoints=path, through=True)
    poses = lwr_dyn.forward_kinematics(arm, reference.sample(np.linspace(0.0, reference.duration, 4001)).q)
    for waypoint in read_waypoints(path).poses:
        assert np.abs(poses - waypoint).max(axis=(1, 2)).min() < 1e-3
    (leg,) = reference.legs
    assert reference.about["off_curve"] <= OFF_CURVE
    assert leg.duration == reference.duration


def test_a_start_adds_a_leg_to_the_first_waypoint(file):
    arm, path = lwr_dyn.load("lwr4plus"), file("x,y,z\n-0.45,0.05,0.4\n-0.4,-0.05,0.45\n")
    reference = lwr_dyn.reference("waypoints", arm, waypoints=path, start=START)
    assert len(reference.legs) == 2
    np.testing.assert_allclose(reference.sample([0.0]).q[0], START, atol=1e-12)
    ends = np.cumsum([leg.duration for leg in reference.legs])
    places = lwr_dyn.forward_kinematics(arm, reference.sample(ends).q)[:, :3, 3]
    np.testing.assert_allclose(places, [[-0.45, 0.05, 0.4], [-0.4, -0.05, 0.45]], atol=OFF_CURVE)


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


def test_joint_waypoints_outside_the_limits_are_named(file):
    with pytest.raises(WaypointError, match=r"waypoint 2: joint_2 at 3 rad, .* outside its limits"):
        lwr_dyn.reference(
            "waypoints", lwr_dyn.load("lwr4plus"), waypoints=file("q1,q2,q3,q4,q5,q6,q7\n0,0,0,0,0,0,0\n0,3,0,0,0,0,0")
        )


def test_waypoints_out_of_reach_name_the_leg(file):
    with pytest.raises(PathStopError, match=r"the leg from waypoint 1 to 2 stops at .* out of reach"):
        lwr_dyn.reference(
            "waypoints", lwr_dyn.load("lwr4plus"), waypoints=file(SQUARE.replace("-400,  100", "-4000,  100"))
        )


def test_options_that_cannot_be(file):
    arm = lwr_dyn.load("lwr4plus")
    here = lwr_dyn.forward_kinematics(arm, START)[:3, 3]
    with pytest.raises(OptionError, match="to_xyz: where the tip starts"):
        lwr_dyn.reference("line", arm, start=START, to_xyz=here)
    with pytest.raises(OptionError, match="start: joint_2 at 3 rad"):
        lwr_dyn.reference("line", arm, start=[0, 3, 0, 0, 0, 0, 0], to_xyz=here)
    with pytest.raises(OptionError, match="through: with the column time"):
        lwr_dyn.reference("waypoints", arm, waypoints=file(timed(SQUARE, (0, 1, 2))), through=True)
    with pytest.raises(OptionError, match="free_orientation: would do nothing"):
        lwr_dyn.reference("line", arm, start=START, to_xyz=[0, 0, 1], to_rpy=[0, 0, 0], free_orientation=True)


@pytest.mark.slow
def test_the_command_simulates_a_line(tmp_path):
    out = tmp_path / "line.npz"
    arguments = (
        "simulate lwr4plus --task line --from-deg 0,30,0,-90,0,60,0 --to-xyz -0.3,0.1,0.3 --to-rpy-deg 180,-20,170"
    )
    done = CliRunner().invoke(group, [*arguments.split(), "--out", str(out)], catch_exceptions=False)
    assert done.exit_code == 0
    run = lwr_dyn.Run.load(out)
    tip = lwr_dyn.forward_kinematics(lwr_dyn.load("lwr4plus"), run.q_ref[-1])
    np.testing.assert_allclose(tip[:3, 3], [-0.3, 0.1, 0.3], atol=OFF_CURVE)
    assert run.meta["note"]["task"] == "line"


def test_a_run_at_the_tasks_own_pace_keeps_the_speed_limits(file):
    """The joint that sets the pace overshoots under control: that takes a part of the share that is left free."""
    arm = lwr_dyn.load("lwr4plus")
    head = ",".join(f"q{joint} [deg]" for joint in range(1, 8))
    points = file(f"{head}\n0,30,0,-90,0,60,0\n60,40,10,-60,5,70,20\n")
    reference = lwr_dyn.reference("waypoints", arm, waypoints=points)
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), reference, rate=500)
    assert 0.94 < (np.abs(run.dq) / arm.velocity).max() <= 1.0
