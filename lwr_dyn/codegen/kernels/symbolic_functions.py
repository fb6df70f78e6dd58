"""The functions of a batch as CasADi expressions.

L D L^T factorisation and solution of a small symmetric system in symbols, unrolled: no pivot, no square root.

The last row is eliminated first: of a mass matrix it is the first to be known.
"""

from collections.abc import Callable
from typing import Any

import casadi
import numpy as np

from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec, function_shape, parameter_shape
from lwr_dyn.codegen.kernels.lean_recursion import inverse_dynamics
from lwr_dyn.codegen.kernels.symbolic_dynamics import SymbolicDynamics, column, scalars
from lwr_dyn.kinematics.forward import jacobian_at, joint_axes
from lwr_dyn.model.chain import link_frames
from lwr_dyn.model.spatial import ZERO


def ldl_factor(B: Any) -> tuple[Any, Any]:
    """The unit upper triangle U and the reciprocal diagonal of D, with B = U D U^T."""
    n = B.shape[0]
    U, scaled, inverse = casadi.SX.eye(n), casadi.SX.zeros(n, n), casadi.SX.zeros(n)  # scaled = U D
    for j in reversed(range(n)):
        later = range(j + 1, n)
        inverse[j] = 1.0 / _less(B[j, j], ((scaled[j, k], U[j, k]) for k in later))
        for i in range(j):
            scaled[i, j] = _less(B[i, j], ((scaled[i, k], U[j, k]) for k in later))
            U[i, j] = scaled[i, j] * inverse[j]
    return U, inverse


def ldl_solve(factor: tuple[Any, Any], right: Any) -> Any:
    """B^-1 right, for one or several columns."""
    U, inverse = factor
    n, columns = right.shape
    out = casadi.SX.zeros(n, columns)
    for c in range(columns):
        y: list[Any] = [None] * n
        for i in reversed(range(n)):
            y[i] = _less(right[i, c], ((U[i, k], y[k]) for k in range(i + 1, n)))
        z: list[Any] = []
        for i in range(n):
            z.append(_less(y[i] * inverse[i], ((U[k, i], z[k]) for k in range(i))))
        out[:, c] = casadi.vertcat(*z)
    return out


def _less(start: Any, products: Any) -> Any:
    """start - a b - c d - ..."""
    for a, b in products:
        start = start - a * b
    return start


def _coriolis_matrix(x: SymbolicDynamics) -> Any:
    """C = (d h / d dq) / 2 with h = C dq, which is quadratic in dq: the Christoffel form."""
    return casadi.jacobian(x.torque(x.dq, None, ZERO), column(x.dq)) / 2


def _forward_dynamics(x: SymbolicDynamics) -> Any:
    return ldl_solve(ldl_factor(x.mass_matrix()), column(x.last) - x.applied(None))


def _inverse_derivatives(x: SymbolicDynamics) -> Any:
    torque = x.applied(x.last)
    return casadi.vertcat(
        *(_row_major(casadi.jacobian(torque, column(v))) for v in (x.q, x.dq)), _row_major(x.mass_matrix())
    )


def _forward_derivatives(x: SymbolicDynamics) -> Any:
    """By the inverse function: d ddq = -B^-1 d tau(q, dq, ddq), at ddq as forward dynamics gives it."""
    ddq = casadi.SX.sym("a", x.spec.n)
    torque, factor = x.applied(scalars(ddq)), ldl_factor(x.mass_matrix())
    solution = ldl_solve(factor, column(x.last) - x.applied(None))
    by_state = [casadi.substitute(casadi.jacobian(torque, column(v)), ddq, solution) for v in (x.q, x.dq)]
    inverse = casadi.triu2symm(casadi.triu(ldl_solve(factor, casadi.SX.eye(x.spec.n))))
    return casadi.vertcat(*(_row_major(-ldl_solve(factor, J)) for J in by_state), _row_major(inverse))


def _regressor(x: SymbolicDynamics) -> Any:
    """Y: the derivative of the torque by each link's parameters, joint by joint (adjoint sweeps)."""
    n = x.spec.n
    given = casadi.SX.sym("pi", 10 * n)
    positions = [x.q[..., i] for i in range(n)]
    torque = column(inverse_dynamics(x.frames, x.own(scalars(given)), x.gravity(), positions, list(x.dq), list(x.last)))
    unit = casadi.DM.eye(n)
    rows = [casadi.jtimes(torque, given, unit[:, i], True).T for i in range(n)]
    return casadi.substitute(casadi.vertcat(*rows), given, casadi.DM.zeros(10 * n))


def _kinetic_energy(x: SymbolicDynamics) -> Any:
    return casadi.dot(column(x.dq), x.torque(None, x.dq, ZERO)) / 2


def _flange_pose(x: SymbolicDynamics) -> Any:
    *_, pose = link_frames(x.spec.chain, x.q)
    return column(pose)


def _jacobian(x: SymbolicDynamics) -> Any:
    axes = joint_axes(x.spec.chain, x.q)
    return column(jacobian_at(axes, axes.flange[..., :3, 3]))


def _row_major(matrix: Any) -> Any:
    return casadi.vec(matrix.T)


EXPRESSIONS: dict[str, Callable[[SymbolicDynamics], Any]] = {
    "inverse_dynamics": lambda x: x.applied(x.last),
    "mass_matrix": lambda x: _row_major(x.mass_matrix()),
    "bias_torque": lambda x: x.torque(x.dq, None),
    "gravity_vector": lambda x: x.torque(None, None),
    "coriolis_matrix": lambda x: _row_major(_coriolis_matrix(x)),
    "forward_dynamics": _forward_dynamics,
    "flange_pose": _flange_pose,
    "jacobian": _jacobian,
    "kinetic_energy": _kinetic_energy,
    "potential_energy": lambda x: x.potential_energy(),
    "torque_regressor": lambda x: _row_major(_regressor(x)),
    "inverse_dynamics_derivatives": _inverse_derivatives,
    "forward_dynamics_derivatives": _forward_derivatives,
}


def symbolic_function(spec: KernelSpec, function: str) -> Any:
    """A function of a batch as a casadi.Function: joint vectors and inputs in, the flat result out.

    Raises `UnknownNameError` for a function that does not exist.
    """
    shape = function_shape(function)
    n = spec.n
    symbols = {
        name: scalars(casadi.SX.sym(name, n))
        for name in ("q", "dq", shape.states[-1] if len(shape.states) > 2 else "ddq")
    }
    inputs = {
        name: scalars(casadi.SX.sym(name, int(np.prod(parameter_shape(name, n)))))
        for name in spec.parameters_of(function)
    }
    q, dq, last = symbols.values()
    out = EXPRESSIONS[function](SymbolicDynamics.of(spec, q, dq, last, inputs))
    arguments = [symbols[name] for name in shape.states] + list(inputs.values())
    return casadi.Function(function, [column(a) for a in arguments], [casadi.densify(casadi.SX(out))])
