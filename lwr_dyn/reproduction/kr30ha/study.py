"""Everything the KR 30 HA report prints, recomputed: points, matrices, envelope, equations, movement, program."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.checks.arm.model_laws import verdict_table
from lwr_dyn.checks.datasheet.envelope import SECTION, Envelope, EnvelopeArc, working_envelope
from lwr_dyn.dynamics.symbolic.equation_forms import equations_latex, equations_text, expression_text
from lwr_dyn.dynamics.symbolic.link_motion import readable
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.document import Note
from lwr_dyn.foundation.files import make_folder, write_folder
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.figure import Curve, Figure, Panel, Series
from lwr_dyn.pages.figures.run_figures import torque_figure
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.kr30ha import planar_dynamics
from lwr_dyn.reproduction.kr30ha.krl_program import program_parts, program_report, write_program
from lwr_dyn.reproduction.kr30ha.matrices import MatrixVerdict, PaperMatrices, paper_matrices
from lwr_dyn.reproduction.kr30ha.points import RISE, SPEED_SHARE, Cycle, PaperPoints, RightPoint, cycle, paper_points
from lwr_dyn.reproduction.paper_study import Pictures, Progress, Reproduction, study_document
from lwr_dyn.reproduction.report.content import Still


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
    title = f"Envelope of the wrist centre from geometry and limits: reach and volume {SECTION}"
    return Table(title, ("", "computed", "data sheet"), rows)


def _rating(value: float | None, factor: float) -> str:
    return "-" if value is None else f"{value * factor:g}"


def motion_tables(motion: planar_dynamics.MotionReport) -> tuple[Table, ...]:
    """The report's dynamic analysis: each expression, its terms, its errata; then its model beside the arm."""
    e = motion.planar
    own = "The report's equations, which it leaves unfinished, carried to the end: from its own Lagrangian"
    lines = []
    for title, tau in ((own, motion.printed_torques), ("and from the right one of the same planar model", e.tau)):
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


def _terms(c: planar_dynamics.Comparison) -> list[tuple[str, str, str, str]]:
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
    form = "{0.id} ({0.status}), {0.where}\n  printed: {0.printed}\n  read as: {0.read_as}\n  {0.why}"
    return "\n".join([f"Errata ({len(paper.errata)})", *map(form.format, paper.errata)])


def _listed(values: Sequence[float] | Array, digits: int = 2) -> str:
    return " ".join(f"{x + 0.0:.{digits}f}" for x in np.round(values, digits))


TOUCH = 1e-6
"""[m] Ends of arcs this near to each other are one corner of the outline."""


def pictures(arm: Arm, right: Sequence[RightPoint], movement: Run, program: Run) -> Pictures:
    """Both views of the envelope, axes and torques of the movement; frames (Figure 5) and elbow up (Figure 6)."""
    label = str(movement.meta["controller"]["label"])
    shown = replayed_runs([movement, program], arm, [label, "KRL program, corrected"])
    panels = tuple(
        Panel(name, "axis", "deg", (Curve(label, Series(0, "q", j, 180.0 / np.pi)),))
        for j, name in enumerate(arm.joint_names)
    )
    return Pictures(
        simulated=((label, "mastering_p1_p2_mastering.npz", movement),),
        shown=shown,
        figures={
            "envelope": envelope_figures(arm, {p.name: p.wrist_mm / 1e3 for p in right}),
            "movement": [
                Figure("movement", "Axes over the movement", "", "time", "s", panels, over_time=True, columns=3)
            ],
            "torque": [replace(torque_figure(shown, (0,)), title="Torques of the movement, estimated masses")],
        },
        stills=(
            Still("Figure 5: DH frames, A = 0", arm, np.zeros(arm.n), "the arm stretched out, KUKA's zero"),
            Still("mastering", arm, np.array(arm.mastering), "A = (0, -90, 90, 0, 0, 0) deg"),
            *(Still(f"Figure 6: {p.name}, elbow up", arm, p.q, "flange there with A = B = C = 0") for p in right[:2]),
        ),
        title="KUKA KR 30 HA: mastering, Point 1, Point 2, mastering",
        replayed=1,
    )


def envelope_figures(arm: Arm, points: Mapping[str, ArrayLike] | None = None) -> tuple[Figure, Figure]:
    """Where the wrist centre can stand, side and top view [m], with points of the base.

    Parameters
    ----------
    arm : Arm
        Standing on its axis 1; raises as `working_envelope`.
    points : mapping of name to (3,) array_like, optional
        Wrist centres in the base [m]; in the side view at their distance from axis 1. Raises `ShapeError`.
    """
    envelope = working_envelope(arm)
    names = tuple(points or {})
    places = np.array([fixed_array(name, (points or {})[name], (3,)) for name in names]).reshape(-1, 3)
    edges = [Curve("envelope", loop[:, 1], loop[:, 0], colour=0, is_filled=True) for loop in closed_outlines(envelope)]
    turn = np.linspace(arm.lower[0], arm.upper[0], 181)
    ring = Curve("reach", -envelope.reach * np.sin(turn), envelope.reach * np.cos(turn), is_filled=True)
    low, up = np.degrees(turn[[0, -1]])

    def view(title: str, height: str, outline: Sequence[Curve], x: Array, y: Array) -> tuple[Panel]:
        centres = [Curve("wrist centre", y, x, "points", text=names)] if names else []
        return (Panel(title, height, "m", (*outline, *centres)),)

    side = view("section at any A1", "z", edges, np.hypot(*places[:, :2].T), places[:, 2])
    top = view(f"{arm.joint_names[0]} from {low:g} to {up:g} deg", "y", [ring], places[:, 0], places[:, 1])
    note = f"reach {1e3 * envelope.reach:.1f} mm, volume {envelope.volume:.3f} m^3 ahead of axis 1"
    note += f" ({envelope.volume_with_overhead:.3f} with overhead)"
    return (
        Figure("figure-3", "Working envelope, side view", "Figure 3", "distance from axis 1", "m", side,
               equal_aspect=True, note=note),
        Figure("figure-4", "Working envelope, top view", "Figure 4", "x", "m", top, equal_aspect=True),
    )  # fmt: skip


def closed_outlines(envelope: Envelope) -> tuple[Array, ...]:
    """The outline as closed polygons (m, 2) of (r, z) [m], arc after arc, joined along axis 1 where open."""
    left = list(envelope.outline)
    loops: list[Array] = []
    while left:
        arc: EnvelopeArc | None = next((each for each in left if abs(each.point(each.start)[0]) < TOUCH), left[0])
        points: list[Array] = []
        while arc is not None:
            left.remove(arc)
            points.append(arc.points())
            end = arc.point(arc.end)
            arc = next((other for other in left if math.dist(other.point(other.start), end) < TOUCH), None)
        loops.append(np.concatenate([*points, points[0][:1]]))
    return tuple(loops)


SYMMETRIC = "First two joints of the arm, links symmetric about its plane (as estimated); vectors in the base frame"

GENERAL = "First two joints of the arm, any links: ten letters a link"


def run(place: Path, arm: Arm, progress: Progress) -> Reproduction:
    """Recompute the report: points, matrices, envelope, equations of motion, movement and program.

    It holds when the symbols equal Pinocchio's numbers, and each printed result is reproduced or explained by a named
    erratum.
    """
    paper = open_paper("kr30ha", "kuka")
    progress("points, matrices, envelope")
    points, matrices, envelope = paper_points(), paper_matrices(), working_envelope(arm)
    progress("equations of motion")
    motion = planar_dynamics.motion_report()
    symbolic = planar_dynamics.symbolic_verdicts(arm, paper, planar_dynamics.FIRST_TWO)
    symmetric, general = motion.symmetric.equations, motion.general.equations
    equations = equations_text(symmetric)
    text = f"{SYMMETRIC}\n{equations}\n\n{GENERAL}\n{equations_text(general)}\n"
    latex = {"equations.tex": equations_latex(symmetric), "equations_general.tex": equations_latex(general)}
    write_folder(place, {"equations.txt": text, **latex, "errata.txt": errata_text(paper) + "\n"})
    progress("movement and replay")
    movement = cycle(arm, points.right)
    program = program_report(arm)
    progress("KRL program")
    write_program(program, arm, make_folder(place / "program"))
    return Reproduction(
        holds=all((points.holds, matrices.holds, motion.holds, program.holds, *(v.holds for v in symbolic))),
        document=study_document(
            *point_tables(points), *matrix_tables(matrices), envelope_table(envelope, arm),
            Note(f"{SYMMETRIC}\n{equations}"),
            replace(verdict_table("Symbols against Pinocchio", symbolic), key=None), *motion_tables(motion),
            cycle_table(movement, arm), *program_parts(program),
            points=[c.record() for c in points.cells],
            right=[{"point": p.name, "q": p.q, "s": p.target.s, "t": p.target.t} for p in points.right],
            misses_mm=[
                {"point": m.name, "wrist_centre": m.wrist_miss_mm, "flange": m.flange_miss_mm} for m in points.misses
            ],
            matrices=[verdict.record() for verdict in matrices.all],
            envelope=envelope.record(),
            expressions=[c.record() for c in motion.comparisons],
            planar_beside_arm=[
                {"name": c.name, "planar": str(c.planar), "arm": str(c.arm), "why_not_the_same": c.why or None}
                for c in motion.counterparts
            ],
            equations=equations.splitlines(),
            symbolic={v.name: {"value": v.value, "holds": v.holds} for v in symbolic},
            stops=[{"at": w.name, "g": w.holding, "missed_mm": w.missed_mm} for w in movement.waypoints],
            peak_torque=movement.peak_torque,
            audit=movement.run.meta["audit"],
            program=program.record(),
        ),
        pictures=pictures(arm, points.right, movement.run, program.run.to_run()),
    )  # fmt: skip
