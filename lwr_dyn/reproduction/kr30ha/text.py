"""The KR 30 HA report as text: every printed result beside what it should be."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.envelope import Envelope
from lwr_dyn.model.arm import Arm
from lwr_dyn.papers.schema import Paper
from lwr_dyn.reproduction.kr30ha.cycle import RISE, SPEED_SHARE, Cycle
from lwr_dyn.reproduction.kr30ha.matrices import MatrixVerdict, PaperMatrices
from lwr_dyn.reproduction.kr30ha.planar_dynamics import Comparison, MotionReport
from lwr_dyn.reproduction.kr30ha.points import PaperPoints, RightPoint
from lwr_dyn.symbolic.equation_text import expression_text
from lwr_dyn.symbolic.trigonometry import readable
from lwr_dyn.tables import aligned


def points_text(found: PaperPoints) -> str:
    """The points: printed digits, the true solution, and by how much the paper's angles miss."""
    cells = [
        (c.point, c.name, c.printed, f"{c.value:.6g}", "reproduced" if c.reproduced else f"erratum {c.erratum or '?'}")
        for c in found.cells
    ]
    right = [
        (p.name, f"S {p.target.s} T {p.target.t}", _degrees(p.q), f"{p.travel_deg:.2f}", *_counted(p))
        for p in found.right
    ]
    misses = [
        (m.name, m.reading, _mm(m.wrist_mm), f"{m.wrist_miss_mm:.1f}", _mm(m.flange_mm), f"{m.flange_miss_mm:.1f}")
        for m in found.misses
    ]
    return "\n".join(
        [
            "The report's own simplified solution, recomputed [deg; D bare]",
            aligned(cells, ("point", "cell", "printed", "recomputed", "verdict")),
            "\nThe flange at the points with A = B = C = 0 (home: mastering), least axis travel from the one before",
            aligned(
                right, ("point", "branch", "A1 to A6 [deg]", "travel [deg]", "solutions in limits", "wrist centre [mm]")
            ),
            "\nThe angles of Table 5 put through the true arm: how far wrist centre and flange miss the point [mm]",
            aligned(misses, ("point", "read as", "wrist centre", "misses by", "flange", "misses by")),
        ]
    )


def _counted(point: RightPoint) -> tuple[str, str]:
    return f"{point.inside_limits} of {point.solutions}", _mm(point.wrist_mm)


def matrices_text(found: PaperMatrices) -> str:
    """Every printed matrix: how many of its entries are right, which are not, and the erratum."""
    groups = {
        "ComparedExpression matrices against equation (1) with Table 2": found.symbolic,
        "Numeric matrices against the arm at A = 0": found.numeric,
        "Composites against the product of the printed factors": found.products,
        "Composites against the arm at A = 0": found.composite,
    }
    head = ("matrix", "entries right", "differing (printed | right)", "verdict")
    return "\n\n".join(f"{title}\n{aligned([_matrix_row(v) for v in rows], head)}" for title, rows in groups.items())


def _matrix_row(v: MatrixVerdict) -> tuple[str, ...]:
    wrong = "; ".join(f"({e.row},{e.column}) {e.printed} | {e.right}" for e in v.differing)
    verdict = "right" if v.same else f"erratum {v.erratum or '?'}"
    return (
        v.name,
        f"{16 - len(v.differing)} of 16",
        wrong or "-",
        f"{verdict}{f'; it is {v.is_row}' if v.is_row else ''}",
    )


def envelope_text(found: Envelope, arm: Arm) -> str:
    """Reach and volume beside the data sheet."""
    rated = arm.ratings
    rows = [
        ("reach [mm]", f"{1e3 * found.reach:.2f}", _sheet(rated.reach, 1e3)),
        ("volume [m^3]", f"{found.volume:.4f}", _sheet(rated.envelope_volume, 1.0)),
    ]
    return f"Envelope of the wrist centre from geometry and limits\n{aligned(rows, ('', 'computed', 'data sheet'))}"


def _sheet(value: float | None, factor: float) -> str:
    return "-" if value is None else f"{value * factor:g}"


def comparison_text(found: MotionReport) -> str:
    """The report's dynamic analysis: each expression, its terms, its slips; then its model beside the arm."""
    rows = [(c.name, "right" if c.agrees else ", ".join(c.slips), c.where) for c in found.comparisons]
    terms = [line for c in found.comparisons if c.printed.shape == (1, 1) and not c.agrees for line in _terms(c)]
    beside = [(c.name, _short(c.planar), _short(c.arm), c.why or "the same") for c in found.counterparts]
    return "\n".join(
        [
            "The report's expressions against its own planar model done right; printed = right + the slips named",
            aligned(rows, ("expression", "verdict", "where")),
            "\nTerm by term where they differ",
            aligned(terms, ("expression", "times", "printed", "right")),
            "\nThe report's equations, which it leaves unfinished, carried to the end: from its own Lagrangian",
            *_torques(found.printed_torques, found),
            "and from the right one of the same planar model",
            *_torques(found.planar.tau, found),
            "\nThe planar model beside the arm's first joints; l1/2 = a1 + c1x, l2/2 = a2 + c2x, I1 = I1yy, I2 = I2zz",
            aligned(beside, ("", "planar", "arm", "")),
        ]
    )


def _terms(c: Comparison) -> list[tuple[str, str, str, str]]:
    differing = [row for row in c.terms() if row[1] != row[2]]
    return [(c.name, rates.replace("**", "^"), _short(printed), _short(right)) for rates, printed, right in differing]


def _torques(tau: Iterable[Any], found: MotionReport) -> list[str]:
    e = found.planar
    return [f"  tau_{i} = {expression_text(readable(row, e.rates, e.weights))}" for i, row in enumerate(tau, start=1)]


def _short(expression: Any) -> str:
    rates = [*_symbols(expression, "dq")]
    return expression_text(readable(expression, rates, _symbols(expression, "I", "m")))


def _symbols(expression: Any, *starts: str) -> list[Any]:
    return sorted((s for s in expression.free_symbols if s.name.startswith(starts)), key=str)


def cycle_text(found: Cycle, arm: Arm) -> str:
    """The movement: torques that hold the arm by both roads, peaks, and how near the run came."""
    rows = []
    for stop in found.stops:
        a, b = stop.holding.values()
        rows.append((stop.name, _numbers(a), f"{np.abs(a - b).max():.1e}", f"{stop.missed_mm:.1e}"))
    share = found.peak_speed / arm.velocity
    return "\n".join(
        [
            f"Mastering, Point 1, Point 2, mastering in {found.reference.duration:.2f} s, at most {SPEED_SHARE:.0%} of"
            f" rated speed, {RISE} s to come to it (both assumed), inverse dynamics, estimated masses",
            aligned(rows, ("at", "g(q), A1 to A6 [N m]", "road A - road B", "run misses by [mm]")),
            f"largest |tau|, A1 to A6 [N m]: {_numbers(found.peak_torque)}",
            f"largest speed over rated, A1 to A6: {_numbers(share, 3)}",
        ]
    )


def errata_text(paper: Paper) -> str:
    """The ledger: what is printed, how it is read, why."""
    rows = [
        f"{e.id} ({e.status}), {e.where}\n  printed: {e.printed}\n  read as: {e.read_as}\n  {e.why}"
        for e in paper.errata
    ]
    return f"Errata ({len(rows)})\n" + "\n".join(rows)


def _degrees(q: Array) -> str:
    return " ".join(f"{x + 0.0:.2f}" for x in np.degrees(q).round(2))


def _mm(point: Array) -> str:
    return " ".join(f"{x + 0.0:.1f}" for x in point.round(1))


def _numbers(values: Sequence[float] | Array, digits: int = 2) -> str:
    return " ".join(f"{x + 0.0:.{digits}f}" for x in np.round(values, digits))
