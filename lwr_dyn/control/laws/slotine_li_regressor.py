"""The regressor of Slotine and Li: torques with two velocities are linear in the inertial parameters too.

    Y(q, dq, dq_r, ddq_r) pi = B(q) ddq_r + C(q, dq) dq_r + g(q)        (rotors left out)

C is the Christoffel matrix, so that C(q, u) w is symmetric in u and w, and h(v) = C(q, v) v is quadratic in v:
C(q, u) w = h((u + w)/2) - h((u - w)/2). Both the torque and its regressor follow from functions of one velocity:

    Y(q, u, w, a) = Y(q, (u + w)/2, a) - Y_0(q, (u - w)/2, 0),    Y_0 without gravity.

Columns are ten a link in the frame of its joint, as Pinocchio has them: (m, m c_x, m c_y, m c_z, I_xx, I_xy, I_yy,
I_xz, I_yz, I_zz) about the origin of the frame [kg, kg m, kg m^2]; the last ten take whatever is fixed to the flange.

Source: Slotine, Li, "On the adaptive control of robot manipulators", Int. J. Robotics Research 6(3) (1987); the polar
form is that of any quadratic function.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm

PER_LINK = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""The parameters of a link, in the order of the columns."""


class SlotineLiRegressor:
    """Y (n, 10 n) and torque (n,) [N m] of single states (n,), unchecked, for loops; see this module.

    `parameters` (10 n,) are the arm's own, `armature` (n,) the rotors, which stand outside of Y.

    Raises
    ------
    MissingDataError
        The arm has no inertias.
    """

    def __init__(self, arm: Arm) -> None:
        weightless = arm.with_chain(replace(arm.chain, gravity=np.zeros(3)))
        with_gravity, without = (ungated(dynamics_of(one)) for one in (arm, weightless))
        raw: Any = with_gravity
        self.n, self.armature = arm.n, np.array(arm.armature)
        self.parameters = np.concatenate([body.toDynamicParameters() for body in raw.model.inertias[1:]])
        self._columns, self._columns_0 = raw.torque_regressor, getattr(without, "torque_regressor")  # noqa: B009
        self._torque, self._torque_0 = with_gravity.inverse_dynamics, without.bias_torque
        self._still = np.zeros(arm.n)

    def __call__(self, q: Array, dq: Array, dq_r: Array, ddq_r: Array) -> Array:
        """Y (n, 10 n): the torque per unit of each parameter."""
        half = 0.5 * (dq + dq_r)
        Y: Array = self._columns(q, half, ddq_r)
        Y -= self._columns_0(q, half - dq_r, self._still)
        return Y.reshape(self.n, -1)  # Pinocchio's of one joint is flat

    def torque(self, q: Array, dq: Array, dq_r: Array, ddq_r: Array) -> Array:
        """B ddq_r + C(q, dq) dq_r + g with the arm's own parameters and rotors: Y parameters + armature ddq_r."""
        half = 0.5 * (dq + dq_r)
        tau: Array = self._torque(q, half, ddq_r) - self._torque_0(q, half - dq_r)
        return tau
