"""External torques: what acts on the links from outside, as a function of time and state, checked at each call."""

from collections.abc import Callable
from math import isfinite

import numpy as np

from lwr_dyn.control.protocol import joint_torque
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError

ExternalTorque = Callable[[float, Array, Array], Array]
"""tau_external(t, q, dq) (n,) [N m; N of a sliding joint]: B ddq + C dq + g = tau - tau_friction + tau_external.

It must depend on nothing else. An object with `name`, `parameters` and `energy(q)` [J] may stand for it."""


def checked_external(external: ExternalTorque, n: int) -> ExternalTorque:
    """The function, which now raises `ShapeError`, or `OptionError` for one that is not finite or for no function."""
    if not callable(external):
        raise OptionError("external", repr(external), "a function f(t, q, dq) -> tau")

    def checked(t: float, q: Array, dq: Array) -> Array:
        tau = joint_torque(f"external torque at t = {t:g} s", external(t, q, dq), n)
        if not isfinite(tau.dot(tau)) and np.isfinite(q + dq).all():
            raise OptionError(f"external torque at t = {t:g} s", tau.tolist(), "finite numbers")
        return tau

    return checked
