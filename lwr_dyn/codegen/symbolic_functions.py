"""The functions of a batch as CasADi expressions: the recursion evaluated on symbols.

The torque is linear in the inertial parameters. Where they are inputs, it is the derivative of the recursion in their
direction, at links of unit mass whose centre of mass is the origin and whose tensor is zero.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import casadi
import numpy as np

from lwr_dyn.codegen.kernel_spec import KernelSpec, function_shape
from lwr_dyn.codegen.ldl import ldl_factor, ldl_solve
from lwr_dyn.codegen.parameters import TENSOR, in_parent_frame, parameter_shape
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.recursion import LinkConstants, link_constants
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.kinematics.forward import jacobian_at, joint_axes
from lwr_dyn.model.chain import link_frames
from lwr_dyn.model.vectors import ZERO, Matrix3, Vector

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


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicDynamics:
    """The dynamics of one `KernelSpec` on symbols: joint vectors and inputs."""

    spec: KernelSpec
    q: Symbols
    dq: Symbols
    last: Symbols
    """ddq, or tau for forward dynamics."""
    inputs: dict[str, Symbols]
    """The inputs, flat."""

    def gravity(self) -> Vector:
        """The gravity vector, constant or input."""
        return Vector(*self.inputs["gravity"]) if "gravity" in self.inputs else Vector.of(self.spec.chain.gravity)

    def of_bodies(self, evaluate: Callable[[tuple[LinkConstants, ...]], Any]) -> Any:
        """A column that is linear in the inertial parameters, each of them a constant or an input."""
        constants = link_constants(self.spec.chain)
        directions = self._directions()
        if not directions:
            return column(evaluate(constants))
        probes, links, bare = [], list(constants), list(constants)
        for i in directions:
            probe = np.array([casadi.SX.sym(f"p{i}_{k}") for k in range(10)])
            probes.append(probe)
            links[i], bare[i] = _with_body(constants[i], probe), _without_body(constants[i])
        at, direction = column(probes), column(list(directions.values()))
        along = casadi.jtimes(column(evaluate(tuple(links))), at, direction)
        unit = casadi.DM([1.0, *[0.0] * 9] * len(directions))
        return casadi.substitute(along, at, unit) + column(evaluate(tuple(bare)))

    def _directions(self) -> dict[int, Any]:
        """Link -> its ten parameters as expressions, for links with an input."""
        n, chain = self.spec.n, self.spec.chain
        out: dict[int, Any] = {}
        if "inertia" in self.inputs:
            out = {i: list(self.inputs["inertia"][10 * i : 10 * i + 10]) for i in range(n)}
        if "payload" in self.inputs:
            load = in_parent_frame(self.inputs["payload"], chain.flange.rotation, chain.flange.position)
            body = chain.links[-1].body
            last = out.get(n - 1, [0.0] * 10 if body is None else list(body_parameters(body, TENSOR)))
            out[n - 1] = [a + b for a, b in zip(last, load, strict=True)]
        return out

    def torque(self, dq: Any, ddq: Any, gravity: Vector | None = None) -> Any:
        """Torque of the bodies and rotors, as a column; None for a joint vector of zeros."""
        still = np.zeros(self.spec.n)
        dq, ddq = (still if x is None else x for x in (dq, ddq))
        pull = self.gravity() if gravity is None else gravity
        return self.of_bodies(lambda links: Recursion(links, pull, self.spec.rotors).inverse_dynamics(self.q, dq, ddq))

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


def _friction(dq: Any, c_up: Any, v_up: Any, c_down: Any, v_down: Any, offset: Any) -> Any:
    """Friction torque of one moving joint: `up` towards positive, `down` towards negative values."""
    up, down = dq > 0, dq < 0
    return offset + c_up * up - c_down * down + v_down * dq + (v_up - v_down) * up * dq


def _with_body(link: LinkConstants, p: Any) -> LinkConstants:
    tensor = Matrix3(Vector(p[4], p[5], p[7]), Vector(p[5], p[6], p[8]), Vector(p[7], p[8], p[9]))
    return replace(link, mass=p[0], com=Vector(*p[1:4]), inertia=tensor)


def _without_body(link: LinkConstants) -> LinkConstants:
    return replace(link, mass=0.0, com=ZERO, inertia=Matrix3(ZERO, ZERO, ZERO))


def _mass_matrix(x: SymbolicDynamics) -> Any:
    """B: row i by one adjoint sweep of torque i; the upper half is mirrored, so the lower one is never computed."""
    ddq = scalars(casadi.SX.sym("a", x.spec.n))
    torque, at = x.torque(None, ddq, ZERO), column(ddq)
    unit = casadi.DM.eye(x.spec.n)
    rows = [casadi.jtimes(torque, at, unit[:, i], True).T for i in range(x.spec.n)]
    return casadi.triu2symm(casadi.triu(casadi.vertcat(*rows)))


def _coriolis_matrix(x: SymbolicDynamics) -> Any:
    """C = (d h / d dq) / 2 with h = C dq, which is quadratic in dq: the Christoffel form."""
    return casadi.jacobian(x.torque(x.dq, None, ZERO), column(x.dq)) / 2


def _forward_dynamics(x: SymbolicDynamics) -> Any:
    return ldl_solve(ldl_factor(_mass_matrix(x)), column(x.last) - x.applied(None))


def _inverse_derivatives(x: SymbolicDynamics) -> Any:
    torque = x.applied(x.last)
    return casadi.vertcat(
        *(_row_major(casadi.jacobian(torque, column(v))) for v in (x.q, x.dq)), _row_major(_mass_matrix(x))
    )


def _forward_derivatives(x: SymbolicDynamics) -> Any:
    """By the inverse function: d ddq = -B^-1 d tau(q, dq, ddq), at ddq as forward dynamics gives it."""
    ddq = casadi.SX.sym("a", x.spec.n)
    torque, factor = x.applied(scalars(ddq)), ldl_factor(_mass_matrix(x))
    solution = ldl_solve(factor, column(x.last) - x.applied(None))
    by_state = [casadi.substitute(casadi.jacobian(torque, column(v)), ddq, solution) for v in (x.q, x.dq)]
    inverse = casadi.triu2symm(casadi.triu(ldl_solve(factor, casadi.SX.eye(x.spec.n))))
    return casadi.vertcat(*(_row_major(-ldl_solve(factor, J)) for J in by_state), _row_major(inverse))


def _regressor(x: SymbolicDynamics) -> Any:
    """Y: the derivative of the torque by each link's parameters, joint by joint (adjoint sweeps)."""
    constants, n = link_constants(x.spec.chain), x.spec.n
    probes = np.array([[casadi.SX.sym(f"p{i}_{k}") for k in range(10)] for i in range(n)])
    links = tuple(_with_body(link, probe) for link, probe in zip(constants, probes, strict=True))
    torque, at = column(Recursion(links, x.gravity(), "none").inverse_dynamics(x.q, x.dq, x.last)), column(probes)
    unit = casadi.DM.eye(n)
    rows = [casadi.jtimes(torque, at, unit[:, i], True).T for i in range(n)]
    return casadi.substitute(casadi.vertcat(*rows), at, casadi.DM([1.0, *[0.0] * 9] * n))


def _kinetic_energy(x: SymbolicDynamics) -> Any:
    return casadi.dot(column(x.dq), x.torque(None, x.dq, ZERO)) / 2


def _potential_energy(x: SymbolicDynamics) -> Any:
    return x.of_bodies(lambda links: Recursion(links, x.gravity()).potential_energy(x.q))


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
    "mass_matrix": lambda x: _row_major(_mass_matrix(x)),
    "bias_torque": lambda x: x.torque(x.dq, None),
    "gravity_vector": lambda x: x.torque(None, None),
    "coriolis_matrix": lambda x: _row_major(_coriolis_matrix(x)),
    "forward_dynamics": _forward_dynamics,
    "flange_pose": _flange_pose,
    "jacobian": _jacobian,
    "kinetic_energy": _kinetic_energy,
    "potential_energy": _potential_energy,
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
    out = EXPRESSIONS[function](SymbolicDynamics(spec, q, dq, last, inputs))
    arguments = [symbols[name] for name in shape.states] + list(inputs.values())
    return casadi.Function(function, [column(a) for a in arguments], [casadi.densify(casadi.SX(out))])
