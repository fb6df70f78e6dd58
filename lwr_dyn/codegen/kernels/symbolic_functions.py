"""The functions of a batch on symbols: the lean recursion traced as CasADi expressions.

Where inertial parameters are constants it is traced on base parameters. Rotors that enter completely ("full") add the
torque of the readable recursion on links without bodies. Systems are solved by B = U D U^T, unrolled: no pivot, no
square root, the last row first, which of a mass matrix is the first to be known.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import Any

import casadi
import numpy as np

from lwr_dyn.codegen.kernels import kernel_spec as specs
from lwr_dyn.codegen.kernels import lean_recursion as lean
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.codegen.kernels.lean_recursion import EXACT, AxisFrame
from lwr_dyn.dynamics.recursion import inverse_dynamics, link_constants
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import jacobian_at, joint_axes
from lwr_dyn.model.chain import link_frames
from lwr_dyn.model.spatial import ZERO, Matrix3, Pose, Vector, add, multiply

Symbols = Any
"""A NumPy array of casadi.SX scalars."""


def column(scalars: Any) -> Any:
    """An array of scalars as one casadi column."""
    return casadi.vertcat(*(casadi.SX(x) for x in np.asarray(scalars, dtype=object).ravel()))


def scalars(vector: Any) -> Symbols:
    """A casadi column as an array of scalars."""
    out = np.empty(vector.numel(), dtype=object)
    out[:] = casadi.vertsplit(vector)
    return out


def _moved(parameters: Any, pose: Pose) -> list[Any]:
    """Inertial parameters (10,) of symbols in the parent of a frame with this pose, by numbers times each of them.

    As terms that cancel do not stand in it, single precision keeps its digits.
    """
    matrix = specs.to_parent(pose)
    rows = np.where(np.abs(matrix) < EXACT, 0.0, matrix).tolist()
    return [reduce(add, map(multiply, parameters, row)) for row in rows]


@dataclass(frozen=True, eq=False)
class SymbolicDynamics:
    """The dynamics of one `KernelSpec` on symbols: joint vectors and inputs."""

    spec: KernelSpec
    q: Symbols
    dq: Symbols
    last: Symbols
    """ddq, or tau for forward dynamics."""
    inputs: dict[str, Symbols]
    """The inputs, flat."""
    frames: tuple[AxisFrame, ...]

    def gravity(self) -> Vector:
        """The gravity vector, constant or input."""
        return Vector(*self.inputs["gravity"]) if "gravity" in self.inputs else Vector.of(self.spec.chain.gravity)

    def own(self, given: Any) -> list[list[Any]]:
        """Parameters in the links' frames, flat, as the lean recursion takes them."""
        rows = np.reshape(np.asarray(given, dtype=object), (self.spec.n, 10))
        return [_moved(row, frame.link) for frame, row in zip(self.frames, rows, strict=True)]

    def bodies(self, are_folded: bool = True) -> list[list[Any]]:
        """The ten parameters of each body: those of the inputs, or constants, folded into base parameters."""
        if "inertia" in self.inputs:
            bodies = self.own(self.inputs["inertia"])
        else:
            bodies = (self.folded if are_folded else self.constants).reshape(self.spec.n, 10).tolist()
        if "payload" in self.inputs:
            load = _moved(self.inputs["payload"], self.frames[-1].link @ self.spec.chain.flange)
            bodies[-1] = [add(a, b) for a, b in zip(bodies[-1], load, strict=True)]
        return bodies

    @cached_property
    def constants(self) -> Array:
        """The arm's inertial parameters in the frames of its joint axes, (10 n,)."""
        return np.asarray(lean.parameter_map(self.frames) @ specs.inertial_parameters(self.spec.chain).ravel())

    @cached_property
    def folded(self) -> Array:
        """The same as base parameters, (10 n,)."""
        gravity = None if "gravity" in self.inputs else self.spec.chain.gravity
        return np.asarray(lean.base_matrix(self.frames, gravity) @ self.constants)

    def torque(self, dq: Any, ddq: Any, gravity: Vector | None = None) -> Any:
        """Torque of the bodies and rotors, as a column; None for a joint vector of zeros."""
        pull = self.gravity() if gravity is None else gravity
        dq, ddq = ([0.0] * self.spec.n if x is None else list(x) for x in (dq, ddq))
        bodies = lean.inverse_dynamics(self.frames, self.bodies(), pull, self.positions, dq, ddq)
        return column([add(a, b) for a, b in zip(bodies, self._rotors(dq, ddq), strict=True)])

    def mass_matrix(self) -> Any:
        """B, by composite bodies."""
        n = self.spec.n
        B = lean.mass_matrix(self.frames, self.bodies(), self.positions)
        for j in range(n):
            rotors = self._rotors([0.0] * n, [float(i == j) for i in range(n)])
            for i in range(n):
                B[i][j] = add(B[i][j], rotors[i])
        return casadi.vertcat(*(column(row).T for row in B))

    def potential_energy(self) -> Any:
        """U of the bodies."""
        return lean.potential_energy(self.frames, self.bodies(are_folded=False), self.gravity(), self.positions)

    def friction(self) -> Any:
        """Torque of friction, as a column: per direction F_c sign(dq) + F_v dq, plus the offset (`model.friction`)."""
        n = self.spec.n
        table = self.inputs.get("friction", self.spec.friction)
        if table is None:
            return casadi.SX.zeros(n)
        return column([_friction(x, *row) for x, row in zip(self.dq, np.reshape(table, (-1, n)).T, strict=True)])

    def applied(self, ddq: Any) -> Any:
        """Torque of the motors: of bodies and rotors, plus friction."""
        return self.torque(self.dq, ddq) + self.friction()

    @property
    def positions(self) -> list[Any]:
        """q, joint by joint."""
        return [self.q[..., i] for i in range(self.spec.n)]  # as NumPy's cos takes symbols

    def _rotors(self, dq: Sequence[Any], ddq: Sequence[Any]) -> list[Any]:
        """Torques of the rotors alone."""
        links, rotors = link_constants(self.spec.chain), self.spec.rotors
        if rotors == "none":
            return [0.0] * len(links)
        if rotors == "armature":
            armature = (x.gear_ratio**2 * x.rotor_inertia for x in links)
            return [multiply(j, a) for j, a in zip(armature, ddq, strict=True)]
        bare = [replace(x, mass=0.0, com=ZERO, inertia=Matrix3(ZERO, ZERO, ZERO)) for x in links]
        return inverse_dynamics(bare, ZERO, self.positions, dq, ddq, rotors)


def _friction(dq: Any, c_up: Any, v_up: Any, c_down: Any, v_down: Any, offset: Any) -> Any:
    """Friction torque of one moving joint: `up` towards positive, `down` towards negative values."""
    up, down = dq > 0, dq < 0
    return offset + c_up * up - c_down * down + v_down * dq + (v_up - v_down) * up * dq


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
    by_state = (_row_major(casadi.jacobian(torque, column(v))) for v in (x.q, x.dq))
    return casadi.vertcat(*by_state, _row_major(x.mass_matrix()))


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
    bodies = x.own(scalars(given))
    torque = column(lean.inverse_dynamics(x.frames, bodies, x.gravity(), x.positions, list(x.dq), list(x.last)))
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
    shape, n = specs.function_shape(function), spec.n
    names = ("q", "dq", shape.states[-1] if len(shape.states) > 2 else "ddq")
    symbols = {name: scalars(casadi.SX.sym(name, n)) for name in names}
    widths = {name: int(np.prod(specs.parameter_shape(name, n))) for name in spec.parameters_of(function)}
    inputs = {name: scalars(casadi.SX.sym(name, width)) for name, width in widths.items()}
    q, dq, last = symbols.values()
    out = EXPRESSIONS[function](SymbolicDynamics(spec, q, dq, last, inputs, lean.axis_frames(spec.chain)))
    arguments = [symbols[name] for name in shape.states] + list(inputs.values())
    return casadi.Function(function, [column(a) for a in arguments], [casadi.densify(casadi.SX(out))])
