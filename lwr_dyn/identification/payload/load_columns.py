"""Torques of an arm per unit of the ten inertial parameters of a load that is fixed to its flange."""

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL, ROW_BY_ROW
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.pseudo_inertia import UNITS, inertial_parameters
from lwr_dyn.model.chain import Body
from lwr_dyn.model.spatial import Pose, steiner, symmetric_part

NAMES = INERTIAL
"""Mass, first moment and tensor about the origin of the flange's frame (the tool's point where the arm has a tool)."""


def load_shift(flange: Pose) -> Array:
    """A (10, 10): parameters of a body in the frame of the link that carries it, from those in the flange's frame.

    With H the pose of the flange and P the pseudo-inertia, P_link = H P H^T, which is linear in the parameters.
    """
    H = flange.matrix()
    return inertial_parameters(H @ UNITS @ H.T).T


def load_columns(last: Array, flange: Pose) -> Array:
    """Columns of the load (..., 10) from those of the last link (..., 10): it is a part of that link."""
    return np.asarray(last @ load_shift(flange))


def body_of(parameters: Array) -> Body:
    """The body with parameters (10,) about the origin of its frame; the mass must not be 0."""
    m, first = float(parameters[0]), parameters[1:4]
    com = first / m
    tensor = np.zeros((3, 3))
    for (a, b), value in zip(ROW_BY_ROW, parameters[4:], strict=True):
        tensor[a, b] = tensor[b, a] = value
    return Body(m, com, symmetric_part(tensor - steiner(m, com)))
