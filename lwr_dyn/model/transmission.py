"""The motor map dq_m = T dq of an arm, whose motors may drive several joints, and the springs of its gears.

Power is equal on both sides, tau^T dq = tau_m^T dq_m, so torques follow from the transpose, tau = T^T tau_m. The other
way takes the inverse of `matrix`, which is never singular.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays, joint_array, read_only, real_array
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.model.friction import JointFriction, friction_torque

SINGULAR = 1e-12
"""Ratio of smallest to largest singular value below which T counts as singular."""


@dataclass(frozen=True, slots=True, eq=False)
class Transmission:
    """A constant motor map T (n, n), motors by rows, joints by columns [1].

    Raises `ShapeError` for anything but a square matrix of finite numbers, `OptionError` for a singular one: a motion
    of the joints would turn no motor.

    References
    ----------
    WAM Arm User's Manual (2008), section 9.2.3, Equations 6 to 9; torques follow from equal power.

    >>> pair = Transmission([[28.25, -16.8155], [-28.25, -16.8155]])
    >>> pair.motor_velocity([1.0, 0.0]).tolist()
    [28.25, -28.25]
    >>> pair.reflected_inertia([1e-4, 1e-4]).diagonal().round(4).tolist()
    [0.1596, 0.0566]
    """

    matrix: Array

    def __post_init__(self) -> None:
        T = real_array("transmission", self.matrix)
        if T.ndim != 2 or T.shape[0] != T.shape[1] or not T.size:
            raise ShapeError("transmission", f"shape {T.shape}", "(n, n), one motor per row, one joint per column")
        sizes = np.linalg.svd(T, compute_uv=False)
        if sizes[-1] <= SINGULAR * sizes[0]:
            raise OptionError("transmission", "a singular matrix", "as many independent motors as joints")
        object.__setattr__(self, "matrix", read_only(T))

    @property
    def n(self) -> int:
        """Number of joints, and of motors."""
        return int(self.matrix.shape[0])

    @property
    def coupled(self) -> NDArray[np.bool_]:
        """Which joints share a motor with another, (n,)."""
        turns = self.matrix != 0.0
        return np.asarray((turns & (turns.sum(axis=1) > 1)[:, None]).any(axis=0))

    @property
    def seen_at_joints(self) -> bool:
        """Whether each motor turns as its own joint does, as `at_joints` has it."""
        return bool((np.diag(self.matrix) == 1.0).all())

    def at_joints(self) -> Transmission:
        """The same motors with their speeds seen at the joint of the same number: a row over its own joint's ratio.

        Inertia and friction of motors are then numbers as those of joints: a motor with one joint has that joint's.
        A motor that does not turn its own joint has the ratio 1 there in its largest entry, and is not seen at it.

        >>> Transmission([[45.0, 0.0], [32.0, 32.0]]).at_joints().matrix.tolist()
        [[1.0, 0.0], [1.0, 1.0]]
        """
        T, own = self.matrix, np.diag(self.matrix)
        largest = np.take_along_axis(T, np.abs(T).argmax(axis=1)[:, None], axis=1)[:, 0]
        return Transmission(T / np.where(own == 0.0, largest, own)[:, None] + 0.0)  # no -0

    def motor_velocity(self, dq: ArrayLike) -> Array:
        """dq_m = T dq, (..., n) for joint velocities (..., n) [rad/s]; also position differences."""
        return joint_array("dq", dq, self.n) @ self.matrix.T

    def joint_torque(self, tau_m: ArrayLike) -> Array:
        """Tau = T^T tau_m, (..., n) for motor torques (..., n) [N m]."""
        return joint_array("tau_m", tau_m, self.n) @ self.matrix

    def reflected_inertia(self, rotor_inertia: ArrayLike) -> Array:
        """T^T J_m T, (n, n) [kg m^2]: the rotors' part of the mass matrix, from (n,) inertias about their own axes.

        It couples two joints that share two motors, unless the motors are equal. Raises `ShapeError` for another number
        of rotors, `OptionError` for a negative inertia.
        """
        J = fixed_array("rotor_inertia", rotor_inertia, (self.n,))
        if (J < 0.0).any():
            raise OptionError("rotor_inertia", float(J.min()), "0 or more, in kg m^2")
        half = np.sqrt(J)[:, None] * self.matrix  # half^T half is symmetric to the last bit
        return np.asarray(half.T @ half)

    def between_joints(self, armature: ArrayLike) -> Array:
        """What motors that turn several joints add to the mass matrix beside its diagonal, (n, n) [kg m^2].

        Of rotors that give the joints' `armature` (n,) as the diagonal of T^T J T, the smallest ones where several do:
        0 for a differential of two equal motors.
        """
        J = np.linalg.lstsq(self.matrix.T**2, fixed_array("armature", armature, (self.n,)), rcond=1e-9)[0]
        whole = self.matrix.T @ (J[:, None] * self.matrix)
        return np.asarray(whole - np.diag(np.diag(whole)))

    def reflected_friction(self, motors: tuple[JointFriction | None, ...], dq: ArrayLike) -> Array:
        """T^T f(T dq), (..., n) [N m]: friction of the motors reflected to the joints, at dq (..., n) [rad/s].

        A joint at rest gets friction too when the other joint of its pair moves. Raises `ShapeError`.
        """
        return friction_torque(motors, self.motor_velocity(dq)) @ self.matrix


DAMPING_TIME = 1e-3
"""[s] Damping over stiffness where neither a file nor a caller gives it."""


@dataclass(frozen=True, slots=True, eq=False)
class JointElasticity:
    """The torque of gear i is K_i (theta_i - q_i) + D_i (dtheta_i - dq_i), theta the motor's angle seen at the joint.

    Raises `OptionError` for a stiffness that is not above 0 or a damping below 0, `ShapeError` for not one number a
    joint.
    """

    stiffness: Array  # K (n,) [N m/rad]
    damping: Array  # D (n,) [N m s/rad]
    source: str = "given by the caller"

    def __post_init__(self) -> None:
        n = np.size(self.stiffness)
        freeze_arrays(self, "stiffness", "damping")
        for name, least in (("stiffness", "above 0"), ("damping", "of at least 0")):
            values = fixed_array(f"joint {name}", getattr(self, name), (n,))
            bad = values <= 0.0 if name == "stiffness" else values < 0.0
            if bad.any():
                joint = int(np.argmax(bad))
                raise OptionError(f"{name} of joint {joint + 1}", f"{values[joint]:g}", f"numbers {least}")

    def of_joints(self, joints: list[int]) -> JointElasticity:
        """That of some joints (0-based)."""
        return JointElasticity(self.stiffness[joints], self.damping[joints], self.source)


def chosen_elasticity(arm: Any, option: JointElasticity | str | float | None) -> JointElasticity | None:
    """What the option `elasticity` of `simulate` names; None for rigid joints.

    A number is the largest stiffness [N m/rad]: the proportions of the joints, and damping over stiffness, are those of
    the arm's file, or all joints equal with `DAMPING_TIME`. Raises `OptionError`, and `MissingDataError` where the file
    gives none.
    """
    if option is None:
        return None
    if isinstance(option, JointElasticity):
        fixed_array("joint stiffness", option.stiffness, (arm.n,))
        return option
    own: JointElasticity | None = arm.elasticity
    if option == "file":
        if own is None:
            raise MissingDataError(arm.name, "joint stiffness", "elastic joints")
        return own
    if isinstance(option, bool | str) or not (isfinite(option) and option > 0.0):
        raise OptionError("stiffness", repr(option), '"file", a number above 0 in N m/rad, or a JointElasticity')
    if own is None:
        return JointElasticity(np.full(arm.n, option), np.full(arm.n, DAMPING_TIME * option))
    factor = option / own.stiffness.max()
    return JointElasticity(factor * own.stiffness, factor * own.damping, f"{own.source}, times {factor:g}")
