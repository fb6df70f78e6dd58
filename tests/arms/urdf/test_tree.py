"""The link tree: paths, ends, locked joints with their mimics, and files that are no tree."""

import numpy as np
import pytest

from lwr_dyn.arms.urdf.parse import parse_urdf
from lwr_dyn.arms.urdf.tree import build_tree, origin_pose, position_limits
from lwr_dyn.foundation.errors import UnknownNameError, UrdfError
from lwr_dyn.model.spatial import rot_y, rot_z


def joint(name, parent, child, kind="revolute", more=""):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 0.5"/>'
        f'<axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="9" velocity="1"/>{more}</joint>'
    )


HAND = (
    joint("shoulder", "base", "arm"),
    joint("left", "arm", "thumb"),
    joint("right", "arm", "finger", more='<mimic joint="left" multiplier="-2" offset="0.25"/>'),
    joint("plate", "arm", "tool", "fixed"),
)


@pytest.fixture
def tree(tmp_path):
    def build(joints=HAND, links="base arm thumb finger tool", **lock):
        path = tmp_path / "arm.urdf"
        named = "".join(f'<link name="{link}"/>' for link in links.split())
        path.write_text(f'<robot name="r">{named}{"".join(joints)}</robot>', encoding="utf-8")
        return build_tree(parse_urdf(path), lock)

    return build


def test_paths_go_from_the_root_and_unknown_links_are_named(tree):
    hand = tree()
    assert hand.root == "base"
    assert [joint.name for joint in hand.path_to("finger")] == ["shoulder", "right"]
    assert hand.path_to("base") == []
    with pytest.raises(UnknownNameError, match=r"no link of arm\.urdf named 'thum' \(did you mean thumb\?\)"):
        hand.path_to("thum")


def test_a_locked_joint_is_a_fixed_pose_and_its_mimics_follow(tree):
    hand = tree(left=0.5)
    assert hand.locked == {"left": 0.5, "right": -2 * 0.5 + 0.25}
    pose = hand.fixed_pose(hand.urdf.joints["left"])
    np.testing.assert_allclose(pose.rotation, rot_z(0.5), atol=1e-15)
    assert pose.position.tolist() == [0.0, 0.0, 0.5]
    assert [name for name, _ in hand.fixed_to("arm")] == ["arm", "thumb", "finger", "tool"]
    assert [name for name, _ in tree().fixed_to("arm")] == ["arm", "tool"]


@pytest.mark.parametrize("value", [2.1, -2.1, float("nan"), float("inf")])
def test_a_lock_outside_the_limits_is_refused(tree, value):
    with pytest.raises(UrdfError, match=r"lock of joint 'left': .*; allowed: a number from -2\.0 to 2\.0"):
        tree(left=value)
    with pytest.raises(UnknownNameError, match="known: shoulder, left, right"):
        tree(plate=0.0)


def test_limits_that_are_missing_or_infinite_are_unknown_and_right_angles_are_exact(tree):
    joints = tree((joint("j", "a", "b"), joint("k", "b", "c", "continuous")), "a b c").urdf.joints
    assert position_limits(joints["j"]) == (-2.0, 2.0)
    assert position_limits(joints["k"]) == (None, None)
    turned = np.eye(4)
    turned[:3, :3] = rot_z(np.pi / 2)
    assert set(origin_pose(turned).rotation.ravel().tolist()) == {0.0, 1.0, -1.0}
    assert origin_pose(None).is_identity()


def test_mimics_follow_through_each_other_and_a_lock_turns_about_its_own_axis(tree):
    chained = (*HAND, joint("third", "arm", "nail", more='<mimic joint="right" multiplier="3" offset="0.1"/>'))
    hand = tree(chained, "base arm thumb finger tool nail", left=0.5)
    assert hand.locked == {"left": 0.5, "right": -0.75, "third": pytest.approx(-2.15)}
    np.testing.assert_allclose(dict(hand.fixed_to("arm"))["finger"].rotation, rot_z(-0.75), atol=1e-15)
    for kind, axis, value, rotation, position in (
        ("revolute", "0 1 0", 0.4, rot_y(0.4), [0, 0, 0.5]),
        ("prismatic", "1 0 0", -2.0, np.eye(3), [-2.0, 0, 0.5]),
        ("revolute", "0 0 1", 2.0, rot_z(2.0), [0, 0, 0.5]),
        ("revolute", "0 0 1", 0.0, np.eye(3), [0, 0, 0.5]),
    ):
        turned = joint("left", "arm", "thumb", kind).replace('axis xyz="0 0 1"', f'axis xyz="{axis}"')
        held = tree((HAND[0], turned, *HAND[2:]), left=value)
        pose = held.fixed_pose(held.urdf.joints["left"])
        np.testing.assert_allclose(pose.rotation, rotation, atol=1e-15)
        np.testing.assert_allclose(pose.position, position, atol=1e-15)
