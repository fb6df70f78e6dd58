"""The task `csv`: the motion that was written comes back, with its derivatives; what an arm cannot do is refused."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.spatial import to_rpy
from lwr_dyn.trajectory.motion_files import MotionFileError
from lwr_dyn.trajectory.references.recorded_motion import csv_reference

ARM, KR = lwr_dyn.load("lwr4plus"), lwr_dyn.load("kr30ha")
T = np.linspace(0.0, 2.0, 201)
MIDDLE = np.array([0.2, 0.5, 0.0, -1.2, 0.1, 0.6, 0.0])


def written(path, head, table):
    path.write_text(head + "\n" + "\n".join(",".join(f"{x!r}" for x in row) for row in table.tolist()) + "\n")
    return str(path)


def joints_file(path, q, t=T, unit=""):
    return written(path, "time," + ",".join(f"q{k + 1}{unit}" for k in range(q.shape[1])), np.column_stack([t, q]))


def pose_file(path, poses, t=T):
    rpy = np.array([to_rpy(R) for R in poses[:, :3, :3]])
    return written(path, "time,x,y,z,roll,pitch,yaw", np.column_stack([t, poses[:, :3, 3], rpy]))


def swing(t, pace=1.5):
    return MIDDLE + 0.3 * np.sin(pace * t)[:, None] * np.linspace(1.0, 0.4, 7)


@pytest.mark.parametrize(("unit", "factor"), [("", 1.0), (" [deg]", 180.0 / np.pi)])
def test_positions_come_back_with_their_derivatives(tmp_path, unit, factor):
    reference = csv_reference(ARM, file=joints_file(tmp_path / "m.csv", factor * swing(T), unit=unit))
    t = np.linspace(0.1, 1.9, 77)
    motion, scale = reference.sample(t), 0.3 * np.linspace(1.0, 0.4, 7)
    assert motion.q == pytest.approx(swing(t), abs=1e-9)
    assert motion.dq == pytest.approx(1.5 * np.cos(1.5 * t)[:, None] * scale, abs=1e-7)
    assert motion.ddq == pytest.approx(-(1.5**2) * np.sin(1.5 * t)[:, None] * scale, abs=1e-5)
    assert reference.duration == 2.0


def test_it_stands_still_outside_and_can_be_slower(tmp_path):
    file = joints_file(tmp_path / "m.csv", swing(T))
    reference, scale = lwr_dyn.reference("csv", ARM, file=file, slower=2.0), 0.45 * np.linspace(1.0, 0.4, 7)
    motion = reference.sample(np.array([-1.0, 2.0, 9.0]))
    assert motion.q == pytest.approx(swing(np.array([0.0, 1.0, 2.0])), abs=1e-9)
    assert motion.dq == pytest.approx(0.5 * np.outer([0.0, np.cos(1.5), 0.0], scale), abs=1e-7)
    speeds = 0.5 * 0.45 * np.abs([1.0, np.cos(3.0)])
    assert (reference.duration, reference.about) == (4.0, {
        "task": "csv", "file": file, "rows": 201, "slower": 2.0, "given": "joint positions", "left_out": [],
        "speed_at_ends": pytest.approx(speeds, abs=1e-6),
    })  # fmt: skip


def test_the_csv_of_a_run_is_a_reference(tmp_path):
    move = lwr_dyn.reference("point-to-point", ARM, start=MIDDLE, end=MIDDLE + 0.1, duration=0.5)
    run = lwr_dyn.simulate(ARM, lwr_dyn.controller("inverse-dynamics", ARM), move, rate=200.0)
    run.save(tmp_path / "run.csv")
    again = lwr_dyn.reference("csv", ARM, file=str(tmp_path / "run.csv"))
    assert again.sample(run.t).q == pytest.approx(run.q, abs=1e-12)
    assert "tau1 [N m]" in again.about["left_out"]


def test_poses_of_a_redundant_arm_and_of_one_with_six_joints(tmp_path):
    """The tip follows them; the arm angle is that with the largest margin, or that of the start."""
    six = np.array([0.3, -1.2, 1.4, 0.2, 0.7, 0.1]) + 0.2 * np.sin(T)[:, None]
    for arm, q, start in ((ARM, swing(T), None), (ARM, swing(T), MIDDLE), (KR, six, None)):
        poses = flange_pose(arm.chain, q)
        reference = lwr_dyn.reference("csv", arm, file=pose_file(tmp_path / "p.csv", poses), start=start)
        found = reference.sample(T).q
        assert flange_pose(arm.chain, found) == pytest.approx(poses, abs=1e-7)
        assert start is None or np.abs(found - q).max() < 0.2


def test_what_the_arm_cannot_do_is_said_in_one_line(tmp_path):
    far, jump = flange_pose(ARM.chain, swing(T)), flange_pose(ARM.chain, swing(T))
    far[120:, 0, 3] += 3.0
    jump[100:] = flange_pose(ARM.chain, swing(T)[100:] + 0.6)
    six = flange_pose(KR.chain, np.tile([0.3, -1.2, 1.4, 0.2, 0.7, 0.1], (201, 1)))
    six[60:, 0, 3] += 9.0
    beyond, fast = swing(T), MIDDLE + 0.3 * np.sin(20.0 * T)[:, None]
    beyond[:, 3] += 1.5 * np.sin(T) ** 2 + 2.5
    good, start = joints_file(tmp_path / "0.csv", swing(T)), {"start": MIDDLE}
    close = flange_pose(ARM.chain, np.tile(MIDDLE, (201, 1)))
    close[:, :3, 3] *= np.linspace(1.0, 0.3, 201)[:, None]
    faults = [
        (pose_file(tmp_path / "8.csv", close), {}, "s: no arm angle keeps joint_4 within its limits, 0."),
        (joints_file(tmp_path / "1.csv", swing(T)[:, :6]), {}, "columns: q1 to q6; allowed: q1 to q7 for lwr4plus"),
        (joints_file(tmp_path / "2.csv", beyond), {}, "joint_4 at"),
        (joints_file(tmp_path / "3.csv", np.degrees(swing(T))), {}, "are these degrees? then q1 [deg] in the header"),
        (joints_file(tmp_path / "4.csv", fast), {}, "times its speed limit; allowed: slower motion: --slower"),
        (pose_file(tmp_path / "5.csv", far), {}, "t = 1.2 s: the wrist is"),
        (pose_file(tmp_path / "6.csv", six), {}, "t = 0.6 s: the arm does not reach the pose from the one before"),
        (pose_file(tmp_path / "7.csv", jump), start, "(rad or m) from the row before; allowed: poses within reach"),
        (good, start, "start: given with joint positions; allowed: a file of poses, or no start"),
        (good, {"slower": 0.0}, "slower: 0.0; allowed: a number from"),
        (str(tmp_path / "5.csv"), {"start": [0.0]}, "start: 1 number; allowed: 7 numbers"),
    ]
    for file, options, words in faults:
        with pytest.raises((MotionFileError, OptionError, ShapeError)) as caught:
            lwr_dyn.reference("csv", KR if "6.csv" in file else ARM, file=file, **options)
        assert words in str(caught.value)
        assert "\n" not in str(caught.value)
    motion = lwr_dyn.reference("csv", ARM, file=good).sample(T)
    assert motion.q == pytest.approx(swing(T), abs=1e-12)


def test_the_slower_motion_that_is_named_is_allowed(tmp_path):
    file = joints_file(tmp_path / "m.csv", MIDDLE + 0.3 * np.sin(20.0 * T)[:, None])
    with pytest.raises(MotionFileError) as caught:
        lwr_dyn.reference("csv", ARM, file=file)
    slower = float(str(caught.value).rpartition(" ")[2])
    motion = lwr_dyn.reference("csv", ARM, file=file, slower=slower).sample(np.linspace(0.0, 2.0 * slower, 5000))
    assert 0.97 < np.abs(motion.dq / ARM.velocity).max() <= 1.0
