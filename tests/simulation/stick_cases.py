"""Arms and controllers of the tests of stick and stops."""

import numpy as np

from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind
from lwr_dyn.model.spatial import Pose


def constant(*torque):
    return lambda t, q, dq, q_ref, dq_ref, ddq_ref: np.array(torque)


def kinds(run, joint=None):
    return [event.kind for event in run.events if joint is None or event.joint == joint]


def plane_arm(lengths=(0.5, 0.4), masses=(2.0, 1.5)):
    """Two turning joints about z in a level plane: no gravity, coupled inertia and Coriolis torques."""
    links = []
    for i, (length, mass) in enumerate(zip(lengths, masses, strict=True)):
        body = Body(mass, np.array([-length / 2, 0.0, 0.0]), mass * length**2 / 12 * np.diag([0.01, 1.0, 1.0]))
        after = Pose(np.eye(3), np.array([length, 0.0, 0.0]))
        links.append(ChainLink(f"joint_{i + 1}", f"link_{i + 1}", JointKind.REVOLUTE, Pose.identity(), after, body))
    chain = Chain(tuple(links), Pose.identity(), np.zeros(3))
    return Arm("plane", "none", "two joints in a plane", chain, (JointLimits(),) * 2)
