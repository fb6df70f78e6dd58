"""Foreign arms from example-robot-data: both roads agree, and so do other readers of the same file."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy

import lwr_dyn
from lwr_dyn.checks.arm.model_laws import feasibility_verdicts
from lwr_dyn.foundation.errors import UrdfError
from lwr_dyn.model.chain import unphysical_links
from tests.agreement.test_engines_agree import close
from tests.tolerances import METRES

ROBOTS = Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots"
STATES = 100


@dataclass(frozen=True)
class Foreign:
    file: str
    tip: str
    lock: dict[str, float] = field(default_factory=dict)

    @property
    def path(self):
        return ROBOTS / self.file

    def load(self):
        return lwr_dyn.load(self.path, tip=self.tip, lock=self.lock)


FINGERS = {"panda_finger_joint1": 0.01, "panda_finger_joint2": 0.03}
ARMS = {
    "panda": Foreign("panda_description/urdf/panda.urdf", "panda_hand_tcp", FINGERS),
    "xarm7": Foreign("xarm_description/urdf/xarm7.urdf", "link_eef"),
    "ur5": Foreign("ur_description/urdf/ur5_robot.urdf", "tool0"),
    "so101": Foreign("so_arm_description/urdf/so101.urdf", "gripper_frame_link", {"gripper": 0.3}),
}


@pytest.fixture(params=ARMS)
def foreign(request):
    return ARMS[request.param]


def states(n):
    return np.random.default_rng(5).uniform(-2.5, 2.5, (2, STATES, n))


@pytest.mark.parametrize(("name", "n"), [("panda", 7), ("xarm7", 7), ("ur5", 6), ("so101", 5)])
def test_it_has_its_joints_and_can_exist(name, n):
    arm = ARMS[name].load()
    assert arm.n == n
    assert arm.chain.bodies is not None
    assert unphysical_links(arm.chain) == ()


def test_both_roads_agree(foreign):
    arm = foreign.load()
    a, b = lwr_dyn.dynamics_of(arm), lwr_dyn.dynamics_of(arm, engine="newton-euler")
    q, dq = states(arm.n)
    assert close(a.mass_matrix(q), b.mass_matrix(q))
    assert close(a.coriolis_matrix(q, dq), b.coriolis_matrix(q, dq))
    assert close(a.gravity_vector(q), b.gravity_vector(q))
    assert close(a.inverse_dynamics(q, dq, dq), b.inverse_dynamics(q, dq, dq))


def test_the_original_file_in_yourdfpy_has_the_same_flange(foreign):
    arm = foreign.load()
    urdf = yourdfpy.URDF.load(str(foreign.path), load_meshes=False)
    q, _ = states(arm.n)
    T = lwr_dyn.forward_kinematics(arm, q)
    for k in range(STATES):
        urdf.update_cfg({**dict(zip(arm.joint_names, q[k], strict=True)), **foreign.lock})
        assert np.abs(urdf.get_transform(foreign.tip, urdf.base_link) - T[k]).max() <= METRES


def test_the_original_file_in_pinocchio_has_the_same_dynamics(foreign):
    arm = foreign.load()
    whole = pin.buildModelFromUrdf(str(foreign.path))
    held = pin.neutral(whole)
    for name, value in foreign.lock.items():
        held[whole.joints[whole.getJointId(name)].idx_q] = value
    model = pin.buildReducedModel(whole, [whole.getJointId(name) for name in foreign.lock], held)
    assert tuple(model.names)[1:] == arm.joint_names
    assert np.array_equal(model.lowerPositionLimit, arm.lower)
    assert np.array_equal(model.upperPositionLimit, arm.upper)
    data, q, dq = model.createData(), *states(arm.n)
    road_b = lwr_dyn.dynamics_of(arm, engine="newton-euler")
    B, g, bias = road_b.mass_matrix(q), road_b.gravity_vector(q), road_b.bias_torque(q, dq)
    for k in range(STATES):
        assert close(pin.crba(model, data, q[k]), B[k])
        assert close(pin.computeGeneralizedGravity(model, data, q[k]), g[k])
        assert close(pin.nonLinearEffects(model, data, q[k], dq[k]), bias[k])


def test_locked_fingers_count_and_one_outside_its_limits_is_named():
    panda = ARMS["panda"]
    inertials = yourdfpy.URDF.load(str(panda.path), load_meshes=False, build_scene_graph=False).link_map
    parts = [f"panda_{x}" for x in ("link7", "link8", "hand", "hand_tcp", "leftfinger", "rightfinger")]
    whole = sum(inertials[x].inertial.mass for x in parts if inertials[x].inertial)
    assert panda.load().chain.links[-1].body.mass == pytest.approx(whole, rel=1e-14)
    with pytest.raises(UrdfError, match=r"from 0\.0 to 0\.04"):
        lwr_dyn.load(panda.path, lock={"panda_finger_joint1": 0.5})


@pytest.mark.parametrize(
    ("name", "n", "tip", "held"),
    [("panda", 7, "panda_hand_tcp", "panda_finger_joint1 at 0, panda_finger_joint2 at 0"), ("ur5", 6, "tool0", "")],
)
def test_the_obvious_arm_is_taken_and_said(name, n, tip, held):
    arm = lwr_dyn.load(ARMS[name].path)
    assert (arm.n, arm.layout.tip) == (n, tip)
    assert arm.notes[0].startswith(f"the arm ends at {tip}; another end: --tip LINK")
    assert arm.notes[1:] == ((f"held: {held}; other values: --lock JOINT=VALUE",) if held else ())


ICUB = "icub_description/robots/icub.urdf"
UNPHYSICAL = {
    "icub head": (
        Foreign(ICUB, "imu_frame"), {"neck_1", "neck_2", "head", "torso", "l_wrist_1", "r_wrist_1"}
    ),
    "icub leg": (
        Foreign(ICUB, "r_foot_dh_frame"),
        {"r_hip_1", "r_hip_2", "r_upper_leg", "r_lower_leg", "r_ankle_1", "r_ankle_2"},
    ),
    "romeo arm": (
        Foreign("romeo_description/urdf/romeo_small.urdf", "r_gripper"), {"RShoulderYawLink", "RElbowYawLink"}
    ),
}  # fmt: skip


def halfway(foreign):
    """The locks that the reader asks for, each halfway between its limits."""
    try:
        foreign.load()
    except UrdfError as fault:
        names = [word.removesuffix("=VALUE") for word in fault.allowed.split() if word.endswith("=VALUE")]
        limits = yourdfpy.URDF.load(str(foreign.path), load_meshes=False, build_scene_graph=False).joint_map
        return {name: (limits[name].limit.lower + limits[name].limit.upper) / 2 for name in names}
    return {}


@pytest.mark.parametrize("name", UNPHYSICAL)
def test_a_published_arm_that_cannot_exist_is_read_and_marked(name):
    foreign, expected = UNPHYSICAL[name]
    arm = lwr_dyn.load(foreign.path, tip=foreign.tip, lock=halfway(foreign))
    failing = {v.name.split(":")[0] for v in feasibility_verdicts(arm) if not v.holds and "gyration" not in v.name}
    assert failing == expected
