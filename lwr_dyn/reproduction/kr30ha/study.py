"""Everything the KR 30 HA report prints, recomputed: points, matrices, envelope, equations, movement, program."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lwr_dyn.checks.verdict import Verdict, verdict_table
from lwr_dyn.files import make_folder, write_folder
from lwr_dyn.kinematics.envelope import Envelope, working_envelope
from lwr_dyn.model.arm import Arm
from lwr_dyn.papers.catalog import open_paper
from lwr_dyn.reproduction.kr30ha.cycle import Cycle, cycle
from lwr_dyn.reproduction.kr30ha.figures import figures, page_extras
from lwr_dyn.reproduction.kr30ha.krl_program import program_record, program_report, program_text, write_program
from lwr_dyn.reproduction.kr30ha.matrices import PaperMatrices, paper_matrices
from lwr_dyn.reproduction.kr30ha.planar_dynamics import FIRST_TWO, MotionReport, motion_report
from lwr_dyn.reproduction.kr30ha.points import PaperPoints, RightPoint, paper_points
from lwr_dyn.reproduction.kr30ha.text import (
    comparison_text,
    cycle_text,
    envelope_text,
    errata_text,
    matrices_text,
    points_text,
)
from lwr_dyn.reproduction.paper_study import PageExtras, Progress, Reproduction
from lwr_dyn.symbolic.equation_text import equations_latex, equations_text
from lwr_dyn.symbolic.verdicts import symbolic_verdicts
from lwr_dyn.viewer.plots import save_figure
from lwr_dyn.viewer.replay_page import write_replay
from lwr_dyn.viewer.replayed_runs import ReplayedRun, replayed_runs

SYMMETRIC = "First two joints of the arm, links symmetric about its plane (as estimated); vectors in the base frame"
TITLE = "KUKA KR 30 HA: mastering, Point 1, Point 2, mastering"
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
    found = cycle(arm, points.right)
    program = program_report(arm)
    runs = replayed_runs([found.run, program.run.to_run()], arm, ["inverse dynamics", "KRL program, corrected"])
    extras = _pictures(place, arm, points.right, runs)
    progress("KRL program")
    write_program(program, arm, make_folder(place / "program"))
    holds = all(v.holds for v in symbolic) and points.holds and matrices.holds and motion.holds and program.holds
    text = "\n\n".join(
        [
            points_text(points),
            matrices_text(matrices),
            envelope_text(envelope, arm),
            f"{SYMMETRIC}\n{equations_text(motion.symmetric.equations)}",
            verdict_table("Symbols against Pinocchio", symbolic).text(),
            comparison_text(motion),
            cycle_text(found, arm),
            program_text(program),
        ]
    )
    record = _record(points, matrices, envelope, motion, symbolic, found) | {"program": program_record(program)}
    write_folder(place, {"errata.txt": errata_text(paper) + "\n"})
    return Reproduction(holds, text, record, extras=extras)


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


def _pictures(place: Path, arm: Arm, right: Sequence[RightPoint], runs: Sequence[ReplayedRun]) -> PageExtras:
    """Write the movement, figures and the replay; what the report page shows of them."""
    plots, folder = make_folder(place / "plots"), make_folder(place / "runs")
    movement = runs[0]
    movement.run.save(folder / "mastering_p1_p2_mastering.npz")
    write_replay(place / "replay.html", [movement.run], arm, labels=[movement.label], title=TITLE)
    drawn = figures(arm, right, runs)
    for name, side_by_side in drawn.items():
        save_figure(side_by_side, plots / name, runs)
    return page_extras(arm, right, runs, [one for side_by_side in drawn.values() for one in side_by_side])


def _record(
    points: PaperPoints,
    matrices: PaperMatrices,
    envelope: Envelope,
    motion: MotionReport,
    symbolic: tuple[Verdict, ...],
    found: Cycle,
) -> dict[str, Any]:
    groups = (matrices.symbolic, matrices.numeric, matrices.products, matrices.composite)
    return {
        "points": [
            {"point": c.point, "cell": c.name, "printed": c.printed, "value": c.value, "reproduced": c.reproduced}
            | {"erratum": c.erratum or None}
            for c in points.cells
        ],
        "right": [{"point": p.name, "q": p.q, "s": p.target.s, "t": p.target.t} for p in points.right],
        "misses_mm": [
            {"point": m.name, "wrist_centre": m.wrist_miss_mm, "flange": m.flange_miss_mm} for m in points.misses
        ],
        "matrices": [
            {
                "matrix": v.name,
                "against": v.against,
                "right_entries": 16 - len(v.differing),
                "erratum": v.erratum or None,
            }
            for group in groups
            for v in group
        ],
        "envelope": {"reach": envelope.reach, "volume": envelope.volume},
        "expressions": [
            {"name": c.name, "where": c.where, "agrees": c.agrees, "errata": list(c.slips), "explained": c.explained}
            | {"difference": [str(x) for x in c.difference]}
            for c in motion.comparisons
        ],
        "planar_beside_arm": [
            {"name": c.name, "planar": str(c.planar), "arm": str(c.arm), "why_not_the_same": c.why or None}
            for c in motion.counterparts
        ],
        "equations": equations_text(motion.symmetric.equations).splitlines(),
        "symbolic": {v.name: {"value": v.value, "holds": v.holds} for v in symbolic},
        "stops": [{"at": s.name, "g": s.holding, "missed_mm": s.missed_mm} for s in found.stops],
        "peak_torque": found.peak_torque,
        "audit": found.run.meta["audit"],
    }
