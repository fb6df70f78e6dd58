"""Equations of motion of an arm in symbols, from its Lagrangian: a third road beside URDF and recursion.

    L = K - U,   tau_i = d/dt dL/d(dq_i) - dL/dq_i = (B ddq + C dq + g)_i

B is the Hessian of K in dq, C its Christoffel form, g the gradient of U. tau is derived from L independently, so that
tau - (B ddq + C dq + g) = 0 is a check and not a definition.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.dynamics.symbolic.link_motion import (
    LinkMotion,
    SymbolicBody,
    SymbolicLink,
    Variables,
    dh_matrices,
    exact_angle,
    length_values,
    link_motions,
    link_of_matrix,
    normal_form,
)
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind, first_links, lock_joint


@dataclass(frozen=True, slots=True, eq=False)
class EquationsOfMotion:
    """B ddq + C dq + g = tau in symbols, with the motions and energies behind it; all in normal form."""

    variables: Variables
    motions: tuple[LinkMotion, ...]
    kinetic_of_links: Mapping[str, sp.Expr]
    """K_i by the link's number; "a" is that of the rotors, if there are any."""
    potential_of_links: Mapping[str, sp.Expr]
    B: sp.Matrix
    C: sp.Matrix
    g: sp.Matrix
    tau: sp.Matrix

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.variables.q)

    @property
    def kinetic(self) -> sp.Expr:
        """K(q, dq) [J]."""
        return sp.Add(*self.kinetic_of_links.values())

    @property
    def potential(self) -> sp.Expr:
        """U(q) [J], zero for masses at the base origin."""
        return sp.Add(*self.potential_of_links.values())

    @property
    def rates(self) -> tuple[sp.Symbol, ...]:
        """Joint accelerations and speeds, the order in which terms are shown."""
        return (*self.variables.ddq, *self.variables.dq)

    @property
    def weights(self) -> tuple[sp.Symbol, ...]:
        """Masses, moments, products and rotor inertias: the equations are linear in them."""
        return tuple(s for s in self.parameters if s.name[0] in "mI")

    @property
    def lagrangian(self) -> sp.Expr:
        """L = K - U [J]."""
        return self.kinetic - self.potential

    @property
    def parameters(self) -> tuple[sp.Symbol, ...]:
        """All symbols except joint variables: lengths, masses, moments, gravity; sorted by name."""
        x = self.variables
        symbols = set().union(*(m.free_symbols for m in (self.kinetic, self.potential)))
        return tuple(sorted(symbols - {*x.q, *x.dq, *x.ddq}, key=lambda s: s.name))

    def residual(self) -> sp.Matrix:
        """tau from the Lagrangian less B ddq + C dq + g, (n, 1): zero if both derivations are right."""
        x = self.variables
        rest = self.tau - self.B * sp.Matrix(x.ddq) - self.C * sp.Matrix(x.dq) - self.g
        return normal_form(rest, x.q)


def euler_lagrange(links: Sequence[SymbolicLink], gravity: sp.Matrix) -> EquationsOfMotion:
    """The equations of motion of a chain of links from the base outward, with gravity (3, 1) in the base frame.

    A link without a joint is fixed to the one before, one without a body is massless. Raises `OptionError` where no
    link has a joint.

    References
    ----------
    Siciliano et al., eqs. 7.1 to 7.8, 7.45.

    >>> from lwr_dyn.dynamics.symbolic.link_motion import SymbolicBody, link_of_matrix
    >>> q, l, m, g0 = sp.symbols("q l m g0")
    >>> turn = sp.Matrix([[sp.cos(q), -sp.sin(q), 0, 0], [sp.sin(q), sp.cos(q), 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    >>> bob = SymbolicBody(m, sp.Matrix([l, 0, 0]), sp.zeros(3, 3))
    >>> euler_lagrange([link_of_matrix(1, turn, q, bob)], sp.Matrix([0, -g0, 0])).tau
    Matrix([[ddq*l**2*m + g0*l*m*cos(q)]])
    """
    x = Variables.of([link.joint for link in links if link.joint is not None])
    if not x.q:
        raise OptionError("links", "none with a joint", "at least one joint")
    motions = link_motions(links, x)
    kinetic, potential = _energies(links, motions, gravity, x)
    K, U = sp.Add(*kinetic.values()), sp.Add(*potential.values())
    B = normal_form(sp.hessian(K, x.dq), x.q)
    C = normal_form(sp.Matrix(len(x.q), len(x.q), lambda i, j: christoffel(lambda i, j: B[i, j], i, j, x)), x.q)
    g = normal_form(sp.Matrix([U.diff(q) for q in x.q]), x.q)
    lagrange = [x.derivative(K.diff(dq)) - (K - U).diff(q) for q, dq in zip(x.q, x.dq, strict=True)]
    return EquationsOfMotion(x, motions, kinetic, potential, B, C, g, normal_form(sp.Matrix(lagrange), x.q))


def reduced_chain(
    links: Sequence[SymbolicLink], moving: Sequence[int], held: Mapping[int, sp.Expr] | None = None
) -> tuple[SymbolicLink, ...]:
    """The links of an arm in which only some joints (0-based) move; `held` are fixed, links after the last are cut off.

    Every other joint up to the last that is named needs a value in `held`. Raises `OptionError` for a joint that does
    not exist, is named twice, or is not named and in between.
    """
    fixed = dict(held or {})
    named = sorted([*moving, *fixed])
    if not moving or named != list(range(len(named))) or len(named) > len(links):
        given = f"moving {[i + 1 for i in moving]}, held {[i + 1 for i in fixed]}"
        raise OptionError("joints (from 1)", given, f"1 to k, each once, k at most {len(links)}, one of them moving")
    out: list[SymbolicLink] = []
    base = sp.eye(4)
    for i in named:
        link = links[i]
        if i in fixed:
            link = replace(link, pose=link.pose.subs(link.joint, fixed[i]), joint=None, armature=sp.Integer(0))
            if not out:
                base = base * link.pose  # a link before the first moving joint is part of the base
                continue
        out.append(link if out else replace(link, pose=base * link.pose))
    return tuple(out)


def _energies(
    links: Sequence[SymbolicLink], motions: Sequence[LinkMotion], gravity: sp.Matrix, x: Variables
) -> tuple[dict[str, sp.Expr], dict[str, sp.Expr]]:
    """K_i = (m v_C^2 + omega.I omega) / 2 in the link's frame, U_i = -m g . p_C; K_a = sum Ia dq^2 / 2."""
    kinetic, potential = {}, {}
    for link, motion in zip(links, motions, strict=True):
        if link.body is None:
            continue
        v, omega = motion.velocity, motion.omega
        K = (link.body.mass * v.dot(v) + omega.dot(link.body.inertia_com * omega)) / 2
        kinetic[str(link.number)] = normal_form(K, x.q)
        U = -link.body.mass * gravity.dot(motion.position_in_base())
        potential[str(link.number)] = normal_form(U, x.q)
    spins = [(link.armature, link.joint) for link in links if link.joint is not None]
    rates = dict(zip(x.q, x.dq, strict=True))
    rotors = sum((inertia * rates[q] ** 2 / 2 for inertia, q in spins), sp.Integer(0))
    return kinetic | ({"a": rotors} if rotors != 0 else {}), potential


def christoffel(B: Callable[[int, int], sp.Expr], i: int, j: int, x: Variables) -> sp.Expr:
    """c_ij = sum_k (dB_ij/dq_k + dB_ik/dq_j - dB_jk/dq_i) dq_k / 2 (Siciliano eqs. 7.44, 7.45)."""
    rates = list(enumerate(x.dq))
    if i == j:  # half of dB_ii/dt: the other terms cancel
        return sp.Add(*(B(i, i).diff(x.q[k]) * dq for k, dq in rates)) / 2
    return sp.Add(*((B(i, j).diff(x.q[k]) + B(i, k).diff(x.q[j]) - B(j, k).diff(x.q[i])) * dq for k, dq in rates)) / 2


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
    UnknownNameError, OptionError
        No joint of that name; one that is named twice, or one in between that is neither moving nor held.
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
    before, after = (sp.Matrix(4, 4, list(map(_exact, x.matrix().ravel().tolist()))) for x in (link.before, link.after))
    motion, axis = sp.eye(4), sp.zeros(3, 1)
    if link.kind is JointKind.REVOLUTE:
        motion[:2, :2] = sp.Matrix([[sp.cos(q), -sp.sin(q)], [sp.sin(q), sp.cos(q)]])
        axis = after[:3, :3].T * sp.Matrix([0, 0, 1])
    else:
        motion[2, 3] = q
    return SymbolicLink(number, before * motion * after, q, axis, body, armature)


def _exact(value: float) -> sp.Expr:
    """A float as the fraction of its shortest decimal text."""
    return sp.Rational(repr(value))


def _index(arm: Arm, name: str) -> int:
    if name not in arm.joint_names:
        raise UnknownNameError("joint", name, arm.joint_names)
    return arm.joint_names.index(name)
