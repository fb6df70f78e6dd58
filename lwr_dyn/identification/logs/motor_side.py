"""Logs of the motors as logs of the joints: positions through the gears, torques from currents.

    q = T^-1 (q_m - q_m0),   tau = T^T (k_t i)

T is the motor map dq_m = T dq of `lwr_dyn.model.transmission`, which may couple joints (cable differentials). Friction
of the motors stays in tau: it is T^T f(T dq), so the columns of a regression on such logs go through T too.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays
from lwr_dyn.foundation.errors import LogError, MissingDataError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.transmission import Transmission


@dataclass(frozen=True, slots=True, eq=False)
class MotorMap:
    """What turns readings of motors into those of joints.

    Parameters
    ----------
    transmission : Transmission
        T (n, n), motors by rows.
    torque_constant : (n,) array_like, optional
        k_t, torque of a motor's shaft over its current [N m/A]; without, the log's tau are the motors' torques [N m].
    home : (n,) array_like, optional
        What the motors' encoders show where all joints are at 0 [rad]; zeros if not given.

    Raises
    ------
    ShapeError
        Not one number a motor.
    OptionError
        A torque constant that is not above 0.
    """

    transmission: Transmission
    torque_constant: Array | None = None
    home: Array | None = None

    def __post_init__(self) -> None:
        n = self.transmission.n
        for name in ("torque_constant", "home"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, fixed_array(name, getattr(self, name), (n,)))
                freeze_arrays(self, name)
        constant = self.torque_constant
        if constant is not None and not (constant > 0.0).all():
            motor = int(np.argmin(constant)) + 1
            allowed = "above 0, in N m/A; the sign of a motor stands in its transmission"
            raise OptionError(f"torque constant of motor {motor}", f"{constant.min():g}", allowed)

    def positions(self, motor_q: ArrayLike) -> Array:
        """Joint positions (k, n) [rad] of motor positions (k, n) [rad]."""
        turned = np.asarray(motor_q, dtype=np.float64) - (0.0 if self.home is None else self.home)
        return np.asarray(np.linalg.solve(self.transmission.matrix, turned.T).T, dtype=np.float64)


def motor_map(arm: Arm, torque_constant: ArrayLike | None = None, home: ArrayLike | None = None) -> MotorMap:
    """The motor map of an arm: its transmission, or its gears where no motor drives two joints.

    Raises
    ------
    MissingDataError
        The arm's source gives neither a transmission nor the gear ratio of every joint.
    ShapeError, OptionError
        As `MotorMap`.
    """
    gears = arm.transmission
    if gears is None:
        rotors = [link.rotor for link in arm.chain.links]
        for joint, rotor in zip(arm.joint_names, rotors, strict=True):
            if rotor is None or rotor.reflected:
                lacking = f"the motor map and the gear ratio of {joint}"
                raise MissingDataError(arm.name, lacking, "logs of the motors' side")
        gears = Transmission(np.diag([rotor.gear_ratio for rotor in rotors if rotor is not None]))
    as_array = [None if x is None else fixed_array(name, x, (arm.n,))
                for name, x in (("torque constants", torque_constant), ("home", home))]  # fmt: skip
    return MotorMap(gears, *as_array)


def log_at_joints(log: JointLog, motors: MotorMap) -> JointLog:
    """The log with q and tau of the joints, from positions (`qm1`..) and currents (`i1`..) or torques of the motors.

    The measured joint speeds, if any, and the readings of the motors stay as they are.

    Parameters
    ----------
    log : JointLog
        Of as many motors as the map has, in its order.

    Raises
    ------
    LogError
        Another number of motors, no motor positions, no currents where a torque constant is given, or neither currents
        with a constant nor torques.

    >>> from lwr_dyn.model.transmission import Transmission
    >>> log = JointLog("x", (1,), np.arange(2.0), np.zeros((2, 1)), np.full((2, 1), np.nan),
    ...                motor_q=np.array([[0.0], [5.0]]), current=np.ones((2, 1)))
    >>> joint = log_at_joints(log, MotorMap(Transmission([[10.0]]), np.array([0.2])))
    >>> joint.q[:, 0].tolist(), joint.tau[:, 0].tolist()
    ([0.0, 0.5], [2.0, 2.0])
    """
    n = motors.transmission.n
    if log.motor_q is None or log.motor_q.shape[1] != n:
        found = "none" if log.motor_q is None else f"{log.motor_q.shape[1]}"
        raise LogError(log.source, "columns qm1..", found, f"the positions of {n} motors, qm1..qm{n}")
    return replace(log, q=motors.positions(log.motor_q), tau=_shaft_torque(log, motors) @ motors.transmission.matrix)


def _shaft_torque(log: JointLog, motors: MotorMap) -> Array:
    if motors.torque_constant is not None:
        if log.current is None:
            raise LogError(log.source, "columns i1..", "none", "currents, for the torque constants that are given")
        return log.current * motors.torque_constant
    if log.current is not None and not np.isfinite(log.tau).all():
        needed = "torque constants (N m/A), or torques of the motors"
        raise LogError(log.source, "columns i1..", "currents alone", needed)
    return log.tau
