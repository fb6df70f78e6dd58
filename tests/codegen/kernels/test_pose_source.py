"""The step of inverse kinematics: the formula, and its text as plain Python."""

import math

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.pose_source import pose_step, step_source
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.kinematics.pose_solver import search_ranges

ARM = lwr_dyn.load("kr30ha")
RANGES = search_ranges(ARM, True, 1, 0)


def off(joint, beyond, error):
    """q with a joint beyond its limits and the others inside, and the pose that is this much away from it."""
    q = RANGES.middle + 0.2
    q[joint] = (RANGES.upper if beyond > 0.0 else RANGES.lower)[joint] + beyond
    T = lwr_dyn.forward_kinematics(ARM, q)
    T[:3, 3] += error
    return q, T


@pytest.mark.parametrize("repair", [0.0, 1.0, 2.0])
@pytest.mark.parametrize(("joint", "beyond", "error"), [(1, 0.1, [0.01, -0.02, 0.005]), (2, -0.05, [2.0, 3.0, -1.0])])
def test_the_step_is_that_of_the_formula(repair, joint, beyond, error):
    q, T = off(joint, beyond, error)
    error, here = np.array([*error, 0.0, 0.0, 0.0]), np.arange(6) == joint
    out = np.array(pose_step(ARM.chain, RANGES)(q, T[:3].ravel(), repair)).ravel()
    inside = RANGES.upper - RANGES.room if beyond > 0.0 else RANGES.lower + RANGES.room
    pull = np.where(here, inside - q, 0.0) * (repair == 1.0)
    J = jacobian(ARM.chain, q) * np.where(here & (repair == 2.0), 0.0, 1.0)
    damping = 0.1 * (error @ error) / 2 + 1e-12
    step = pull + J.T @ np.linalg.solve(J @ J.T + damping * np.eye(6), error - J @ pull)
    step /= max(1.0, np.linalg.norm(step))
    assert np.abs(out[:6] - q - step).max() < (1e-6 if repair == 2.0 else 1e-12)  # held: J J^T has lost rank
    assert np.abs(out[6:] - [error @ error, 0.0, 1.0, repair]).max() < 1e-12


@pytest.mark.parametrize("angle", [0.1, -1.0, 3.0])
def test_the_rotation_error_is_the_axis_times_twice_the_sine_of_half_the_angle(angle):
    q = RANGES.middle + 0.2
    T, u = lwr_dyn.forward_kinematics(ARM, q), np.array([2.0, -1.0, 2.0]) / 3.0
    cross = np.cross(np.eye(3), u)
    T[:3, :3] = (np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross) @ T[:3, :3]
    out = np.array(pose_step(ARM.chain, RANGES)(q, T[:3].ravel(), 0.0)).ravel()
    error, J = np.array([0.0, 0.0, 0.0, *(2.0 * np.sin(angle / 2.0) * u)]), jacobian(ARM.chain, q)
    step = J.T @ np.linalg.solve(J @ J.T + (0.05 * error @ error + 1e-12) * np.eye(6), error)
    assert np.abs(out[:6] - q - step / max(1.0, np.linalg.norm(step))).max() < 1e-9
    assert np.abs(out[6:] - [0.0, np.sin(angle) ** 2, np.cos(angle), 0.0]).max() < 1e-12


def test_the_text_is_python_that_makes_the_step():
    """Rows of the buffer: q, T, repair, a flag, the next q, the measures."""
    text, lanes = step_source(ARM.chain, RANGES, 2), 2
    names = {"sqrt": math.sqrt, "abs": abs, "fma": lambda x, y, z: x * y + z}
    exec(text, names)
    given = [off(1, 0.1, [0.01, 0.0, 0.0]), off(3, -0.2, [0.0, 0.3, 0.0])]
    b = np.zeros(30 * lanes)
    b[: 19 * lanes] = np.transpose([[*q, *T[:3].ravel(), 1.0] for q, T in given]).ravel()
    names["body"](b)
    for lane, (q, T) in enumerate(given):
        expected = np.array(pose_step(ARM.chain, RANGES)(q, T[:3].ravel(), 1.0)).ravel()
        assert np.abs(b.reshape(30, lanes)[20:, lane] - expected).max() < 1e-10
