"""Pinocchio's flange pose and Jacobian are those of the native chain, call after call."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian
from lwr_dyn.kinematics.forward import jacobian
from tests.random_arms import random_arm
from tests.tolerances import METRES

INSTALLED = lwr_dyn.load(
    "lwr4plus", mount="wall", tool={"xyz": [0.05, 0.02, 0.15], "rpy": [0.1, 0.4, 0.2], "mass": 0.5}
)


@pytest.mark.parametrize(
    "arm",
    [lwr_dyn.load("lwr4plus"), INSTALLED, random_arm(3, "RPRR"), random_arm(4, "R")],
    ids=["lwr4plus", "with mount and tool", "RPRR", "R"],
)
def test_flange_and_jacobian_are_those_of_the_chain(arm):
    pose_and_jacobian = flange_and_jacobian(arm)
    for q in np.random.default_rng(0).uniform(-1, 1, (5, arm.n)):
        pose, J = pose_and_jacobian(q)
        assert np.abs(pose - lwr_dyn.forward_kinematics(arm, q)).max() < METRES
        assert np.abs(J - jacobian(arm.chain, q)).max() < METRES
