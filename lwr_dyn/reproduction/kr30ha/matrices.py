"""The report's matrices entry by entry: symbolic against its own Table 2, numeric against the true arm at zero.

Equation (1) is standard DH. For each printed symbolic matrix it is also determined which row of equation (1) it is:
with the twist reversed, or another angle in place of theta_i.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from lwr_dyn.arms.papers.assembly import arm_from_paper, dh_rows
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.dynamics.symbolic.link_motion import dh_matrices, normal_form
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.chain import link_frames
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.model.spatial import Pose, rot_x, rot_z
from lwr_dyn.reproduction.case import PaperCase, PaperData, Proof, Prove
from lwr_dyn.reproduction.compare import compared, value_of
from lwr_dyn.reproduction.kr30ha.formulas import IN_MM, POINTS, envelope, pose_misses, symbolic_matrices
from lwr_dyn.reproduction.kr30ha.krl_program import PROGRAM
from lwr_dyn.reproduction.kr30ha.planar_dynamics import MOTION
from lwr_dyn.reproduction.kr30ha.points import wrist_centre_mm
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import printed_tables

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
        return all(verdict.same or verdict.erratum for verdict in self.all)


def paper_matrices() -> PaperMatrices:
    """Compare every matrix that the report prints."""
    tables = printed_tables("kr30ha")
    right = dh_matrices(open_paper("kr30ha", "printed"))
    factors = [np.array(tables["numeric"][f"T{i + 1}"], dtype=float) for i in range(6)]
    chain = arm_from_paper(open_paper("kr30ha", "kuka")).chain
    true = [IN_MM * link.pose(0.0).matrix() for link in chain.links]
    frames = [IN_MM * frame for frame in link_frames(chain, np.zeros(6))]
    composites = {k: np.array(tables["composite"][f"T0{k}"], dtype=float) for k in range(2, 7)}
    product = list(itertools.accumulate(factors, np.matmul))
    return PaperMatrices(
        tuple(_symbolic(i, tables["symbolic"][f"A{i + 1}"], right[i]) for i in range(6)),
        tuple(_numeric(f"T{i + 1}", "equation (1) at A = 0", T, true[i]) for i, T in enumerate(factors)),
        tuple(_numeric(f"T0{k}", "product of the printed factors", T, product[k - 1]) for k, T in composites.items()),
        tuple(_numeric(f"T0{k}", "true arm at A = 0", T, frames[k - 1]) for k, T in composites.items()),
    )


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
    beyond = normal_form(printed - right, [sp.Symbol(f"q{i + 1}")])
    entries = tuple(
        MatrixEntry(r + 1, c + 1, str(printed[r, c]), str(right[r, c]), beyond[r, c] == 0) for r, c in PLACES
    )
    same = all(entry.same for entry in entries)
    return MatrixVerdict(
        name, "equation (1), Table 2", entries, "" if same else _read_right(name, entries, rows, i), _row_of(printed, i)
    )


def _read_right(name: str, entries: Sequence[MatrixEntry], rows: Sequence[Sequence[str]], i: int) -> str:
    """The erratum that reads just the differing entries otherwise, or with which Table 2 gives the printed matrix."""
    wrong = {f"results.symbolic.{name}[{e.row - 1}][{e.column - 1}]" for e in entries if not e.same}
    for erratum in open_paper("kr30ha", "kuka").errata:
        if wrong and wrong == {p.at for p in erratum.of_results() if p.at.startswith(f"results.symbolic.{name}[")}:
            return erratum.id
    for read in open_paper("kr30ha", "kuka").reading.errata:
        beside = compared(rows, dh_matrices(_with([read]))[i].tolist())
        if all(entry.same for row in beside for entry in row):
            return read
    return ""


def _without(name: str, printed: Array) -> str:
    """The erratum of the reading without which the arm at A = 0 has the printed matrix."""
    own = open_paper("kr30ha", "kuka").reading.errata
    for left_out in own:
        chain = arm_from_paper(_with([e for e in own if e != left_out])).chain
        single = [link.pose(0.0).matrix() for link in chain.links]
        composite = list(link_frames(chain, np.zeros(6)))
        right = {f"T{k + 1}": T for k, T in enumerate(single)} | {f"T0{k + 1}": T for k, T in enumerate(composite)}
        if np.abs(IN_MM * right[name] - printed).max() < HALF_MM / 10:
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
    for alpha, sign, offset in itertools.product((0, 90, -90), (1, -1), (0, 90, 180, -90)):
        theta = sign * q + sp.rad(offset)
        (c, s), (ca, sa) = ((sp.cos(x), sp.sin(x)) for x in (theta, sp.rad(alpha)))
        row = sp.Matrix(equation_1(c, s, ca, sa, a, d))
        if normal_form(row - printed, [q]) == sp.zeros(4, 4):
            return f"alpha = {alpha} deg, theta = {sign * q}{f' {offset:+d} deg' if offset else ''}"
    return "no row of equation (1)"


def equation_1(c: Any, s: Any, ca: Any, sa: Any, a: Any, d: Any) -> list[list[Any]]:
    """The report's equation (1) with cosine and sine of theta and alpha: standard DH."""
    return [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]


OFFSET, HALF_TURN, SIGNS = "table2-offset", "table2-half-turn", "kuka-signs"


def table2_offset(data: PaperData) -> Proof:
    """The wrist centre at mastering with the offset on theta_2 and on theta_3, against the report's own home."""
    home = np.array(data.case().numbers("home_position", "table_4"))
    arms = (data.case(*ids).arm for ids in ((HALF_TURN, SIGNS), (OFFSET, HALF_TURN, SIGNS)))
    misses = [float(np.linalg.norm(wrist_centre_mm(arm, np.array(arm.mastering)) - home)) for arm in arms]
    return Proof(
        "with KUKA's axes at mastering the wrist stands where Table 4 has home only if the 90 deg belong to theta_3",
        misses[1] < 1e-6 and misses[0] > 500.0,
        {"missed as printed [mm]": misses[0], "as read [mm]": misses[1]},
    )


def half_turn(data: PaperData) -> Proof:
    """T_TCP^5: the symbolic matrix against theta_6 + 180 deg; KUKA's A, B, C of the flange at zero."""
    differing = [_differing(data.case(*ids), ("A6",)) for ids in ((), (HALF_TURN,))]
    numeric = np.array(data.case().printed["numeric"]["T6"], dtype=float)[:3, :3]
    turns = [
        float(pose_misses(c, c.block("pose_misses"))["turn"][0]) for c in (data.case(OFFSET, SIGNS), data.reading())
    ]
    return Proof(
        "the symbolic T_TCP^5 is that of theta_6 + 180 deg and the numeric one that of theta_6; the flange at zero is"
        " turned as KUKA's only with it",
        differing == [4, 0] and np.array_equal(numeric, np.eye(3)) and turns[0] > 1.0 and turns[1] < 1e-9,
        {"symbolic entries that differ without": differing[0], "with": differing[1],
         "turn missed without": turns[0], "turn missed with": turns[1]},
    )  # fmt: skip


def _differing(case: PaperCase, names: tuple[str, ...]) -> int:
    """How many entries of printed symbolic matrices are not those of Table 2."""
    matrices = symbolic_matrices(case, case.block("symbolic"))
    return sum(not entry.same for name in names for row in matrices[name] for entry in row)


def kuka_signs(data: PaperData) -> Proof:
    """Axes at zero and the volume of the envelope with theta_i = A_i and theta_i = -A_i."""
    plus, minus = data.case(OFFSET, HALF_TURN), data.reading()
    axes = [float(np.max(pose_misses(c, c.block("pose_misses"))["axis"])) for c in (plus, minus)]
    volumes = [envelope(c, c.block("appendix_a"))["volume"][0] for c in (plus, minus)]
    sheet = data.case().printed["appendix_a"]["volume"][0]
    return Proof(
        "with theta_i = -A_i axes turn as KUKA's do and the ranges of Appendix A sweep its volume; with a plus neither",
        axes[0] > 1.0 and axes[1] < 1e-6 and agrees(sheet, volumes[1]) and not agrees(sheet, volumes[0]),
        {"volume with plus [m^3]": volumes[0], "with minus [m^3]": volumes[1], "Appendix A": sheet},
    )


def symbolic_signs(data: PaperData) -> Proof:
    """Symbolic A_1, A_3, A_4, A_5 against equation (1) with Table 2, entry by entry."""
    names = ("A1", "A3", "A4", "A5")
    counts = [_differing(data.case(*ids), names) for ids in ((), ("symbolic-signs",))]
    return Proof("twelve entries have the sign of the other twist; so read all are equation (1)", counts == [12, 0],
                 {"entries that differ as printed": counts[0], "as read": counts[1]})  # fmt: skip


def symbolic_a2(data: PaperData) -> Proof:
    """Symbolic T_2^1 against equation (1) at theta_2 + 90 deg, at 90 deg - theta_2, and as read."""
    counts = [_differing(data.case(*ids), ("A2",)) for ids in ((), ("symbolic-a2",))]
    printed = data.case().printed["symbolic"]["A2"]
    turned = rot_z(math.pi / 2 - value_of("q2", 0))[:2, :2]
    rotation = np.array([[value_of(text, 0) for text in row[:2]] for row in printed[:2]])
    return Proof(
        "three entries differ from theta_2 + 90 deg; the printed rotation is that of 90 deg - theta_2",
        counts == [3, 0] and float(np.abs(rotation - turned).max()) < 1e-12,
        {"entries that differ as printed": counts[0], "as read": counts[1]},
    )


def composition_order(data: PaperData) -> Proof:
    """T_1^0 as Trans x Trans z Rot x Rot z and as Rot z Trans z Trans x Rot x, against equation (1)."""
    row, theta = dh_rows(data.case().geometry)[0], 0.4
    c, s, ca, sa = math.cos(theta), math.sin(theta), math.cos(row.alpha), math.sin(row.alpha)
    equation = np.array(equation_1(c, s, ca, sa, row.a, row.d))
    x, z = (Pose(np.eye(3), np.array(place)) for place in ([row.a, 0.0, 0.0], [0.0, 0.0, row.d]))
    twist, turn = (Pose(rotation, np.zeros(3)) for rotation in (rot_x(row.alpha), rot_z(theta)))
    printed, read = x @ z @ twist @ turn, turn @ z @ x @ twist
    misses = [float(np.abs(product.matrix() - equation).max()) for product in (printed, read)]
    return Proof("only Rot z, Trans z, Trans x, Rot x is equation (1)", misses[0] > 0.1 and misses[1] < 1e-12,
                 {"largest difference as printed": misses[0], "as read": misses[1]})  # fmt: skip


def mastering_transform(data: PaperData) -> Proof:
    """The flange at A = 0 and at mastering, against the printed T_TCP^0."""
    case = data.reading()
    printed = np.array(case.numbers("mastering_flange", "position"))
    at = [1e3 * flange_pose(case.arm.chain, q)[:3, 3] for q in (np.zeros(6), np.array(case.arm.mastering))]
    misses = [float(np.linalg.norm(place - printed)) for place in at]
    return Proof("the printed transform is that of A = 0", misses[0] < 1e-6 and misses[1] > 1000.0,
                 {"missed at A = 0 [mm]": misses[0], "missed at mastering [mm]": misses[1]})  # fmt: skip


PROOFS: dict[str, Prove] = {
    "table2-offset": table2_offset,
    "table2-half-turn": half_turn,
    "kuka-signs": kuka_signs,
    "symbolic-signs": symbolic_signs,
    "symbolic-a2": symbolic_a2,
    "composition-order": composition_order,
    "mastering-transform": mastering_transform,
    **POINTS,
    **MOTION,
    **PROGRAM,
}
