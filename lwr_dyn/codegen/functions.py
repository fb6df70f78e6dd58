"""The functions of a batch: what each takes, and the shape of what it gives for an arm of n joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from lwr_dyn.errors import UnknownNameError


@dataclass(frozen=True, slots=True)
class FunctionShape:
    """One function of a batch."""

    states: tuple[str, ...]
    """Joint vectors it takes, of q, dq, ddq, tau."""
    result: Callable[[int], tuple[int, ...]]
    """Shape of one result."""
    parameters: tuple[str, ...]
    """Inputs of a family that enter it."""
    says: str


_BODIES = ("inertia", "payload")
_ALL = ("inertia", "payload", "gravity", "friction")
_Q, _QV = ("q",), ("q", "dq")
_INVERSE, _FORWARD = ("q", "dq", "ddq"), ("q", "dq", "tau")

FUNCTIONS = {
    "inverse_dynamics": FunctionShape(_INVERSE, lambda n: (n,), _ALL, "tau"),
    "mass_matrix": FunctionShape(_Q, lambda n: (n, n), _BODIES, "B"),
    "bias_torque": FunctionShape(_QV, lambda n: (n,), (*_BODIES, "gravity"), "C dq + g"),
    "gravity_vector": FunctionShape(_Q, lambda n: (n,), (*_BODIES, "gravity"), "g"),
    "coriolis_matrix": FunctionShape(_QV, lambda n: (n, n), _BODIES, "C"),
    "forward_dynamics": FunctionShape(_FORWARD, lambda n: (n,), _ALL, "ddq"),
    "flange_pose": FunctionShape(_Q, lambda n: (4, 4), (), "T of the flange in the base"),
    "jacobian": FunctionShape(_Q, lambda n: (6, n), (), "J of the flange, linear rows over angular rows"),
    "kinetic_energy": FunctionShape(_QV, lambda n: (), _BODIES, "dq^T B dq / 2"),
    "potential_energy": FunctionShape(_Q, lambda n: (), (*_BODIES, "gravity"), "U"),
    "torque_regressor": FunctionShape(_INVERSE, lambda n: (n, 10 * n), ("gravity",), "Y with tau = Y pi + armature"),
    "inverse_dynamics_derivatives": FunctionShape(
        _INVERSE, lambda n: (3, n, n), _ALL, "d tau by q, by dq, by ddq (the last is B)"
    ),
    "forward_dynamics_derivatives": FunctionShape(
        _FORWARD, lambda n: (3, n, n), _ALL, "d ddq by q, by dq, by tau (the last is B^-1)"
    ),
}


def function_shape(name: str) -> FunctionShape:
    """The function of that name; raises `UnknownNameError`.

    >>> function_shape("jacobian").result(7)
    (6, 7)
    """
    if name not in FUNCTIONS:
        raise UnknownNameError("function of a batch", name, FUNCTIONS)
    return FUNCTIONS[name]
