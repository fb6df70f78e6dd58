"""Inertial parameters in other frames: as Pinocchio turns them, and as a URDF's own frames have a load."""

import numpy as np
import pinocchio as pin
import pytest

import lwr_dyn
from lwr_dyn.control.laws.adaptive import AdaptedParameters, SlotineLiRegressor
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.inertial_parameters import PINOCCHIO, inertial_parameters, parameter_turns, pseudo_inertias
from tests.tolerances import EXACT

TWO = """<robot name="two">
  <link name="base"/>
  <joint name="j1" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/>{limit}</joint>
  <link name="one">{body}</link>
  <joint name="j2" type="revolute"><parent link="one"/><child link="wrist"/><origin xyz="0.1 0.2 0.3" rpy="0.2 0 0"/>
    <axis xyz="0 1 0"/>{limit}</joint>
  <link name="wrist">{body}</link>
  <joint name="end" type="fixed"><parent link="wrist"/><child link="tool"/>
    <origin xyz="0 0.08 0" rpy="-1.2 0.4 0.3"/></joint>
  <link name="tool"/>
</robot>"""
LIMIT = '<limit lower="-1" upper="1" effort="10" velocity="1"/>'
BODY = """<inertial><origin xyz="0.1 0 0"/><mass value="1"/>
  <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>"""


def test_a_turn_is_that_of_pinocchio_and_of_an_arm_from_tables_none():
    pin.seed(3)
    for _ in range(20):
        body, pose = pin.Inertia.Random(), pin.SE3.Random()
        expected = pose.act(body).toDynamicParameters()
        P = pseudo_inertias(body.toDynamicParameters()[[*PINOCCHIO]])
        found = inertial_parameters(pose.homogeneous @ P @ pose.homogeneous.T)[[*PINOCCHIO]]
        assert np.abs(found - expected).max() < EXACT * np.abs(expected).max()
    assert np.array_equal(parameter_turns(lwr_dyn.load("wam7")), np.tile(np.eye(10), (7, 1, 1)))


@pytest.mark.parametrize("which", ["payload", "base"])
def test_a_load_is_learnt_in_the_frame_of_the_urdfs_own_link(tmp_path, which):
    (tmp_path / "two.urdf").write_text(TWO.format(limit=LIMIT, body=BODY))
    arm = lwr_dyn.load(tmp_path / "two.urdf")
    mass, com, inertia = 0.7, np.array([0.03, -0.05, 0.11]), np.diag([0.01, 0.02, 0.025])
    loaded = arm_with_payload(arm, mass, com, inertia)
    regressor = SlotineLiRegressor(arm)
    added = SlotineLiRegressor(loaded).parameters - regressor.parameters  # in frames of the joints
    adapted = AdaptedParameters.of(which, arm, regressor, 1.0)
    turned = np.einsum("kij,kj->ki", parameter_turns(arm), added.reshape(2, 10))
    model = pin.buildModelFromUrdf(str(tmp_path / "two.urdf"))
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    wrist, tool = (data.oMf[model.getFrameId(name)] for name in ("wrist", "tool"))
    expected = (wrist.inverse() * tool).act(pin.Inertia(mass, com, inertia)).toDynamicParameters()
    assert np.abs(turned[-1] - expected).max() < EXACT
    assert len(adapted.turns) == {"payload": 1, "base": 2}[which]
    theta = added[-10:] if which == "payload" else np.linalg.pinv(adapted.W) @ added
    of_joints = (theta if which == "payload" else adapted.W @ theta).reshape(-1, 10)
    shown = adapted.link_parameters(np.stack([theta, 2.0 * theta])).reshape(2, -1, 10)
    for one, joint, turn in zip(np.moveaxis(shown, 1, 0), of_joints, adapted.turns, strict=True):
        assert np.abs(one - np.outer([1, 2], turn @ joint)).max() < EXACT
