"""Proofs of the errata in the KR 30 HA report's KRL program: the diagnostics of `check_program`, line by line."""

from functools import cache, partial

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.running.run import check_program
from lwr_dyn.reproduction.case import PaperData
from lwr_dyn.reproduction.kr30ha.krl_program import corrected_program, printed_program
from lwr_dyn.reproduction.kr30ha.points import right_points
from lwr_dyn.reproduction.ledger import Proof, Prove


@cache
def _diagnoses(corrected: bool) -> tuple[Diagnostic, ...]:
    arm = arm_from_paper(open_paper("kr30ha"))
    return check_program(corrected_program(arm) if corrected else printed_program(), arm)


def diagnosed(_: PaperData, codes: tuple[str, ...], lines: tuple[int, ...]) -> Proof:
    """The check reports this fault at exactly these lines of the printed program; the corrected program has none."""
    places = {code: tuple(sorted(d.position.line for d in _diagnoses(False) if d.code == code)) for code in codes}
    left = [d for d in _diagnoses(True) if d.code in codes]
    message = next((d.message for d in _diagnoses(False) if d.code == codes[0]), "nothing")
    return Proof(
        f"the checker says: {message}",
        all(where == lines for where in places.values()) and not left,
        {f"{code}, lines": ", ".join(map(str, where)) for code, where in places.items()},
    )


def status_turn(data: PaperData) -> Proof:
    """How many solutions the points without S and T leave inside the limits."""
    case = data.reading()
    counts = [point.inside_limits for point in right_points(case.arm, case.printed)[:2]]
    proof = diagnosed(data, ("no-status-turn",), (24, 28, 32))
    return Proof(proof.statement, proof.holds and min(counts) > 1,
                 {**proof.numbers, "solutions in limits, Point 1": counts[0], "Point 2": counts[1]})  # fmt: skip


def mastering_cartesian(data: PaperData) -> Proof:
    """The Cartesian point (0, 0, 0) against where the arm stands at mastering."""
    case = data.reading()
    flange = 1e3 * flange_pose(case.arm.chain, np.array(case.arm.mastering))[:3, 3]
    proof = diagnosed(data, ("inside-robot", "outside-limits"), (32,))
    return Proof(proof.statement, proof.holds and float(np.linalg.norm(flange)) > 1000.0,
                 {**proof.numbers, "flange at mastering from there [mm]": float(np.linalg.norm(flange))})  # fmt: skip


def no_loop(_: PaperData) -> Proof:
    """Loop keywords in the printed program."""
    lines = printed_program().source.to_bytes().decode().upper().splitlines()
    words = [w for line in lines for w in line.split(";")[0].split() if w in ("LOOP", "FOR", "WHILE", "REPEAT", "GOTO")]
    return Proof("the printed program has no loop of any kind", not words and len(lines) > 30,
                 {"lines": len(lines), "loops": len(words)})  # fmt: skip


DECLARATIONS = (13, 14, 15)
PROGRAM: dict[str, Prove] = {
    "krl-late-declaration": partial(diagnosed, codes=("late-declaration",), lines=DECLARATIONS),
    "krl-missing-type": partial(diagnosed, codes=("missing-type",), lines=DECLARATIONS),
    "krl-initialiser": partial(diagnosed, codes=("initialiser-in-src",), lines=DECLARATIONS),
    "krl-undeclared": partial(diagnosed, codes=("undeclared",), lines=(20,)),
    "krl-no-velocity": partial(diagnosed, codes=("no-velocity",), lines=(20,)),
    "krl-status-turn": status_turn,
    "krl-mastering-cartesian": mastering_cartesian,
    "loop-in-text": no_loop,
}
