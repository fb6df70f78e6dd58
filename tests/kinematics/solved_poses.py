"""Solvers of the tests' arms, and what a solution must be."""

from functools import cache

import numpy as np

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from tests.public_arms import public_arm
from tests.tolerances import POSE_SOLVED


@cache
def arm_named(name):
    """A robot of this package, or a public arm."""
    return lwr_dyn.load(name) if name in studied() else public_arm(name)


@cache
def solver_of(name, search):
    """The solver of an arm by one search."""
    return lwr_dyn.ik_solver(arm_named(name), search=search)


def assert_reached(arm, q, T):
    assert ((q >= arm.lower) & (q <= arm.upper)).all()
    reached = lwr_dyn.forward_kinematics(arm, q)
    assert np.linalg.norm(reached[..., :3, 3] - T[..., :3, 3], axis=-1).max() <= POSE_SOLVED
    turn = np.swapaxes(reached[..., :3, :3], -1, -2) @ T[..., :3, :3]
    sine = np.stack([turn[..., i, j] - turn[..., j, i] for i, j in ((2, 1), (0, 2), (1, 0))]) / 2.0
    assert np.linalg.norm(sine, axis=0).max() <= POSE_SOLVED
    assert (np.trace(turn, axis1=-2, axis2=-1) > 2.9).all()
