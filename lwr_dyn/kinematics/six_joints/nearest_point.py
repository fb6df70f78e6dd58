"""The point nearest to a pose out of reach that the arm reaches in the same orientation."""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import InverseResult
from lwr_dyn.model.arm import Arm

STEP = 1e-6
"""[m] Of the differences that give the gradient of the distance."""


def nearest_point(arm: Arm, pose: Array, result: InverseResult) -> Array | None:
    """The point (3,) [m], for `result` of a `pose` (4, 4) out of reach; None where the distance is not proven.

    The reach of the closed forms is a shell about the shoulder, so the gradient of the distance leads to its surface.
    """
    if not result.complete or result.distance is None:
        return None
    moved = np.tile(pose, (3, 1, 1))
    moved[:, :3, 3] += STEP * np.eye(3)
    slope = [((inverse_kinematics(arm, T).distance or 0.0) - result.distance) / STEP for T in moved]
    point: Array = pose[:3, 3] - result.distance * np.array(slope)
    return point


def nearest_words(arm: Arm, pose: Array, result: InverseResult) -> str:
    """The point in words, for the end of a line; empty where none is known."""
    point = nearest_point(arm, pose, result)
    if point is None:
        return ""
    return f"; the nearest point in this orientation: {','.join(f'{round(x, 4) + 0.0:.4f}' for x in point)}"
