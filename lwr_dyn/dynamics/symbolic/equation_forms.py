"""Equations of motion as numbers and as text: compiled to an engine, as plain text, as LaTeX, or one entry alone.

Compiled once they serve any masses, lengths and gravity; plain text and LaTeX have their terms in the same order. One
entry of B, C or g comes from the links' Jacobians, without what it does not need:

    B_ij = sum m Jv_i . Jv_j + Jw_i . I Jw_j + Ia_i (i = j),      g_i = -sum m g_0 . Jv_i

over the links from joint max(i, j) on, in each link's own frame; C is the Christoffel form of B.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.dynamics.protocol import Gated
from lwr_dyn.dynamics.symbolic import arm_equations
from lwr_dyn.dynamics.symbolic.arm_equations import EquationsOfMotion, christoffel
from lwr_dyn.dynamics.symbolic.link_motion import SymbolicLink, Variables, normal_form, readable, terms_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import Chain

Entries = Callable[..., Sequence[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class CompiledEquations:
    """Functions of (q, dq, ddq, parameters), scalars or batches, whose values are the entries in order."""

    equations: EquationsOfMotion
    B: Entries
    C: Entries
    g: Entries
    tau: Entries
    U: Entries

    def at(self, values: Mapping[str, float]) -> Gated[LagrangianCalls]:
        """The engine at `values`, one for every parameter of the equations; further names are ignored.

        Raises `OptionError` for a parameter without a value.
        """
        names = [s.name for s in self.equations.parameters]
        missing = [name for name in names if name not in values]
        if missing:
            raise OptionError("values", f"none for {', '.join(missing)}", f"a number for each of {', '.join(names)}")
        calls = LagrangianCalls(self, tuple(float(values[name]) for name in names))
        return Gated("euler-lagrange", self.equations.n, calls, batched=calls)


def compile_equations(equations: EquationsOfMotion) -> CompiledEquations:
    """The equations as functions of NumPy arrays, common factors computed once."""
    x = equations.variables
    symbols = [*x.q, *x.dq, *x.ddq, *equations.parameters]

    def function(entries: Any) -> Entries:
        compiled: Entries = sp.lambdify(symbols, list(entries), modules="numpy", cse=True)
        return compiled

    e = equations
    return CompiledEquations(e, function(e.B), function(e.C), function(e.g), function(e.tau), function([e.potential]))


@dataclass(frozen=True, slots=True, eq=False)
class LagrangianCalls:
    """The compiled equations with numbers for their parameters: functions of states (..., n), nothing checked."""

    compiled: CompiledEquations
    values: tuple[float, ...]

    def _entries(self, entries: Entries, axes: int, q: Any, dq: Any = None, ddq: Any = None) -> Array:
        batch, n = q.shape[:-1], q.shape[-1]
        states = [np.zeros(n) if x is None else x for x in (q, dq, ddq)]
        scalars = [x[..., i] for x in states for i in range(n)]
        rows = [np.broadcast_to(np.asarray(v, dtype=np.float64), batch) for v in entries(*scalars, *self.values)]
        return np.stack(rows, axis=-1).reshape((*batch, *(n,) * axes))

    def mass_matrix(self, q: Any) -> Array:
        """B(q), (..., n, n)."""
        return self._entries(self.compiled.B, 2, q)

    def coriolis_matrix(self, q: Any, dq: Any) -> Array:
        """C(q, dq), (..., n, n), Christoffel form."""
        return self._entries(self.compiled.C, 2, q, dq)

    def gravity_vector(self, q: Any) -> Array:
        """g(q), (..., n)."""
        return self._entries(self.compiled.g, 1, q)

    def bias_torque(self, q: Any, dq: Any) -> Array:
        """C(q, dq) dq + g(q), (..., n): the Lagrange equations without acceleration."""
        return self._entries(self.compiled.tau, 1, q, dq)

    def inverse_dynamics(self, q: Any, dq: Any, ddq: Any) -> Array:
        """tau, (..., n): the Lagrange equations."""
        return self._entries(self.compiled.tau, 1, q, dq, ddq)

    def forward_dynamics(self, q: Any, dq: Any, tau: Any) -> Any:
        """ddq = B^-1 (tau - C dq - g), (..., n)."""
        return np.linalg.solve(self.mass_matrix(q), (tau - self.bias_torque(q, dq))[..., None])[..., 0]

    def potential_energy(self, q: Any) -> Array:
        """U(q), (...)."""
        return self._entries(self.compiled.U, 0, q)


DIMENSION = {"x": 0, "y": 1, "z": 2}
_SYMBOL = re.compile(r"(?P<dots>d{0,2})(?P<letter>Ia|[A-Za-z]+?)(?P<number>\d+)(?P<axes>[xyz]*)$")

_HEAD = r"""\documentclass{article}
\usepackage{amsmath}
\usepackage[landscape,margin=15mm]{geometry}
\begin{document}
"""


class EquationLine(NamedTuple):
    """One equation: its left side as text and as LaTeX, and the terms of its right side."""

    text: str
    latex: str
    terms: list[sp.Expr]


def equations_text(equations: EquationsOfMotion, motions: bool = True) -> str:
    """Kinetic and potential energy, B, C, g and tau as text; velocities and accelerations of the links first."""
    lines = [*(_motion_lines(equations) if motions else ()), *_dynamics_lines(equations)]
    return "\n".join(f"{line.text} = {_sum([expression_text(term) for term in line.terms])}" for line in lines)


def equations_latex(equations: EquationsOfMotion, motions: bool = True) -> str:
    """The equations of `equations_text` as a LaTeX document, a line per term."""
    lines = [*(_motion_lines(equations) if motions else ()), *_dynamics_lines(equations)]
    body = []
    for line in lines:
        first, *more = [expression_latex(term) for term in line.terms]
        signed = [t if t.startswith("-") else f"+ {t}" for t in more]
        rows = [f"{line.latex} &= {first}", *(rf"&\quad {t}" for t in signed)]
        body.append("\\begin{align*}\n" + " \\\\\n".join(rows) + "\n\\end{align*}\n")
    return f"{_HEAD}{''.join(body)}\\end{{document}}\n"


def expression_text(expression: Any) -> str:
    """An expression in one line, powers as ^.

    >>> expression_text(sp.Symbol("a1") ** 2)
    'a1^2'
    """
    return str(expression).replace("**", "^")


def expression_latex(expression: Any) -> str:
    r"""An expression in LaTeX, dq1 as a dotted q, I1xy as I with its indices.

    >>> expression_latex(sp.Symbol("dq1") ** 2 * sp.Symbol("c2x"))
    'c_{2,x} \\dot{q}_{1}^{2}'
    """
    names = {symbol: _latex_symbol(symbol.name) for symbol in expression.free_symbols}
    return str(sp.latex(expression, symbol_names=names))


def _latex_symbol(name: str) -> str:
    parts = _SYMBOL.match(name)
    if parts is None:
        return str(sp.latex(sp.Symbol(name)))
    letter = "I_{a" if parts["letter"] == "Ia" else f"{parts['letter']}_{{"
    if parts["dots"]:
        command = "dot" if parts["dots"] == "d" else "ddot"
        letter = rf"\{command}{{{parts['letter']}}}_{{"
    return f"{letter}{parts['number']}{',' + parts['axes'] if parts['axes'] else ''}}}"


def _sum(terms: list[str]) -> str:
    return " + ".join(terms).replace("+ -", "- ")


def _motion_lines(e: EquationsOfMotion) -> Iterator[EquationLine]:
    """Per link, in base axes: v_C, omega, a_C, domega."""
    for motion in e.motions:
        vectors = (
            ("v_C{}", r"v_{{C{}", motion.velocity), ("omega_{}", r"\omega_{{{}", motion.omega),
            ("a_C{}", r"a_{{C{}", motion.acceleration), ("domega_{}", r"\dot{{\omega}}_{{{}", motion.domega),
        )  # fmt: skip
        for text, latex, vector in vectors:
            based = motion.in_base(vector, e.variables.q)
            for axis, i in DIMENSION.items():
                name = f"{latex.format(motion.number)},{axis}}}"
                yield EquationLine(f"{text.format(motion.number)}.{axis}", name, terms_of(based[i], e.rates, ()))


def _dynamics_lines(e: EquationsOfMotion) -> Iterator[EquationLine]:
    joints = [q.name.removeprefix("q") for q in e.variables.q]
    for letter, energies in (("K", e.kinetic_of_links), ("U", e.potential_of_links)):
        for number, energy in energies.items():
            yield EquationLine(f"{letter}_{number}", f"{letter}_{{{number}}}", terms_of(energy, e.rates, e.weights))
    for letter, matrix in (("B", e.B), ("C", e.C)):
        for i, row in enumerate(joints):
            for j, column in enumerate(joints):
                terms = terms_of(matrix[i, j], e.rates, e.weights)
                yield EquationLine(f"{letter}_{row}{column}", f"{letter}_{{{row}{column}}}", terms)
    for letter, latex, vector in (("g", "g", e.g), ("tau", r"\tau", e.tau)):
        for i, row in enumerate(joints):
            yield EquationLine(f"{letter}_{row}", f"{latex}_{{{row}}}", terms_of(vector[i], e.rates, e.weights))


LONGEST_SHORTENED = 60
"""[terms] A longer entry is printed as it is expanded: to shorten it takes minutes."""


@dataclass(frozen=True, slots=True)
class LinkColumn:
    """What a joint does to a link: velocity of the frame's origin and angular velocity, (3, 1) in the link's frame."""

    v: sp.Matrix
    w: sp.Matrix


@dataclass(frozen=True, eq=False)
class SymbolicEntries:
    """Entries of B, C and g of a chain of links, each derived when asked for."""

    links: Sequence[SymbolicLink]
    gravity: sp.Matrix
    values: Mapping[str, float]
    """Numbers of the letters."""
    _found: dict[tuple[int, int], Any] = field(default_factory=dict)

    @cached_property
    def variables(self) -> Variables:
        """Positions, speeds and accelerations of the joints."""
        return Variables.of([link.joint for link in self.links if link.joint is not None])

    @cached_property
    def columns(self) -> list[list[LinkColumn]]:
        """`columns[i][k - i]`: what joint i does to link k, 0-based."""
        return [self._column(i) for i in range(len(self.links))]

    def mass(self, i: int, j: int) -> Any:
        """B_ij, 0-based, in normal form."""
        i, j = min(i, j), max(i, j)
        if (i, j) not in self._found:
            shares = [self._share(k, i, j) for k in range(j, len(self.links))]
            rotor = self.links[i].armature if i == j else sp.S.Zero
            self._found[i, j] = normal_form(sp.Add(*shares, rotor), self.variables.q)
        return self._found[i, j]

    def coriolis(self, i: int, j: int) -> Any:
        """C_ij, 0-based, in normal form."""
        return normal_form(christoffel(self.mass, i, j, self.variables), self.variables.q)

    def weight(self, i: int) -> Any:
        """g_i, in normal form (Siciliano eq. 7.39)."""
        shares = []
        g = self.gravity
        for k, link in enumerate(self.links):
            g = normal_form(link.pose[:3, :3].T * g, self.variables.q)
            if k >= i and link.body is not None:
                shares.append(-link.body.mass * g.dot(self._centre(i, k)))
        return normal_form(sp.Add(*shares), self.variables.q)

    def text(self, letter: str, i: int, j: int = 0) -> str:
        """The right side of an entry's equation, shortened where it is not too long; 0-based."""
        x = self.variables
        entry = {"B": self.mass, "C": self.coriolis}[letter](i, j) if letter != "g" else self.weight(i)
        if len(sp.Add.make_args(entry)) > LONGEST_SHORTENED:
            return expression_text(entry)
        weights = sorted((s for s in entry.free_symbols if s.name[0] in "mI"), key=str)
        return expression_text(readable(entry, (*x.ddq, *x.dq), weights))

    def _column(self, i: int) -> list[LinkColumn]:
        q, link = self.variables.q, self.links[i]
        turn = link.pose[:3, :3].T
        here = LinkColumn(normal_form(turn * link.pose[:3, 3].diff(link.joint), q), link.axis)
        out = [here]
        for beyond in self.links[i + 1 :]:
            turn, arm = beyond.pose[:3, :3].T, beyond.pose[:3, 3]
            here = LinkColumn(normal_form(turn * (here.v + here.w.cross(arm)), q), normal_form(turn * here.w, q))
            out.append(here)
        return out

    def _centre(self, i: int, k: int) -> sp.Matrix:
        body, column = self.links[k].body, self.columns[i][k - i]
        return column.v if body is None else column.v + column.w.cross(body.com)

    def _share(self, k: int, i: int, j: int) -> Any:
        body = self.links[k].body
        if body is None:
            return sp.S.Zero
        spin = self.columns[i][k - i].w.dot(body.inertia_com * self.columns[j][k - j].w)
        return body.mass * self._centre(i, k).dot(self._centre(j, k)) + spin


def symbolic_entries(chain: Chain, paper: Paper | None = None) -> SymbolicEntries:
    """The entries of a chain, letters as in `equations_of_motion` with `keep_zeros`; a paper names its own lengths.

    Lengths are numbers where a paper has none for all of the chain.
    """
    try:
        links = arm_equations.symbolic_links(chain, paper, chain.bodies)
    except OptionError:
        links, paper = arm_equations.symbolic_links(chain, None, chain.bodies), None
    return SymbolicEntries(
        links, arm_equations.gravity_symbols(chain.gravity), arm_equations.symbol_values(chain, paper)
    )


def entry_text(robot: str | Path, entry: str, reading: str | None = None) -> str:
    """The right side of one entry's equation for a robot's name or a file, such as "B_23", "C_11" or "g_4".

    An entry that many joints take part in is long, and may take minutes. Raises as `lwr_dyn.load`, `OptionError` for no
    entry of that name, and `MissingDataError` for an arm without masses.

    >>> entry_text("lwr4plus", "B_77")
    'I7zz + Ia7'
    """
    arm, paper = load_with_paper(robot, reading)
    entries = symbolic_entries(arm.require_dynamics(), paper)
    found = named_entries(len(entries.links))
    if entry not in found:
        raise OptionError("entry", entry, "B_ij, C_ij or g_i with the joints' numbers, such as B_23")
    return entries.text(*found[entry])


def named_entries(n: int) -> dict[str, tuple[str, int, int]]:
    """Letter, row and column (from 0) of each entry of B, C and g, by its name; beyond nine joints as B_2,10.

    >>> named_entries(2)["C_21"], named_entries(2)["g_2"]
    (('C', 1, 0), ('g', 1, 0))
    """
    comma = "," if n > 9 else ""
    square = {f"{m}_{i + 1}{comma}{j + 1}": (m, i, j) for m in "BC" for i in range(n) for j in range(n)}
    return square | {f"g_{i + 1}": ("g", i, 0) for i in range(n)}
