"""The tables of the KR 30 HA study: every printed result beside what it should be."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.checks.datasheet.envelope import SECTION, Envelope
from lwr_dyn.dynamics.symbolic.equation_text import expression_text
from lwr_dyn.dynamics.symbolic.trigonometry import readable
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.kr30ha.cycle import RISE, SPEED_SHARE, Cycle
from lwr_dyn.reproduction.kr30ha.matrices import MatrixVerdict, PaperMatrices
from lwr_dyn.reproduction.kr30ha.planar_dynamics import Comparison, MotionReport
from lwr_dyn.reproduction.kr30ha.points import PaperPoints


def point_tables(points: PaperPoints) -> tuple[Table, ...]:
    """The points: printed digits, the true solution, and by how much the paper's angles miss."""
    recomputed, travel = Heading("recomputed", format=".6g"), Heading("travel", "deg", ".2f")
    miss = Heading("misses by", format=".1f")
    return (
        Table(
            "The report's own simplified solution, recomputed [deg; D bare]",
            ("point", "cell", "printed", recomputed, "verdict"),
            [
                (c.point, c.name, c.printed, c.value, "reproduced" if c.reproduced else f"erratum {c.erratum or '?'}")
                for c in points.cells
            ],
        ),
        Table(
            "The flange at the points with A = B = C = 0 (home: mastering), least axis travel from the one before",
            ("point", "branch", "A1 to A6 [deg]", travel, "solutions in limits", "wrist centre [mm]"),
            [
                (
                    p.name, f"S {p.target.s} T {p.target.t}", _listed(np.degrees(p.q)), p.travel_deg,
                    f"{p.inside_limits} of {p.solutions}", _listed(p.wrist_mm, 1),
                )
                for p in points.right
            ],
        ),
        Table(
            "The angles of Table 5 put through the true arm: how far wrist centre and flange miss the point [mm]",
            ("point", "read as", "wrist centre", miss, "flange", miss),
            [
                (m.name, m.reading, _listed(m.wrist_mm, 1), m.wrist_miss_mm, _listed(m.flange_mm, 1), m.flange_miss_mm)
                for m in points.misses
            ],
        ),
    )  # fmt: skip


def matrix_tables(matrices: PaperMatrices) -> list[Table]:
    """Every printed matrix: how many of its entries are right, which are not, and the erratum."""
    groups = {
        "Symbolic matrices against equation (1) with Table 2": matrices.symbolic,
        "Numeric matrices against the arm at A = 0": matrices.numeric,
        "Composites against the product of the printed factors": matrices.products,
        "Composites against the arm at A = 0": matrices.composite,
    }
    heads = ("matrix", "entries right", "differing (printed | right)", "verdict")
    return [Table(title, heads, [_matrix_row(v) for v in rows]) for title, rows in groups.items()]


def _matrix_row(v: MatrixVerdict) -> tuple[str, ...]:
    wrong = "; ".join(f"({e.row},{e.column}) {e.printed} | {e.right}" for e in v.differing)
    verdict = "right" if v.same else f"erratum {v.erratum or '?'}"
    return v.name, f"{v.right_entries} of 16", wrong or "-", f"{verdict}; it is {v.is_row}" if v.is_row else verdict


def envelope_table(envelope: Envelope, arm: Arm) -> Table:
    """Reach and volume beside the data sheet, and what these two do not count."""
    rated = arm.ratings
    rows = [
        ("reach [mm]", f"{1e3 * envelope.reach:.2f}", _rating(rated.reach, 1e3)),
        ("volume [m^3]", f"{envelope.volume:.4f}", _rating(rated.envelope_volume, 1.0)),
        ("reach behind axis 1, bent back overhead [mm]", f"{1e3 * envelope.reach_behind:.2f}", "-"),
        ("volume with what is reached overhead [m^3]", f"{envelope.volume_with_overhead:.4f}", "-"),
    ]
    return Table(
        f"Envelope of the wrist centre from geometry and limits: reach and volume {SECTION}",
        ("", "computed", "data sheet"),
        rows,
    )


def _rating(value: float | None, factor: float) -> str:
    return "-" if value is None else f"{value * factor:g}"


def motion_tables(motion: MotionReport) -> tuple[Table, ...]:
    """The report's dynamic analysis: each expression, its terms, its errata; then its model beside the arm."""
    e = motion.planar
    torques = {
        "The report's equations, which it leaves unfinished, carried to the end: from its own Lagrangian": (
            motion.printed_torques
        ),
        "and from the right one of the same planar model": e.tau,
    }
    lines = []
    for title, tau in torques.items():
        rows = enumerate(tau, start=1)
        lines += [title, *(f"  tau_{i} = {expression_text(readable(row, e.rates, e.weights))}" for i, row in rows)]
    return (
        Table(
            "The report's expressions against its own planar model done right; printed = right + the errata named",
            ("expression", "verdict", "where"),
            [(c.name, "right" if c.agrees else ", ".join(c.added), c.where) for c in motion.comparisons],
        ),
        Table(
            "Term by term where they differ",
            ("expression", "times", "printed", "right"),
            [row for c in motion.comparisons if c.printed.shape == (1, 1) and not c.agrees for row in _terms(c)],
            "\n" + "\n".join(lines),
        ),
        Table(
            "The planar model beside the arm's first joints; l1/2 = a1 + c1x, l2/2 = a2 + c2x, I1 = I1yy, I2 = I2zz",
            ("", "planar", "arm", ""),
            [(c.name, _short(c.planar), _short(c.arm), c.why or "the same") for c in motion.counterparts],
        ),
    )


def _terms(c: Comparison) -> list[tuple[str, str, str, str]]:
    differing = [row for row in c.terms() if row[1] != row[2]]
    return [(c.name, rates.replace("**", "^"), _short(printed), _short(right)) for rates, printed, right in differing]


def _short(expression: Any) -> str:
    return expression_text(readable(expression, _symbols(expression, "dq"), _symbols(expression, "I", "m")))


def _symbols(expression: Any, *starts: str) -> list[Any]:
    return sorted((s for s in expression.free_symbols if s.name.startswith(starts)), key=str)


def cycle_table(cycle: Cycle, arm: Arm) -> Table:
    """The movement: torques that hold the arm by both roads, peaks, and how near the run came."""
    rows = []
    for point in cycle.waypoints:
        a, b = point.holding.values()
        rows.append((point.name, _listed(a), np.abs(a - b).max(), point.missed_mm))
    return Table(
        f"Mastering, Point 1, Point 2, mastering in {cycle.reference.duration:.2f} s, at most {SPEED_SHARE:.0%} of"
        f" rated speed, {RISE} s to come to it (both assumed), {cycle.run.meta['controller']['label']}, estimated"
        " masses",
        (
            "at", "g(q), A1 to A6 [N m]", Heading("road A - road B", format=".1e"),
            Heading("run misses by", "mm", ".1e"),
        ),
        rows,
        f"largest |tau|, A1 to A6 [N m]: {_listed(cycle.peak_torque)}\n"
        f"largest speed over rated, A1 to A6: {_listed(cycle.peak_speed / arm.velocity, 3)}",
    )  # fmt: skip


def errata_text(paper: Paper) -> str:
    """The ledger: what is printed, how it is read, why."""
    rows = [
        f"{e.id} ({e.status}), {e.where}\n  printed: {e.printed}\n  read as: {e.read_as}\n  {e.why}"
        for e in paper.errata
    ]
    return f"Errata ({len(rows)})\n" + "\n".join(rows)


def _listed(values: Sequence[float] | Array, digits: int = 2) -> str:
    return " ".join(f"{x + 0.0:.{digits}f}" for x in np.round(values, digits))
