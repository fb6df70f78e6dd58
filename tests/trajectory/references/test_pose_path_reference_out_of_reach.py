"""A path that the arm cannot follow is refused with its place."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import PathLimitError, SingularArmError
from lwr_dyn.kinematics.solution import Branch
from lwr_dyn.trajectory.motion_profile import quintic
from lwr_dyn.trajectory.path import line, path_of
from lwr_dyn.trajectory.pose_path import constant_orientation, timed_pose_path
from lwr_dyn.trajectory.references.pose_path_reference import FixedArmAngle, pose_path_reference

ARM = lwr_dyn.load("lwr4plus")


def test_a_given_curve_out_of_reach_or_through_a_singularity_is_refused_with_its_place():
    far = path_of([line((0.3, 0.3, 0.5), (0.3, 2.3, 0.5))])
    own = FixedArmAngle(0.0, Branch(1, 1, 1))
    with pytest.raises(PathLimitError, match=r"at t = 2 s, point .* 1\.\d+ m out of reach"):
        pose_path_reference(ARM, timed_pose_path(far, constant_orientation(np.eye(3)), quintic(far.length, 2.0)), own)
    # the tool points away from the elbow's line as the arm passes upright: the wrist stands on the axis of joint 1
    over = path_of([line((-0.2, 0.0, 0.7), (0.2, 0.0, 0.7))])
    with pytest.raises(SingularArmError, match=r"at t = 1 s, point \(0, 0, 0\.7\) m"):
        pose_path_reference(
            ARM, timed_pose_path(over, constant_orientation(np.eye(3)), quintic(over.length, 2.0)), own, limits=False
        )


@pytest.mark.parametrize("arm_angle", [None, 0.0])
def test_a_path_out_of_reach_is_refused_with_its_place(arm_angle):
    path = path_of([line((0.3, 0.3, 0.5), (0.3, 2.3, 0.5))])
    poses = timed_pose_path(path, constant_orientation(np.eye(3)), quintic(path.length, 2.0))
    message = r"at t = 2 s, point \(0\.3, 2\.3, 0\.5\) m: the wrist is 1\.\d+ m out of reach"
    with pytest.raises(PathLimitError, match=message):
        pose_path_reference(ARM, poses, arm_angle)
