"""The ten inertial parameters of a body in another frame.

They are (m, m c_x, m c_y, m c_z, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz) about the origin of the frame [kg, kg m, kg
m^2], as Pinocchio has them: the entries of the pseudo-inertia P (4, 4), the integral of x x^T dm with x = (position,
1), which a change of frame T turns into T P T^T. Wensing, Kim, Slotine, "Linear matrix inequalities for physically
consistent inertial parameter identification" (2018), section III.
"""

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm

COUNT = 10
"""Of one body."""


def parameter_turns(arm: Arm) -> Array:
    """(n, 10, 10) of each link: its parameters in the frame of its joint -> in that of the URDF's link.

    The link's frame of an arm that was read from a URDF is that of its file. The URDF that is written of another arm
    has the frames of the joints, so these are identities.
    """
    out = np.tile(np.eye(COUNT), (arm.n, 1, 1))
    if arm.layout is not None:
        for turn, link in zip(out, arm.chain.links, strict=True):
            into_link = link.after.inverse().matrix()
            turn[:] = np.column_stack([in_frame(unit, into_link) for unit in np.eye(COUNT)])
    return out


def in_frame(parameters: Array, T: Array) -> Array:
    """The parameters (10,) in a frame in which a point x of the present one is T x, T (4, 4) a pose."""
    inertia = parameters[[4, 5, 7, 5, 6, 8, 7, 8, 9]].reshape(3, 3)
    P = np.empty((4, 4))
    P[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    P[:3, 3] = P[3, :3] = parameters[1:4]
    P[3, 3] = parameters[0]
    P = T @ P @ T.T
    turned = np.trace(P[:3, :3]) * np.eye(3) - P[:3, :3]
    parameters_there: Array = np.r_[P[3, 3], P[:3, 3], turned[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]
    return parameters_there
