"""The same arm written in standard and in modified DH gives the same numbers."""

import numpy as np
import pytest

from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.dynamics.pinocchio_engine import pinocchio_dynamics
from lwr_dyn.model import chain as model
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.spatial import Pose, rot_x
from tests.random_arms import random_body
from tests.tolerances import EXACT

LETTERS = {"R": model.JointKind.REVOLUTE, "P": model.JointKind.PRISMATIC}


def two_chains(seed, kinds):
    """A random DH table in both conventions: alpha and a of row i move to row i + 1, the last to the flange."""
    rng = np.random.default_rng(seed)
    n = len(kinds)
    table = [model.DHRow(*rng.uniform(-1, 1, 4), int(rng.choice([-1, 1]))) for _ in range(n)]
    bodies = [random_body(rng) for _ in range(n)]
    rotors = [model.Rotor(100.0, 1e-5)] * n
    tails = [Pose(rot_x(r.alpha), np.array([r.a, 0.0, 0.0])) for r in table]
    # `seen_from` needs frame i(standard) in frame i(modified): the tail, turned by the sign's half turn
    standard, modified = [], []
    for i, row in enumerate(table):
        lead = table[i - 1] if i else model.DHRow(0.0, 0.0, 0.0)
        moved = model.DHRow(lead.alpha, lead.a, row.d, row.theta_offset, row.sign)
        head = f"joint_{i + 1}", f"link_{i + 1}", LETTERS[kinds[i]]
        standard.append(model.ChainLink(*head, *row.fixed_poses(model.Convention.STANDARD), bodies[i], rotors[i]))
        body = bodies[i].seen_from(tails[i])
        modified.append(model.ChainLink(*head, *moved.fixed_poses(model.Convention.MODIFIED), body, rotors[i]))
    gravity = np.array([1.0, -2.0, -9.0])
    return model.Chain(tuple(standard), Pose.identity(), gravity), model.Chain(tuple(modified), tails[-1], gravity)


@pytest.mark.parametrize("rotors", ["armature", "full", "none"])
@pytest.mark.parametrize(("seed", "kinds"), [(0, "RRRRRRR"), (1, "RPR"), (2, "PRRP"), (3, "RRRRRR")])
def test_both_conventions_give_the_same_torque(seed, kinds, rotors):
    standard, modified = two_chains(seed, kinds)
    q, dq, ddq = np.random.default_rng(seed).uniform(-2, 2, (3, 20, len(kinds)))
    a = newton_euler_dynamics(standard, rotors).inverse_dynamics(q, dq, ddq)
    b = newton_euler_dynamics(modified, rotors).inverse_dynamics(q, dq, ddq)
    assert np.abs(a - b).max() <= EXACT * np.abs(a).max()
    flange_a, flange_b = list(model.link_frames(standard, q))[-1], list(model.link_frames(modified, q))[-1]
    assert np.abs(flange_a - flange_b).max() <= 1e-12


@pytest.mark.parametrize("index", [0, 2, 3])
def test_a_locked_joint_moves_like_one_that_is_held(index):
    chain, _ = two_chains(5, "RRPR")
    value = 0.4
    rng = np.random.default_rng(1)
    q, dq, ddq = rng.uniform(-1, 1, (3, 10, 4))
    q[:, index], dq[:, index], ddq[:, index] = value, 0.0, 0.0
    free = np.delete(np.arange(4), index)
    held = newton_euler_dynamics(chain).inverse_dynamics(q, dq, ddq)[:, free]
    locked_chain = model.lock_joint(chain, index, value)
    locked = newton_euler_dynamics(locked_chain).inverse_dynamics(q[:, free], dq[:, free], ddq[:, free])
    assert np.abs(held - locked).max() <= EXACT * np.abs(held).max()
    poses = list(model.link_frames(chain, q))[-1] - list(model.link_frames(locked_chain, q[:, free]))[-1]
    assert np.abs(poses).max() <= 1e-12


def test_a_payload_is_seen_by_both_roads_and_weighs_what_it_weighs():
    chain, _ = two_chains(6, "RRR")
    loaded = model.with_payload(chain, 3.0, com=(0.1, 0.0, 0.2))
    arm = Arm("loaded", "", "", loaded, (JointLimits(),) * 3)
    q = np.random.default_rng(2).uniform(-1, 1, 3)
    roads = pinocchio_dynamics(arm), newton_euler_dynamics(loaded)
    torques = [road.gravity_vector(q) for road in roads]
    assert np.abs(torques[0] - torques[1]).max() <= EXACT * np.abs(torques[0]).max()
    step = 1e-6
    more = torques[1] - newton_euler_dynamics(chain).gravity_vector(q)
    point = [
        (list(model.link_frames(chain, q + s * step * np.eye(3)))[-1] @ np.array([0.1, 0, 0.2, 1]))[:, :3]
        for s in (1, -1)
    ]
    virtual_work = -3.0 * (point[0] - point[1]) @ chain.gravity / (2 * step)
    assert np.abs(more - virtual_work).max() < 1e-7  # a central difference of 1e-6 is good to 1e-9 of 10 N m
