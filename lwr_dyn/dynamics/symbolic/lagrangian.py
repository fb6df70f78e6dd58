"""Equations of motion of a chain in symbols from its Lagrangian: a third road beside URDF and recursion.

    L = K - U,   tau_i = d/dt dL/d(dq_i) - dL/dq_i = (B ddq + C dq + g)_i

B is the Hessian of K in dq, C its Christoffel form, g the gradient of U. tau is derived from L independently, so that
tau - (B ddq + C dq + g) = 0 is a check and not a definition.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from lwr_dyn.dynamics.symbolic.link_motion import LinkMotion, SymbolicLink, Variables, link_motions
from lwr_dyn.dynamics.symbolic.trigonometry import normal_form
from lwr_dyn.foundation.errors import OptionError


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
    """The equations of motion of a chain of links.

    Parameters
    ----------
    links : sequence of SymbolicLink
        From the base outward; a link without a joint is fixed to the one before, one without a body is massless.
    gravity : (3, 1) Matrix
        In the base frame.

    Raises
    ------
    OptionError
        No link has a joint.

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
    C = normal_form(_christoffel(B, x), x.q)
    g = normal_form(sp.Matrix([U.diff(q) for q in x.q]), x.q)
    lagrange = [x.derivative(K.diff(dq)) - (K - U).diff(q) for q, dq in zip(x.q, x.dq, strict=True)]
    return EquationsOfMotion(x, motions, kinetic, potential, B, C, g, normal_form(sp.Matrix(lagrange), x.q))


def reduced_chain(
    links: Sequence[SymbolicLink], moving: Sequence[int], held: Mapping[int, sp.Expr] | None = None
) -> tuple[SymbolicLink, ...]:
    """The links of a chain in which only some joints move: held joints are fixed, links after the last are cut off.

    Parameters
    ----------
    links : sequence of SymbolicLink
        A whole arm.
    moving : sequence of int
        0-based joints that move.
    held : mapping, optional
        0-based joint -> the value it is held at; required for every other joint up to the last that is named.

    Raises
    ------
    OptionError
        A joint that does not exist, is named twice, or is not named and in between.
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


def _christoffel(B: sp.Matrix, x: Variables) -> sp.Matrix:
    """c_ij = sum_k (dB_ij/dq_k + dB_ik/dq_j - dB_jk/dq_i) dq_k / 2 (Siciliano eqs. 7.44, 7.45)."""

    def entry(i: int, j: int) -> sp.Expr:
        terms = [(B[i, j].diff(x.q[k]) + B[i, k].diff(x.q[j]) - B[j, k].diff(x.q[i])) * x.dq[k] for k in range(n)]
        return sp.Add(*terms) / 2

    n = B.rows
    return sp.Matrix(n, n, entry)
