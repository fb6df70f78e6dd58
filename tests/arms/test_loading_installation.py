"""A mount and a tool: laws of the dynamics, both roads, the frames, the picture."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.geometry import floor_height, stand_foot
from lwr_dyn.dynamics.pinocchio_engine import flange_poses, pinocchio_model
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.chain import Tool, ends_of, link_frames
from lwr_dyn.pages.replay.replay_page import arm_commands
from tests.random_arms import random_arm, random_body, random_pose
from tests.tolerances import EXACT, METRES

TOOL = {"xyz": [0.02, 0, 0.15], "rpy": [0.1, 0.7, -0.3], "mass": 1.3, "com": [0.01, 0, 0.06]}
TOOL["inertia"] = [3e-3, 4e-3, 2e-3]
MOUNT = {"on": "wall", "xyz": [0.3, -0.2, 1.4], "rpy_deg": [0, 10, 35]}
STATES = np.random.default_rng(4).uniform(-1.0, 1.0, (3, 20, 7))


def mounted(**options):
    return lwr_dyn.load("lwr4plus", **options)


def relative(a, b):
    """The largest difference, relative to the largest entry."""
    return np.abs(a - b).max() / np.abs(b).max()


def random_installation(seed):
    """A random arm, its mount and its tool."""
    rng = np.random.default_rng(seed)
    body = random_body(rng)
    tool = Tool(random_pose(rng), body.mass, body.com, body.inertia_com)
    return random_arm(seed), random_pose(rng), tool


@pytest.mark.parametrize("seed", range(12))
def test_both_roads_agree_under_any_mount_with_any_tool(seed):
    """The pose is the mount times the pose of the bare arm times the tool."""
    bare, mount, tool = random_installation(seed)
    arm = bare.installed(mount, tool)
    q, dq, ddq = STATES[..., : arm.n]
    one, other = (lwr_dyn.dynamics_of(arm, engine) for engine in ("pinocchio", "newton-euler"))
    assert relative(one.mass_matrix(q), other.mass_matrix(q)) <= EXACT
    assert relative(one.inverse_dynamics(q, dq, ddq), other.inverse_dynamics(q, dq, ddq)) <= EXACT
    expected = mount.matrix() @ lwr_dyn.forward_kinematics(bare, q) @ tool.frame.matrix()
    for poses in (lwr_dyn.forward_kinematics(arm, q), flange_poses(pinocchio_model(arm), q)):
        assert np.abs(poses - expected).max() <= EXACT


def test_gravity_is_the_gradient_of_the_height_of_the_masses_in_the_world():
    """Complex steps of the energy of the bodies where forward kinematics puts them, not of an engine's energy."""
    arm = mounted(mount=MOUNT, tool=TOOL)
    q, step = STATES[0, 0], 1e-30
    g = lwr_dyn.dynamics_of(arm).gravity_vector(q)

    def energy(at):
        pairs = zip(arm.chain.bodies, list(link_frames(arm.chain, at))[:-1], strict=True)
        return sum(9.81 * body.mass * (T[:3, :3] @ body.com + T[:3, 3])[2] for body, T in pairs)

    gradient = [energy(q + 1j * step * e).imag / step for e in np.eye(7)]
    assert relative(np.array(gradient), g) <= EXACT


def test_gravity_turns_with_the_mount_is_down_in_the_world_and_keeps_its_size():
    """Each named mount, put so that gravity in the base is a given vector, against the arm under that gravity."""
    bare = mounted()
    for place, down in {"floor": (0, 0, -1), "wall": (1, 0, 0), "ceiling": (0, 0, 1)}.items():
        arm = mounted(mount=place)
        assert arm.chain.gravity.tolist() == [0.0, 0.0, -9.81]
        turned = replace(bare, chain=replace(bare.chain, gravity=9.81 * np.array(down)))
        engines = [lwr_dyn.dynamics_of(x) for x in (arm, turned)]
        for function in ("gravity_vector", "mass_matrix"):
            assert relative(*(getattr(engine, function)(STATES[0]) for engine in engines)) <= EXACT
    random, mount, tool = random_installation(3)
    assert random.installed(None, tool).chain.gravity.tolist() == random.chain.gravity.tolist()
    size = np.linalg.norm(random.chain.gravity)
    assert random.installed(mount, tool).chain.gravity == pytest.approx([0.0, 0.0, -size], rel=EXACT)


def test_the_picture_stands_on_the_mount_and_carries_the_tool():
    """Each drawn cylinder as it stands at q = 0 in the world, against that of the bare arm moved by the mount."""
    bare, arm = mounted(), mounted(mount=MOUNT, tool=TOOL)
    base, _ = ends_of(arm.installation)
    before, after = drawn(bare), drawn(arm)
    assert len(after) == len(before) + 1
    for one, other in zip(before, after[:-1], strict=True):
        assert np.abs(base.matrix() @ one - other).max() <= EXACT
    flange, tip = (lwr_dyn.forward_kinematics(x, np.zeros(7))[:3, 3] for x in (mounted(mount=MOUNT), arm))
    assert np.abs(after[-1][:3, 3] - (flange + tip) / 2).max() <= 2e-6  # drawn lengths are whole micrometres


def drawn(arm):
    """The poses in the first frame of all shapes that the viewer draws at q = 0."""
    poses, shapes = {"/arms/run_0": np.eye(4), "/arms/run_0/link_0": np.eye(4)}, []
    run = SimpleNamespace(q=np.zeros((1, arm.n)))
    commands = list(arm_commands(SimpleNamespace(arm=arm, run=run, place=0), 0))
    for command in (x for x in commands if x["type"] == "set_transform"):
        parent = poses[command["path"].rpartition("/")[0]]
        poses[command["path"]] = parent @ np.array(command["matrix"]).reshape(4, 4).T
    for command in (x for x in commands if x["type"] == "set_object"):
        placed = np.array(command["object"]["object"]["matrix"]).reshape(4, 4).T
        shapes.append(poses[command["path"].rpartition("/")[0]] @ placed)
    return shapes


def test_the_floor_is_under_the_arm_and_the_stand_ends_at_ceiling_or_wall():
    bare, up = floor_height(mounted()), stand_foot(mounted())
    assert floor_height(mounted(mount="floor")) == bare
    assert floor_height(mounted(mount={"xyz": [0, 0, 0.5]})) == pytest.approx(bare + 0.5)
    assert floor_height(mounted(mount={"on": "ceiling", "xyz": [0, 0, 2.5]})) == 0.0
    assert floor_height(mounted(mount="ceiling", tool={"xyz": [0, 0, 0.1]})) == pytest.approx(-0.968)
    assert up == pytest.approx([0, 0, bare])
    assert stand_foot(mounted(mount={"on": "ceiling", "xyz": [1, 0, 2]})) == pytest.approx([1, 0, 2 - up[2]])
    wall = mounted(mount="wall")
    assert stand_foot(wall) @ wall.installation.mount.rotation[:, 2] == pytest.approx(up[2])
    assert abs(stand_foot(wall)[2]) < 1e-12


def test_the_mass_of_a_tool_is_that_of_a_payload_at_the_same_place_and_a_payload_beside_a_tool_is_at_its_point():
    arm = mounted(tool={"mass": 1.3, "com": [0.01, 0, 0.06], "inertia": [3e-3, 4e-3, 2e-3]})
    loaded = arm_with_payload(mounted(), 1.3, (0.01, 0, 0.06), np.diag([3e-3, 4e-3, 2e-3]))
    for one, other in zip(arm.chain.bodies, loaded.chain.bodies, strict=True):
        assert (one.mass, *one.com, *one.inertia_com.ravel()) == (other.mass, *other.com, *other.inertia_com.ravel())
    beside = arm_with_payload(mounted(tool={key: TOOL[key] for key in ("xyz", "rpy")}), 2.0)
    pair = [
        lwr_dyn.dynamics_of(x).mass_matrix(STATES[0]) for x in (beside, arm_with_payload(mounted(), 2.0, TOOL["xyz"]))
    ]
    assert relative(*pair) <= EXACT


def test_a_mounted_arm_loses_no_energy_in_a_free_swing():
    arm = mounted(mount="ceiling", tool=TOOL)
    hold = lwr_dyn.reference("hold", arm, q=STATES[0, 1], duration=0.05)
    run = lwr_dyn.simulate(arm, lambda *_: np.zeros(7), hold, friction="none", position_limits=False)
    assert abs(run.energy - run.energy[0]).max() <= 1e-9 * abs(run.energy).max()
    assert (run.dq[-1] != 0.0).all()


@pytest.mark.parametrize(("robot", "solver"), [("lwr4plus", "srs"), ("kr30ha", "spherical-wrist")])
def test_closed_forms_recognise_the_arm(robot, solver):
    bare, arm = lwr_dyn.load(robot), lwr_dyn.load(robot, mount=MOUNT, tool=TOOL)
    q = (bare.lower + 0.4 * (bare.upper - bare.lower)) * np.linspace(0.5, 1, bare.n)
    results = [lwr_dyn.inverse_kinematics(x, lwr_dyn.forward_kinematics(x, q), solver=solver) for x in (bare, arm)]
    assert all(result.complete for result in results)
    assert len(results[0].solutions) == len(results[1].solutions) > 0
    reached = [lwr_dyn.forward_kinematics(arm, x.q) for x in results[1].solutions]
    assert np.abs(reached - lwr_dyn.forward_kinematics(arm, q)).max() <= 10 * METRES  # up to 3 m from the origin


@pytest.mark.slow
def test_generated_kernels_include_mount_and_tool():
    locks = {f"joint_{i}": 0.1 for i in range(3, 8)}
    arm = lwr_dyn.load("lwr4plus", lock=locks, mount="ceiling", tool={"xyz": [0, 0, 0.1], "mass": 1.0})
    batch, q = lwr_dyn.batch_dynamics(arm), STATES[0, :, :2].copy()
    assert relative(batch.flange_pose(q), lwr_dyn.forward_kinematics(arm, q)) <= EXACT
    assert relative(batch.gravity_vector(q), lwr_dyn.dynamics_of(arm).gravity_vector(q)) <= EXACT


def test_a_lock_after_the_installation_gives_what_a_lock_before_it_gives():
    locks = {"joint_1": 0.3, "joint_7": -0.4, "joint_4": 0.5}
    after = mounted(mount=MOUNT, tool=TOOL)
    for name, value in locks.items():
        after = after.with_locked_joint(name, value)
    before = mounted(mount=MOUNT, tool=TOOL, lock=locks)
    q = STATES[0, :, :4]
    assert relative(lwr_dyn.forward_kinematics(after, q), lwr_dyn.forward_kinematics(before, q)) <= EXACT
    assert relative(*(lwr_dyn.dynamics_of(x).mass_matrix(q) for x in (after, before))) <= EXACT
    assert np.array_equal(ends_of(after.installation)[0].matrix(), ends_of(before.installation)[0].matrix())
