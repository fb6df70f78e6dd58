"""Everything the KR 30 HA report prints, recomputed: points, matrices, envelope, equations, movement, program."""

from pathlib import Path

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.checks.arm.symbolic_agreement import symbolic_verdicts
from lwr_dyn.checks.arm.verdict import verdict_table
from lwr_dyn.checks.datasheet.envelope import working_envelope
from lwr_dyn.dynamics.symbolic.equation_text import equations_latex, equations_text
from lwr_dyn.foundation.files import make_folder, write_folder
from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.kr30ha.cycle import cycle
from lwr_dyn.reproduction.kr30ha.figures import pictures
from lwr_dyn.reproduction.kr30ha.krl_program import program_report, program_tables, write_program
from lwr_dyn.reproduction.kr30ha.matrices import paper_matrices
from lwr_dyn.reproduction.kr30ha.planar_dynamics import FIRST_TWO, MotionReport, motion_report
from lwr_dyn.reproduction.kr30ha.points import paper_points
from lwr_dyn.reproduction.kr30ha.tables import (
    cycle_table,
    envelope_table,
    errata_text,
    matrix_tables,
    motion_tables,
    point_tables,
)
from lwr_dyn.reproduction.paper_study import Progress, Reproduction

SYMMETRIC = "First two joints of the arm, links symmetric about its plane (as estimated); vectors in the base frame"
GENERAL = "First two joints of the arm, any links: ten letters a link"


def run(place: Path, arm: Arm, progress: Progress) -> Reproduction:
    """Recompute the report: points, matrices, envelope, equations of motion, movement and program.

    It holds when the symbols equal Pinocchio's numbers, and each printed result is reproduced or explained by a named
    erratum.
    """
    paper = open_paper("kr30ha")
    progress("points, matrices, envelope")
    points, matrices, envelope = paper_points(), paper_matrices(), working_envelope(arm)
    progress("equations of motion")
    motion = motion_report()
    symbolic = symbolic_verdicts(arm, paper, FIRST_TWO)
    _equations(place, motion)
    progress("movement and replay")
    movement = cycle(arm, points.right)
    program = program_report(arm)
    progress("KRL program")
    write_program(program, arm, make_folder(place / "program"))
    write_folder(place, {"errata.txt": errata_text(paper) + "\n"})
    equations = equations_text(motion.symmetric.equations)
    return Reproduction(
        holds=all((points.holds, matrices.holds, motion.holds, program.holds, *(v.holds for v in symbolic))),
        tables=(
            *point_tables(points), *matrix_tables(matrices), envelope_table(envelope, arm),
            f"{SYMMETRIC}\n{equations}", verdict_table("Symbols against Pinocchio", symbolic), *motion_tables(motion),
            cycle_table(movement, arm), *program_tables(program),
        ),
        record={
            "points": [c.record() for c in points.cells],
            "right": [{"point": p.name, "q": p.q, "s": p.target.s, "t": p.target.t} for p in points.right],
            "misses_mm": [
                {"point": m.name, "wrist_centre": m.wrist_miss_mm, "flange": m.flange_miss_mm} for m in points.misses
            ],
            "matrices": [verdict.record() for verdict in matrices.all],
            "envelope": envelope.record(),
            "expressions": [c.record() for c in motion.comparisons],
            "planar_beside_arm": [
                {"name": c.name, "planar": str(c.planar), "arm": str(c.arm), "why_not_the_same": c.why or None}
                for c in motion.counterparts
            ],
            "equations": equations.splitlines(),
            "symbolic": {v.name: {"value": v.value, "holds": v.holds} for v in symbolic},
            "stops": [{"at": w.name, "g": w.holding, "missed_mm": w.missed_mm} for w in movement.waypoints],
            "peak_torque": movement.peak_torque,
            "audit": movement.run.meta["audit"],
            "program": program.record(),
        },
        pictures=pictures(arm, points.right, movement.run, program.run.to_run()),
    )  # fmt: skip


def _equations(place: Path, motion: MotionReport) -> None:
    """Text and LaTeX, for links with mirror symmetry and for any links."""
    symmetric, general = motion.symmetric.equations, motion.general.equations
    text = f"{SYMMETRIC}\n{equations_text(symmetric)}\n\n{GENERAL}\n{equations_text(general)}\n"
    write_folder(
        place,
        {
            "equations.txt": text,
            "equations.tex": equations_latex(symmetric),
            "equations_general.tex": equations_latex(general),
        },
    )
