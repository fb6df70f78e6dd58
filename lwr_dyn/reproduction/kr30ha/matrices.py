"""The report's matrices entry by entry: symbolic against its own Table 2, numeric against the true arm at zero.

Equation (1) is standard DH. For each printed symbolic matrix it is also determined which row of equation (1) it is:
with the twist reversed, or another angle in place of theta_i.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.dynamics.symbolic.dh_matrices import dh_matrices
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import link_frames
from lwr_dyn.reproduction.expressions import compared
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.results import printed_tables

PLACES = [(r, c) for r in range(4) for c in range(4)]
HALF_MM = 0.5
"""Lengths are printed in whole mm; at zero every other entry is 0 or +-1."""


@dataclass(frozen=True, slots=True)
class MatrixEntry:
    """One entry of a printed matrix, 1-based, beside what it should be."""

    row: int
    column: int
    printed: str
    right: str
    same: bool


@dataclass(frozen=True, slots=True)
class MatrixVerdict:
    """One printed matrix: its sixteen entries, the erratum where one differs, and for symbols what it really is."""

    name: str
    against: str
    entries: tuple[MatrixEntry, ...]
    erratum: str = ""
    is_row: str = ""
    """Which row of equation (1) the printed symbols are: "alpha = -90, theta = q1"."""

    @property
    def same(self) -> bool:
        """All entries agree."""
        return all(entry.same for entry in self.entries)

    @property
    def differing(self) -> tuple[MatrixEntry, ...]:
        """The entries that do not."""
        return tuple(entry for entry in self.entries if not entry.same)

    @property
    def explained(self) -> bool:
        """Agrees, or an erratum explains the difference."""
        return self.same or bool(self.erratum)

    @property
    def right_entries(self) -> int:
        """How many of the sixteen agree."""
        return len(self.entries) - len(self.differing)

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        counted = {"matrix": self.name, "against": self.against, "right_entries": self.right_entries}
        return counted | {"erratum": self.erratum or None}


@dataclass(frozen=True, slots=True)
class PaperMatrices:
    """All printed matrices. `products` compares composites with the printed factors, `composite` with the true arm."""

    symbolic: tuple[MatrixVerdict, ...]
    numeric: tuple[MatrixVerdict, ...]
    products: tuple[MatrixVerdict, ...]
    composite: tuple[MatrixVerdict, ...]

    @property
    def all(self) -> tuple[MatrixVerdict, ...]:
        """The verdicts of all groups."""
        return (*self.symbolic, *self.numeric, *self.products, *self.composite)

    @property
    def holds(self) -> bool:
        """Every difference is explained."""
        return all(verdict.explained for verdict in self.all)


def paper_matrices() -> PaperMatrices:
    """Compare every matrix that the report prints."""
    tables = printed_tables("kr30ha")
    right = dh_matrices(open_paper("kr30ha", "printed"))
    symbolic = tuple(_symbolic(i, tables["symbolic"][f"A{i + 1}"], right[i]) for i in range(6))
    factors = [np.array(tables["numeric"][f"T{i + 1}"], dtype=float) for i in range(6)]
    chain = arm_from_paper(open_paper("kr30ha")).chain
    true = [_in_mm(link.pose(0.0).matrix()) for link in chain.links]
    numeric = tuple(
        _numeric(f"T{i + 1}", "equation (1) at A = 0", printed, true[i]) for i, printed in enumerate(factors)
    )
    frames = [_in_mm(frame) for frame in link_frames(chain, np.zeros(6))]
    composites = {k: np.array(tables["composite"][f"T0{k}"], dtype=float) for k in range(2, 7)}
    product = [factors[0]]
    for factor in factors[1:]:
        product.append(product[-1] @ factor)
    return PaperMatrices(
        symbolic,
        numeric,
        tuple(_numeric(f"T0{k}", "product of the printed factors", T, product[k - 1]) for k, T in composites.items()),
        tuple(_numeric(f"T0{k}", "true arm at A = 0", T, frames[k - 1]) for k, T in composites.items()),
    )


def _in_mm(matrix: Array) -> Array:
    out = matrix.copy()
    out[:3, 3] *= 1e3
    return out


def _numeric(name: str, against: str, printed: Array, right: Array) -> MatrixVerdict:
    entries = tuple(
        MatrixEntry(
            r + 1, c + 1, f"{printed[r, c]:g}", f"{right[r, c] + 0.0:.6g}", bool(abs(printed[r, c] - right[r, c]) < tol)
        )
        for (r, c), tol in ((place, HALF_MM if place[1] == 3 and place[0] < 3 else 1e-9) for place in PLACES)
    )
    verdict = MatrixVerdict(name, against, entries)
    return verdict if verdict.same else MatrixVerdict(name, against, entries, _without(name, printed))


def printed_symbols(rows: Sequence[Sequence[str]], i: int) -> sp.Matrix:
    """A printed symbolic matrix of joint i + 1: C and S read as cosine and sine of the joint's variable."""
    q = sp.Symbol(f"q{i + 1}")
    names = {f"C{i + 1}": sp.cos(q), f"S{i + 1}": sp.sin(q)}
    return sp.Matrix([[sp.sympify(cell, locals=names) for cell in row] for row in rows])


def _symbolic(i: int, rows: Sequence[Sequence[str]], right: sp.Matrix) -> MatrixVerdict:
    name, printed = f"A{i + 1}", printed_symbols(rows, i)
    entries = tuple(
        MatrixEntry(r + 1, c + 1, str(printed[r, c]), str(right[r, c]), sp.simplify(printed[r, c] - right[r, c]) == 0)
        for r, c in PLACES
    )
    same = all(entry.same for entry in entries)
    return MatrixVerdict(
        name, "equation (1), Table 2", entries, "" if same else _read_right(name, entries, rows, i), _row_of(printed, i)
    )


def _read_right(name: str, entries: Sequence[MatrixEntry], rows: Sequence[Sequence[str]], i: int) -> str:
    """The erratum that reads just the differing entries otherwise, or with which Table 2 gives the printed matrix."""
    wrong = {f"results.symbolic.{name}[{e.row - 1}][{e.column - 1}]" for e in entries if not e.same}
    for erratum in open_paper("kr30ha").errata:
        if wrong and wrong == {p.at for p in erratum.of_results() if p.at.startswith(f"results.symbolic.{name}[")}:
            return erratum.id
    for read in open_paper("kr30ha").reading.errata:
        beside = compared(rows, dh_matrices(_with([read]))[i])
        if all(entry.same for row in beside for entry in row):
            return read
    return ""


def _without(name: str, printed: Array) -> str:
    """The erratum of the reading without which the arm at A = 0 has the printed matrix."""
    own = open_paper("kr30ha").reading.errata
    for left_out in own:
        chain = arm_from_paper(_with([e for e in own if e != left_out])).chain
        single = [link.pose(0.0).matrix() for link in chain.links]
        composite = list(link_frames(chain, np.zeros(6)))
        right = {f"T{k + 1}": T for k, T in enumerate(single)} | {f"T0{k + 1}": T for k, T in enumerate(composite)}
        if np.abs(_in_mm(right[name]) - printed).max() < HALF_MM / 10:
            return left_out
    return ""


def _with(errata: Sequence[str]) -> Paper:
    """The data file with exactly these errata."""
    return paper_study("kr30ha").data.case(*errata).paper


def _row_of(printed: sp.Matrix, i: int) -> str:
    """Which alpha and theta put into equation (1) give the printed matrix; the lengths are Table 2's."""
    paper = open_paper("kr30ha", "printed")
    q = sp.Symbol(f"q{i + 1}")
    letters = [paper.columns[f"dh.{x}"].symbols[i] for x in ("a", "d")]
    a, d = (sp.Symbol(x) if x else sp.Integer(0) for x in letters)
    for alpha in (0, 90, -90):
        ca, sa = sp.cos(sp.rad(alpha)), sp.sin(sp.rad(alpha))
        for sign in (1, -1):
            for offset in (0, 90, 180, -90):
                theta = sign * q + sp.rad(offset)
                c, s = sp.cos(theta), sp.sin(theta)
                row = sp.Matrix(
                    [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
                )
                if sp.simplify(row - printed) == sp.zeros(4, 4):
                    shown = f"q{i + 1}" if sign > 0 else f"-q{i + 1}"
                    return f"alpha = {alpha} deg, theta = {shown}{f' {offset:+d} deg' if offset else ''}"
    return "no row of equation (1)"
