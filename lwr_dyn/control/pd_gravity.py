"""PD with gravity compensation, joint by joint: the paper's decentralised controller."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array
from lwr_dyn.control.protocol import positive_gains
from lwr_dyn.dynamics.protocol import Dynamics, ungated


class PDGravity:
    """tau = g(q) + Kp (q_ref - q) - Kd dq; with `velocity_error`, Kd (dq_ref - dq) in place of -Kd dq.

    Parameters
    ----------
    dynamics : Dynamics
        The model the controller believes in; it gives g.
    Kp, Kd : float or (n,) array_like
        [N m/rad], [N m s/rad]; the paper takes omega_n^2 b and 2 xi omega_n b.
    velocity_error : bool
        Brake the error's speed instead of the joint's: the lag (2 xi / omega_n) dq_ref of the paper's form goes.

    Raises
    ------
    ShapeError, OptionError
        Gains of the wrong length, or not positive.

    References
    ----------
    LWR 4+ paper, "Decentralized PID type joint controller"; Siciliano et al., eq. 8.51.
    """

    __slots__ = ("Kd", "Kp", "_gravity", "velocity_error")

    name = "pd-gravity"

    def __init__(self, dynamics: Dynamics, Kp: ArrayLike, Kd: ArrayLike, velocity_error: bool = False) -> None:
        self.Kp = positive_gains("Kp", Kp, dynamics.n)
        self.Kd = positive_gains("Kd", Kd, dynamics.n)
        self.velocity_error = velocity_error
        self._gravity: Callable[[Array], Array] = ungated(dynamics).gravity_vector

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        return {"Kp": self.Kp.tolist(), "Kd": self.Kd.tolist(), "velocity_error": self.velocity_error}

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        if self.velocity_error:
            dq = dq - dq_ref
        return self._gravity(q) + self.Kp * (q_ref - q) - self.Kd * dq
