"""Symbolic equations of motion of an arm: matrices, symbols for masses and inertias, and their numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.dynamics.symbolic.dh_matrices import dh_matrices, exact_angle, length_values
from lwr_dyn.dynamics.symbolic.lagrangian import EquationsOfMotion, euler_lagrange, reduced_chain
from lwr_dyn.dynamics.symbolic.link_motion import SymbolicBody, SymbolicLink, link_of_matrix
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, Chain, ChainLink, first_links, lock_joint
from lwr_dyn.model.dh import JointKind

AXES = "xyz"
PAIRS = [(i, j) for i in range(3) for j in range(i, 3)]


@dataclass(frozen=True, slots=True, eq=False)
class ArmEquations:
    """Equations of motion of some joints of an arm, and the arm's numbers for their symbols."""

    equations: EquationsOfMotion
    values: Mapping[str, float]
    arm: Arm
    """The arm with its held joints locked and those after the last one cut off: an engine computes the same for it."""


def equations_of_motion(
    arm: Arm,
    joints: Sequence[str],
    held: Mapping[str, float] | None = None,
    paper: Paper | None = None,
    keep_zeros: bool = False,
) -> ArmEquations:
    """The equations of motion of some joints of an arm, derived in symbols from the Lagrangian.

    Parameters
    ----------
    arm : Arm
    joints : sequence of str
        Names of those that move.
    held : mapping, optional
        Joint -> value [rad or m]; required for every other joint up to the last one named. The joints after that one
        are cut off with their links.
    paper : Paper, optional
        The arm's own data file: lengths are then the paper's letters, else the chain's numbers.
    keep_zeros : bool
        0 instead of a symbol for a coordinate of a centre of mass or a product of inertia that is exactly 0 in the
        arm's numbers: shorter equations for links with mirror symmetry.

    Raises
    ------
    UnknownNameError
        No joint of that name.
    OptionError
        A joint that is named twice, or one in between that is neither moving nor held.
    MissingDataError
        `keep_zeros` for an arm without inertias.
    """
    moving = [_index(arm, name) for name in joints]
    fixed = {_index(arm, name): float(value) for name, value in (held or {}).items()}
    bodies = arm.require_dynamics().bodies if keep_zeros else None
    links = symbolic_links(arm.chain, paper, bodies)
    exact = {
        i: exact_angle(x) if arm.chain.links[i].kind is JointKind.REVOLUTE else _exact(x) for i, x in fixed.items()
    }
    part = reduced_chain(links, moving, exact)
    equations = euler_lagrange(part, gravity_symbols(arm.chain.gravity))
    return ArmEquations(equations, symbol_values(arm.chain, paper), reduced_arm(arm, moving, fixed))


def symbolic_links(
    chain: Chain, paper: Paper | None = None, like: Sequence[Body] | None = None
) -> tuple[SymbolicLink, ...]:
    """The links of a chain: matrices in a paper's letters or in the chain's numbers, symbols for every body."""
    out = []
    matrices = None if paper is None else dh_matrices(paper)
    for i, link in enumerate(chain.links):
        body = body_symbols(i + 1, None if like is None else like[i])
        armature = sp.Symbol(f"Ia{i + 1}") if link.rotor is not None else sp.Integer(0)
        q = sp.Symbol(f"q{i + 1}")
        if matrices is None:
            out.append(_numeric_link(i + 1, link, q, body, armature))
        else:
            out.append(link_of_matrix(i + 1, matrices[i], q, body, armature))
    return tuple(out)


def body_symbols(number: int, like: Body | None = None) -> SymbolicBody:
    """Mass m1, centre of mass c1x.., moments and products I1xx, I1xy.. (tensor sign) about it, for link `number`.

    >>> body_symbols(2).inertia_com[0, 1]
    I2xy
    """

    def letter(name: str, value: float | None) -> sp.Expr:
        return sp.Integer(0) if value == 0.0 else sp.Symbol(name)

    com = [letter(f"c{number}{a}", None if like is None else like.com[i]) for i, a in enumerate(AXES)]
    tensor = sp.zeros(3, 3)
    for i, j in PAIRS:
        name = f"I{number}{AXES[i]}{AXES[j]}"
        tensor[i, j] = tensor[j, i] = letter(name, None if like is None else like.inertia_com[i, j])
    return SymbolicBody(sp.Symbol(f"m{number}"), sp.Matrix(com), tensor)


def body_values(number: int, body: Body) -> dict[str, float]:
    """The numbers of `body_symbols(number)`."""
    values = {f"m{number}": body.mass}
    values |= {f"c{number}{a}": float(body.com[i]) for i, a in enumerate(AXES)}
    return values | {f"I{number}{AXES[i]}{AXES[j]}": float(body.inertia_com[i, j]) for i, j in PAIRS}


def symbol_values(chain: Chain, paper: Paper | None = None) -> dict[str, float]:
    """The arm's numbers for all symbols: lengths of the paper, bodies where given, rotors, gravity."""
    values = {} if paper is None else length_values(paper)
    for i, link in enumerate(chain.links, start=1):
        values |= {} if link.body is None else body_values(i, link.body)
        values |= {} if link.rotor is None else {f"Ia{i}": link.rotor.armature}
    symbols = gravity_symbols(chain.gravity).free_symbols
    parts = {f"g0{a}": float(x) for a, x in zip(AXES, chain.gravity, strict=True)}
    parts["g0"] = float(np.abs(chain.gravity).max())
    return values | {s.name: parts[s.name] for s in symbols}


def gravity_symbols(gravity: Array) -> sp.Matrix:
    """Gravity along one axis of the base as +-g0; in any other direction as (g0x, g0y, g0z).

    >>> gravity_symbols(np.array([0.0, 0.0, -9.81])).T
    Matrix([[0, 0, -g0]])
    """
    if np.count_nonzero(gravity) == 1:
        return sp.Matrix([int(np.sign(x)) * sp.Symbol("g0") for x in gravity])
    return sp.Matrix([sp.Symbol(f"g0{a}") if x != 0.0 else 0 for a, x in zip(AXES, gravity, strict=True)])


def reduced_arm(arm: Arm, moving: Sequence[int], held: Mapping[int, float]) -> Arm:
    """The arm with the held joints locked and everything after the last named joint cut off."""
    chain = first_links(arm.chain, 1 + max([*moving, *held]))
    for i in sorted(held, reverse=True):
        chain = lock_joint(chain, i, held[i])
    return replace(arm, chain=chain, limits=tuple(arm.limits[i] for i in sorted(moving)), sources={})


def _numeric_link(number: int, link: ChainLink, q: sp.Symbol, body: SymbolicBody, armature: sp.Expr) -> SymbolicLink:
    """A link of a chain with its matrix in exact numbers; the axis is known, so it contains no rounding."""
    before, after = (_exact_matrix(x.matrix()) for x in (link.before, link.after))
    motion, axis = sp.eye(4), sp.zeros(3, 1)
    if link.kind is JointKind.REVOLUTE:
        motion[:2, :2] = sp.Matrix([[sp.cos(q), -sp.sin(q)], [sp.sin(q), sp.cos(q)]])
        axis = after[:3, :3].T * sp.Matrix([0, 0, 1])
    else:
        motion[2, 3] = q
    return SymbolicLink(number, before * motion * after, q, axis, body, armature)


def _exact_matrix(matrix: Array) -> sp.Matrix:
    return sp.Matrix(matrix.shape[0], matrix.shape[1], [_exact(float(x)) for x in matrix.ravel()])


def _exact(value: float) -> sp.Expr:
    """A float as the fraction of its shortest decimal text."""
    return sp.Rational(repr(value))


def _index(arm: Arm, name: str) -> int:
    if name not in arm.joint_names:
        raise UnknownNameError("joint", name, arm.joint_names)
    return arm.joint_names.index(name)
