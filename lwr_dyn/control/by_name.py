"""Controllers by name with the paper's gains, drawn from the arm's own worst-case inertias."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.control.inverse_dynamics import InverseDynamics
from lwr_dyn.control.pd_gravity import PDGravity
from lwr_dyn.control.pid import PID
from lwr_dyn.control.protocol import Controller
from lwr_dyn.control.worst_case_inertia import worst_cases
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.errors import UnknownNameError
from lwr_dyn.model.arm import Arm

CONTROLLERS = ("pd-gravity", "pid", "inverse-dynamics")


@dataclass(frozen=True, slots=True)
class Tuning:
    """What shapes a controller: omega_n [rad/s], xi, Ki [N m/(rad s)] of the PID, and the forms of the laws."""

    omega_n: float = 50.0
    xi: float = 1.0
    ki: float | None = None
    velocity_error: bool = False
    """PD and PID: Kd (dq_ref - dq) instead of the paper's -Kd dq."""
    feedforward: bool = True
    """Inverse dynamics: ddq_ref in the law; the paper drops it."""
    gravity: bool = True
    """Inverse dynamics: g in n(q, dq); PID: gravity compensation beside the integral."""


def controller_by_name(
    name: str, arm: Arm, tuning: Tuning | None = None, inertia: ArrayLike | None = None, engine: str = "pinocchio"
) -> Controller:
    """A controller that believes in `arm`.

    Parameters
    ----------
    name : {"pd-gravity", "pid", "inverse-dynamics"}
    arm : Arm
    tuning : Tuning, optional
        The paper's omega_n = 50 rad/s, xi = 1 if not given.
    inertia : (n,) array_like, optional
        b of each joint [kg m^2] for PD and PID; the worst case over the joint box if not given (Table IV).
    engine : str

    Raises
    ------
    UnknownNameError
        No controller or engine of that name.
    OptionError, ShapeError
        Gains that are not positive, inertias of the wrong shape.
    MissingDataError
        The arm has no inertias, or no limits to search its worst case in.
    """
    if name not in CONTROLLERS:
        raise UnknownNameError("controller", name, CONTROLLERS)
    t = tuning or Tuning()
    dynamics = dynamics_of(arm, engine)
    if name == "inverse-dynamics":
        unit = second_order_gains(np.ones(arm.n), t.omega_n, t.xi)
        return InverseDynamics(dynamics, unit.Kp, unit.Kd, t.feedforward, t.gravity)
    second_order_gains([1.0], t.omega_n, t.xi)  # refuse bad tuning before the search
    b = [w.value for w in worst_cases(arm)] if inertia is None else inertia
    gains = second_order_gains(b, t.omega_n, t.xi)
    if name == "pd-gravity":
        return PDGravity(dynamics, gains.Kp, gains.Kd, t.velocity_error)
    held = dynamics if t.gravity else None
    return PID(gains.Kp, gains.Kd, arm.effort, t.ki, held, t.velocity_error, t.omega_n)
