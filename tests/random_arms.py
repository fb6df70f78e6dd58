"""Random arms, for properties that must hold for every arm."""

import numpy as np
from hypothesis import strategies as st

from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind, Rotor
from lwr_dyn.model.spatial import Pose, from_rpy


def random_body(rng):
    """A body that can exist: a cloud of ten mass points."""
    points, masses = rng.uniform(-0.2, 0.2, (10, 3)), rng.uniform(0.05, 0.5, 10)
    com = masses @ points / masses.sum()
    r = points - com
    tensor = np.einsum("k,kij->ij", masses, (r**2).sum(1)[:, None, None] * np.eye(3) - np.einsum("ki,kj->kij", r, r))
    return Body(float(masses.sum()), com, (tensor + tensor.T) / 2)


def random_pose(rng):
    """One pose in three is the identity, one a right angle, one anything."""
    kind = rng.integers(3)
    if kind == 0:
        return Pose.identity()
    rpy = rng.integers(-2, 3, 3) * np.pi / 2 if kind == 1 else rng.uniform(-3, 3, 3)
    return Pose(from_rpy(rpy), rng.uniform(-0.4, 0.4, 3))


def random_arm(seed, joints=None):
    """A chain of 1 to 7 joints of both kinds, some with rotors, gravity anywhere."""
    rng = np.random.default_rng(seed)
    kinds = joints or "".join(rng.choice(["R", "R", "P"], rng.integers(1, 8)))
    links = []
    for i, letter in enumerate(kinds):
        kind = JointKind.REVOLUTE if letter == "R" else JointKind.PRISMATIC
        rotor = Rotor(float(rng.uniform(20, 120)), float(rng.uniform(0, 1e-5))) if rng.random() < 0.7 else None
        pose = random_pose(rng), random_pose(rng)
        links.append(ChainLink(f"joint_{i + 1}", f"link_{i + 1}", kind, *pose, random_body(rng), rotor))
    chain = Chain(tuple(links), random_pose(rng), rng.uniform(-10, 10, 3))
    return Arm("random", "none", "random arm", chain, (JointLimits(),) * len(kinds))


arms = st.integers(0, 10**6).map(random_arm)
