"""Velocities and accelerations of the links in symbols, from their matrices T_{i-1,i}(q_i), frame by frame.

omega_i = R^T omega_{i-1} + axis_i dq_i
v_i     = R^T (v_{i-1} + omega_{i-1} x p + dp/dq_i dq_i)        v_Ci = v_i + omega_i x c_i
domega_i = d(omega_i)/dt        a_Ci = d(v_Ci)/dt + omega_i x v_Ci
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from lwr_dyn.dynamics.symbolic.trigonometry import normal_form


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicBody:
    """A rigid body in its link's frame: mass, com (3, 1), inertia_com (3, 3) about the centre of mass."""

    mass: sp.Expr
    com: sp.Matrix
    inertia_com: sp.Matrix


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicLink:
    """Link `number` of its arm (from 1): T_{i-1,i}(q_i), body and rotor; `joint` is None for a fixed link.

    `axis` (3, 1) is the axis of a turning joint in the link's own frame; zero for a sliding joint.
    """

    number: int
    pose: sp.Matrix
    joint: sp.Symbol | None
    axis: sp.Matrix
    body: SymbolicBody | None = None
    armature: sp.Expr = sp.S.Zero


@dataclass(frozen=True, slots=True, eq=False)
class Variables:
    """Joint variables with their derivatives as plain symbols: q1, dq1, ddq1."""

    q: tuple[sp.Symbol, ...]
    dq: tuple[sp.Symbol, ...]
    ddq: tuple[sp.Symbol, ...]

    @classmethod
    def of(cls, q: Sequence[sp.Symbol]) -> Variables:
        """The derivatives of q named after it."""
        dq, ddq = (tuple(sp.Symbol(f"{d}{x.name}") for x in q) for d in ("d", "dd"))
        return cls(tuple(q), dq, ddq)

    def derivative(self, expression: Any) -> Any:
        """d/dt of an expression or matrix in q and dq.

        >>> x = Variables.of([sp.Symbol("q")])
        >>> x.derivative(x.q[0] ** 2 * x.dq[0])
        ddq*q**2 + 2*dq**2*q
        """
        both = (*zip(self.q, self.dq, strict=True), *zip(self.dq, self.ddq, strict=True))
        zero = expression * 0
        return sum((sp.diff(expression, x) * rate for x, rate in both), zero)


@dataclass(frozen=True, slots=True, eq=False)
class LinkMotion:
    """A link in motion, vectors (3, 1) in its own frame; `pose` (4, 4) is that frame in the base.

    `velocity` and `acceleration` are those of the centre of mass (of the frame's origin where there is no body).
    """

    number: int
    pose: sp.Matrix
    com: sp.Matrix
    omega: sp.Matrix
    domega: sp.Matrix
    velocity: sp.Matrix
    acceleration: sp.Matrix

    def position_in_base(self) -> sp.Matrix:
        """The centre of mass in the base frame, (3, 1)."""
        return self.pose[:3, :3] * self.com + self.pose[:3, 3]

    def in_base(self, vector: sp.Matrix, q: Sequence[sp.Symbol]) -> sp.Matrix:
        """A vector of this record in base axes, in normal form."""
        return normal_form(self.pose[:3, :3] * vector, q)


def link_of_matrix(
    number: int, pose: sp.Matrix, joint: sp.Symbol, body: SymbolicBody | None = None, armature: Any = sp.S.Zero
) -> SymbolicLink:
    """A link from its matrix alone: the axis is read from the skew matrix R^T dR/dq."""
    R = pose[:3, :3]
    turn = normal_form(R.T * R.diff(joint), [joint])
    return SymbolicLink(number, pose, joint, sp.Matrix([turn[2, 1], turn[0, 2], turn[1, 0]]), body, armature)


def link_motions(links: Sequence[SymbolicLink], variables: Variables) -> tuple[LinkMotion, ...]:
    """The motion of every link, from the base outward (Siciliano eqs. 3.25, 3.26, 7.99, 7.100 in symbols)."""
    q = variables.q
    rates = dict(zip(q, variables.dq, strict=True))
    pose, omega, v = sp.eye(4), sp.zeros(3, 1), sp.zeros(3, 1)
    out = []
    for link in links:
        R, p = link.pose[:3, :3], link.pose[:3, 3]
        v, omega = v + omega.cross(p), R.T * omega
        if link.joint is not None:
            v, omega = v + p.diff(link.joint) * rates[link.joint], omega + link.axis * rates[link.joint]
        v, omega = normal_form(R.T * v, q), normal_form(omega, q)
        pose = normal_form(pose * link.pose, q)
        com = sp.zeros(3, 1) if link.body is None else link.body.com
        velocity = normal_form(v + omega.cross(com), q)
        acceleration = normal_form(variables.derivative(velocity) + omega.cross(velocity), q)
        domega = normal_form(variables.derivative(omega), q)
        out.append(LinkMotion(link.number, pose, com, omega, domega, velocity, acceleration))
    return tuple(out)
