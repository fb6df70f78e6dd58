"""The torque that moves a compliant arm along its reference without cancelling its own dynamics (PD+)."""

from collections.abc import Callable

from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array

CarriedTorque = Callable[[Array, Array, Array, Array], Array]
"""(q, dq, dq_ref, ddq_ref) -> (n,) [N m]."""


def carried_torque(dynamics: Dynamics, feedforward: bool) -> CarriedTorque:
    """B(q) ddq_ref + C(q, dq) dq_ref + g(q), or g(q) alone without feed-forward.

    C(q, v) w is symmetric in v and w (Christoffel form), so with c(v) = C(q, v) v it is
    C(q, dq) dq_ref = c((dq + dq_ref) / 2) - c((dq - dq_ref) / 2): three runs of the recursion, no matrix.

    References
    ----------
    Paden, Panja, "Globally asymptotically stable PD+ controller for robot manipulators", Int. J. Control 47 (1988).
    """
    raw = ungated(dynamics)
    torque, bias, gravity = raw.inverse_dynamics, raw.bias_torque, raw.gravity_vector

    def carried(q: Array, dq: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        tau: Array = torque(q, 0.5 * (dq + dq_ref), ddq_ref) - bias(q, 0.5 * (dq - dq_ref)) + gravity(q)
        return tau

    def held(q: Array, dq: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        weight: Array = gravity(q)
        return weight

    return carried if feedforward else held
