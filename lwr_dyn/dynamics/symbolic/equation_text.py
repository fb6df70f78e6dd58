"""Equations of motion as plain text and as a LaTeX document, term by term in the same order."""

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

import sympy as sp

from lwr_dyn.dynamics.symbolic.lagrangian import EquationsOfMotion
from lwr_dyn.dynamics.symbolic.trigonometry import terms_of

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
