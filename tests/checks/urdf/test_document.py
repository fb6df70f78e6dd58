import numpy as np
import pytest
import yourdfpy

from lwr_dyn.checks.urdf.document import POSES, document_of, link_poses
from tests.checks.urdf.box_arm import BoxArm
from tests.tolerances import EXACT

ARM = BoxArm().text()
LOOP = ARM.replace('<parent link="l0"/>', '<parent link="l3"/>')


def fixed(text, *names):
    for name in names:
        text = text.replace(f'"{name}" type="revolute"', f'"{name}" type="fixed"')
    return text


def test_the_first_pose_is_at_zero_and_agrees_with_yourdfpy_the_others_within_the_limits(tmp_path):
    (tmp_path / "a.urdf").write_text(ARM)
    other = yourdfpy.URDF.load(str(tmp_path / "a.urdf"), load_meshes=False)
    poses = link_poses(document_of(ARM, "f"))
    assert poses["l3"].shape == (POSES, 4, 4)
    assert poses["l3"][0] == pytest.approx(other.get_transform("l3", "l0"), abs=EXACT)
    angles = np.arctan2(poses["l1"][:, 1, 0], poses["l1"][:, 0, 0])
    assert np.abs(angles).max() <= 2.0
    assert len(np.unique(angles.round(9))) == POSES
    other.update_cfg({"j1": angles[5], "j2": 0.0, "j3": 0.0})
    assert poses["l1"][5] == pytest.approx(other.get_transform("l1", "l0"), abs=EXACT)


@pytest.mark.parametrize(
    ("kind", "limits", "low", "up"),
    [("revolute", (-2, 2), -2.0, 2.0), ("revolute", (-9, 9), -np.pi, np.pi), ("revolute", (1, 1), -np.pi, np.pi),
     ("continuous", (-2, 2), -np.pi, np.pi), ("prismatic", (-9, 9), -9.0, 9.0), ("prismatic", (1, 1), 0.0, 0.0),
     ("prismatic", (1, 2), 0.0, 2.0), ("fixed", (-2, 2), 0.0, 0.0)],
)  # fmt: skip
def test_positions_are_drawn_from_all_of_the_range(kind, limits, low, up):
    """About or along an axis of any length; the first is at 0; an angle by its half-turn formula."""
    text = ARM.replace('"j1" type="revolute"', f'"j1" type="{kind}"').replace('<axis xyz="0 0 1"', '<axis xyz="0 0 3"')
    text = text.replace('lower="-2" upper="2"', 'lower="{}" upper="{}"'.format(*limits), 1)
    pose = link_poses(document_of(text, "f"))["l1"]
    turn = np.arctan2(pose[:, 1, 0], pose[:, 0, 0])
    q = pose[:, 2, 3] - 0.1 if kind == "prismatic" else turn
    assert (q[0], np.ptp(pose[:, 2, 3]) == 0.0) == (0.0, kind != "prismatic" or low == up)
    assert low - EXACT <= q.min() <= q.max() <= up + EXACT
    widest = min(up, np.pi) - max(low, -np.pi) if kind != "prismatic" else up - low
    assert np.ptp(q) >= 0.7 * widest


def test_loops_and_unreadable_origins_end():
    bad = ARM.replace('<origin xyz="0.0 0.0 0.45"/>', '<origin xyz="0 x 0"/>')
    assert [set(link_poses(document_of(text, "f"))) for text in (LOOP, bad)] == [{"l0"}, {"l0", "l1"}]


@pytest.mark.parametrize(
    ("text", "moved", "driven", "roots"),
    [(ARM, "123", "123", "0"), (LOOP, "123", "123", "0"), (fixed(LOOP, "j1", "j3"), "123", "2", "0"),
     (fixed(ARM, "j1"), "23", "23", "0"), (fixed(ARM, "j3"), "123", "12", "0")],
)  # fmt: skip
def test_what_hangs_on_a_moving_joint_moves_in_a_loop_too(text, moved, driven, roots):
    document = document_of(text, "f")
    assert (document.moved, document.driven, document.roots) == (
        {f"l{k}" for k in moved}, {f"l{k}" for k in driven}, tuple(f"l{k}" for k in roots)
    )  # fmt: skip
    mass = {k: box.mass for k, box in enumerate(BoxArm().boxes)}
    assert document_of(ARM, "f").mass_beyond("l1", through_moving=True) == pytest.approx(mass[2] + mass[3])
