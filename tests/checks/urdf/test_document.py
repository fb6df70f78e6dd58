import numpy as np
import pytest

from lwr_dyn.checks.urdf.document import POSES, document_of, link_poses
from tests.checks.urdf.box_arm import BoxArm
from tests.tolerances import EXACT


def test_the_first_pose_is_at_zero_and_agrees_with_yourdfpy(tmp_path):
    import yourdfpy

    (tmp_path / "a.urdf").write_text(BoxArm().text())
    other = yourdfpy.URDF.load(str(tmp_path / "a.urdf"), load_meshes=False)
    poses = link_poses(BoxArm().document())
    assert poses["l3"].shape == (POSES, 4, 4)
    assert poses["l3"][0] == pytest.approx(other.get_transform("l3", "l0"), abs=EXACT)


def test_joints_move_within_their_limits():
    poses = link_poses(BoxArm().document())
    turned = poses["l1"][:, :3, :3]
    angles = np.arctan2(turned[:, 1, 0], turned[:, 0, 0])
    assert np.abs(angles).max() <= 2.0
    assert len(np.unique(angles.round(9))) == POSES


def test_a_sliding_joint():
    text = BoxArm().text().replace('"j1" type="revolute"', '"j1" type="prismatic"')
    poses = link_poses(document_of(text, "f"))
    assert np.ptp(poses["l1"][:, 2, 3]) > 1.0
    assert np.ptp(poses["l1"][:, 0, 0]) == 0.0


def test_loops_and_unreadable_origins_end():
    loop = BoxArm().text().replace('<parent link="l0"/>', '<parent link="l3"/>')
    assert set(link_poses(document_of(loop, "f"))) == {"l0"}
    bad = BoxArm().text().replace('<origin xyz="0.0 0.0 0.45"/>', '<origin xyz="0 x 0"/>')
    assert set(link_poses(document_of(bad, "f"))) == {"l0", "l1"}


def test_what_hangs_on_a_moving_joint_moves_in_a_loop_too():
    assert BoxArm().document().moved == {"l1", "l2", "l3"}
    loop = BoxArm().text().replace('<parent link="l0"/>', '<parent link="l3"/>')
    assert document_of(loop, "f").moved == {"l1", "l2", "l3"}
    held = loop.replace('"j1" type="revolute"', '"j1" type="fixed"').replace(
        '"j3" type="revolute"', '"j3" type="fixed"'
    )
    assert document_of(held, "f").moved == {"l1", "l2", "l3"}
    rest = BoxArm().text().replace('"j1" type="revolute"', '"j1" type="fixed"')
    assert document_of(rest, "f").moved == {"l2", "l3"}
