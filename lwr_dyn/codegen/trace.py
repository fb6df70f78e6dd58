"""The recursion on symbols: what each function of a batch is as a CasADi expression.

With inertial parameters as inputs the torque is traced as what it is, linear in them: the derivative of the recursion
in their direction, at links of unit mass whose centre of mass is the origin and whose tensor is zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import casadi
import numpy as np

from lwr_dyn.codegen.form import Form
from lwr_dyn.codegen.functions import function_shape
from lwr_dyn.codegen.parameters import TENSOR, moved, parameter_shape
from lwr_dyn.codegen.triangles import factor_of, solved
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.recursion import LinkConstants, link_constants
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.kinematics.jacobian import jacobian_at, joint_axes
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
class Traced:
    """Symbols of one form: joint vectors, parameters, and the recursion that sees them."""

    form: Form
    q: Symbols
    dq: Symbols
    last: Symbols
    """ddq, or tau for forward dynamics."""
    given: dict[str, Symbols]
    """The form's inputs, flat."""

    def gravity(self) -> Vector:
        """The gravity vector, constant or input."""
        return Vector(*self.given["gravity"]) if "gravity" in self.given else Vector.of(self.form.chain.gravity)

    def of_bodies(self, evaluate: Callable[[tuple[LinkConstants, ...]], Any]) -> Any:
        """A column that is linear in the inertial parameters, with constants and inputs where the form has them."""
        constants = link_constants(self.form.chain)
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
        """Link -> its ten parameters as expressions, where an input enters them."""
        n, chain = self.form.n, self.form.chain
        out: dict[int, Any] = {}
        if "inertia" in self.given:
            out = {i: list(self.given["inertia"][10 * i : 10 * i + 10]) for i in range(n)}
        if "payload" in self.given:
            load = moved(self.given["payload"], chain.flange.rotation, chain.flange.position)
            body = chain.links[-1].body
            last = out.get(n - 1, [0.0] * 10 if body is None else list(body_parameters(body, TENSOR)))
            out[n - 1] = [a + b for a, b in zip(last, load, strict=True)]
        return out

    def torque(self, dq: Any, ddq: Any, gravity: Vector | None = None) -> Any:
        """Torque of the bodies and rotors, as a column; None for a joint vector of zeros."""
        still = np.zeros(self.form.n)
        dq, ddq = (still if x is None else x for x in (dq, ddq))
        pull = self.gravity() if gravity is None else gravity
        return self.of_bodies(lambda links: Recursion(links, pull, self.form.rotors).inverse_dynamics(self.q, dq, ddq))

    def friction(self) -> Any:
        """Torque of friction, as a column: per direction F_c sign(dq) + F_v dq, plus the offset (`friction.models`)."""
        n = self.form.n
        table = self.given.get("friction", self.form.friction)
        if table is None:
            return casadi.SX.zeros(n)
        return column([_slip(x, *one) for x, one in zip(self.dq, np.reshape(table, (-1, n)).T, strict=True)])

    def applied(self, ddq: Any) -> Any:
        """What the motors give: torque of the bodies plus friction."""
        return self.torque(self.dq, ddq) + self.friction()


def _slip(dq: Any, c_up: Any, v_up: Any, c_down: Any, v_down: Any, offset: Any) -> Any:
    """Slip torque of one joint: `up` moving towards positive, `down` towards negative values."""
    up, down = dq > 0, dq < 0
    return offset + c_up * up - c_down * down + v_down * dq + (v_up - v_down) * up * dq


def _with_body(link: LinkConstants, p: Any) -> LinkConstants:
    tensor = Matrix3(Vector(p[4], p[5], p[7]), Vector(p[5], p[6], p[8]), Vector(p[7], p[8], p[9]))
    return replace(link, mass=p[0], com=Vector(*p[1:4]), inertia=tensor)


def _without_body(link: LinkConstants) -> LinkConstants:
    return replace(link, mass=0.0, com=ZERO, inertia=Matrix3(ZERO, ZERO, ZERO))


def _mass_matrix(x: Traced) -> Any:
    """B, row i by one adjoint sweep of torque i, its upper half mirrored: what is below is never computed."""
    ddq = scalars(casadi.SX.sym("a", x.form.n))
    torque, at = x.torque(None, ddq, ZERO), column(ddq)
    unit = casadi.DM.eye(x.form.n)
    rows = [casadi.jtimes(torque, at, unit[:, i], True).T for i in range(x.form.n)]
    return casadi.triu2symm(casadi.triu(casadi.vertcat(*rows)))


def _coriolis_matrix(x: Traced) -> Any:
    """C = (d h / d dq) / 2 with h = C dq, which is quadratic in dq: the Christoffel form."""
    return casadi.jacobian(x.torque(x.dq, None, ZERO), column(x.dq)) / 2


def _forward_dynamics(x: Traced) -> Any:
    return solved(factor_of(_mass_matrix(x)), column(x.last) - x.applied(None))


def _inverse_derivatives(x: Traced) -> Any:
    torque = x.applied(x.last)
    return casadi.vertcat(
        *(_row_major(casadi.jacobian(torque, column(v))) for v in (x.q, x.dq)), _row_major(_mass_matrix(x))
    )


def _forward_derivatives(x: Traced) -> Any:
    """By the inverse function: d ddq = -B^-1 d tau(q, dq, ddq), at ddq as forward dynamics gives it."""
    ddq = casadi.SX.sym("a", x.form.n)
    torque, factor = x.applied(scalars(ddq)), factor_of(_mass_matrix(x))
    found = solved(factor, column(x.last) - x.applied(None))
    by_state = [casadi.substitute(casadi.jacobian(torque, column(v)), ddq, found) for v in (x.q, x.dq)]
    inverse = casadi.triu2symm(casadi.triu(solved(factor, casadi.SX.eye(x.form.n))))
    return casadi.vertcat(*(_row_major(-solved(factor, J)) for J in by_state), _row_major(inverse))


def _regressor(x: Traced) -> Any:
    """Y: the derivative of the torque by each link's parameters, joint by joint (adjoint sweeps)."""
    constants, n = link_constants(x.form.chain), x.form.n
    probes = np.array([[casadi.SX.sym(f"p{i}_{k}") for k in range(10)] for i in range(n)])
    links = tuple(_with_body(link, probe) for link, probe in zip(constants, probes, strict=True))
    torque, at = column(Recursion(links, x.gravity(), "none").inverse_dynamics(x.q, x.dq, x.last)), column(probes)
    unit = casadi.DM.eye(n)
    rows = [casadi.jtimes(torque, at, unit[:, i], True).T for i in range(n)]
    return casadi.substitute(casadi.vertcat(*rows), at, casadi.DM([1.0, *[0.0] * 9] * n))


def _kinetic_energy(x: Traced) -> Any:
    return casadi.dot(column(x.dq), x.torque(None, x.dq, ZERO)) / 2


def _potential_energy(x: Traced) -> Any:
    return x.of_bodies(lambda links: Recursion(links, x.gravity()).potential_energy(x.q))


def _flange_pose(x: Traced) -> Any:
    *_, pose = link_frames(x.form.chain, x.q)
    return column(pose)


def _jacobian(x: Traced) -> Any:
    axes = joint_axes(x.form.chain, x.q)
    return column(jacobian_at(axes, axes.flange[..., :3, 3]))


def _row_major(matrix: Any) -> Any:
    return casadi.vec(matrix.T)


EXPRESSIONS: dict[str, Callable[[Traced], Any]] = {
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


def trace(form: Form, function: str) -> Any:
    """A function of a batch as a casadi.Function: joint vectors and inputs in, the flat result out.

    Raises `UnknownNameError` for a function that does not exist.
    """
    shape = function_shape(function)
    n = form.n
    symbols = {
        name: scalars(casadi.SX.sym(name, n))
        for name in ("q", "dq", shape.states[-1] if len(shape.states) > 2 else "ddq")
    }
    given = {
        name: scalars(casadi.SX.sym(name, int(np.prod(parameter_shape(name, n)))))
        for name in form.parameters_of(function)
    }
    q, dq, last = symbols.values()
    out = EXPRESSIONS[function](Traced(form, q, dq, last, given))
    arguments = [symbols[name] for name in shape.states] + list(given.values())
    return casadi.Function(function, [column(a) for a in arguments], [casadi.densify(casadi.SX(out))])
