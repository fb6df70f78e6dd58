"""The KR 30 HA report's KRL program: its faults, each at its line and no other, the corrected program, and its run."""

from dataclasses import dataclass
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.foundation.document import Note
from lwr_dyn.foundation.files import write_folder
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.project.program import Program, parse_program
from lwr_dyn.krl.running.program_run import ProgramRun, check_program, run_program
from lwr_dyn.krl.writing.point_program import generate_program, point_program_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.pages.replay.replay_page import write_replay
from lwr_dyn.reproduction.case import CONTRADICTION, PaperData, Proof, Prove
from lwr_dyn.reproduction.kr30ha.points import right_points
from lwr_dyn.reproduction.papers import printed_tables

NAME = "TwoPointMotionPath"

EXACT_MM = 1e-6
"""How near the flange must come to the points [mm]."""

Fault = tuple[int, str, str]
"""Line, severity, code."""


@dataclass(frozen=True, slots=True, eq=False)
class ProgramPoint:
    """A point of the program and where the run puts the flange."""

    name: str
    target_mm: tuple[float, ...]
    missed_mm: float
    s: int | None
    t: int | None


@dataclass(frozen=True, slots=True, eq=False)
class ProgramReport:
    """The printed program with its diagnosis against the faults that are known, and the right one with its run."""

    printed: tuple[Diagnostic, ...]
    missing: tuple[Fault, ...]
    """Known faults that the check did not report."""
    false: tuple[Fault, ...]
    """Diagnostics that are no faults."""
    corrected: Program
    left: tuple[Diagnostic, ...]
    """Diagnostics of the corrected program."""
    run: ProgramRun
    points: tuple[ProgramPoint, ...]
    home_missed: float
    """How far the axes end from mastering [rad]."""

    @property
    def holds(self) -> bool:
        """Every fault at its line and no false one; the right program clean, at its points and back at mastering."""
        near = all(point.missed_mm <= EXACT_MM for point in self.points)
        return not (self.missing or self.false or self.left) and near and self.home_missed <= 1e-12

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "printed": [d.to_json() for d in self.printed],
            "missed": [list(f) for f in self.missing],
            "false": [list(f) for f in self.false],
            "corrected": {
                "diagnoses": [d.to_json() for d in self.left],
                "cycle_time": self.run.cycle_time,
                "stops": [{"point": p.name, "missed_mm": p.missed_mm, "s": p.s, "t": p.t} for p in self.points],
                "home_missed_rad": self.home_missed,
            },
        }


def printed_program() -> Program:
    """The program as the report prints it."""
    return parse_program(files("lwr_dyn.reproduction.kr30ha").joinpath("program.src").read_bytes(), None, NAME)


def corrected_program(arm: Arm) -> Program:
    """The same task as a valid `.src` and `.dat`: typed points with S and T, home in axes, speeds."""
    data = printed_tables("kr30ha", "program")
    points = [{"name": p["name"], "xyz": p["xyz"], "abc": p["abc"], "wait": data["wait"]} for p in data["points"]]
    return generate_program(point_program_of({"name": NAME, "wait": data["wait"], "point": points}, arm), arm)


def program_report(arm: Arm) -> ProgramReport:
    """The report's program checked, corrected, checked again and run on the arm."""
    data, diagnostics = printed_tables("kr30ha", "program"), check_program(printed_program(), arm)
    known = {(line, f["severity"], f["code"]) for f in data["fault"] for line in f["lines"]}
    seen = {(d.position.line, str(d.severity), d.code) for d in diagnostics}
    right = corrected_program(arm)
    run = run_program(right, arm)
    moved = [(d, p) for d, p in zip(run.executed, run.poses(), strict=True) if d.kind == "PTP"]
    points = []
    for point, (_, pose) in zip(data["points"], moved, strict=False):
        off = np.array([pose.x_mm, pose.y_mm, pose.z_mm]) - point["xyz"]
        points.append(ProgramPoint(point["name"], tuple(point["xyz"]), float(np.linalg.norm(off)), pose.s, pose.t))
    return ProgramReport(
        printed=diagnostics, missing=tuple(sorted(known - seen)), false=tuple(sorted(seen - known)), corrected=right,
        left=check_program(right, arm), run=run, points=tuple(points),
        home_missed=float(np.abs(run.motion.q[-1] - np.array(arm.mastering)).max()),
    )  # fmt: skip


def write_program(report: ProgramReport, arm: Arm, folder: str | Path) -> None:
    """Write the printed and the corrected program, the diagnosis, the run and its replay; raises `FileAccessError`."""
    right = report.corrected
    assert right.data is not None
    sources = {f"{NAME}_printed.src": printed_program().source.to_bytes()}
    sources |= {one.name: one.to_bytes() for one in (right.source, right.data)}
    write_folder(folder, {"diagnosis.txt": "".join(f"{d}\n" for d in report.printed), **sources})
    run = report.run.to_run()
    run.save(Path(folder) / f"{NAME}.npz")
    write_replay(Path(folder) / "replay.html", [run], arm, title=f"KUKA KR 30 HA runs {NAME}.src")


def program_parts(report: ProgramReport) -> tuple[Note, Table]:
    """The diagnostics of the printed program, and the run of the corrected one."""
    counted = f"{len(report.printed)} diagnoses, {len(report.missing)} known faults missed, {len(report.false)} false"
    run = Table(
        f"The corrected program: {len(report.left)} diagnoses, cycle {report.run.duration:.3f} s",
        ("point", "flange [mm]", "branch", Heading("missed by", "mm", ".1e")),
        [(p.name, ", ".join(f"{x:g}" for x in p.target_mm), f"S {p.s} T {p.t}", p.missed_mm) for p in report.points],
        f"back at mastering within {report.home_missed:.1e} rad",
    )
    return Note([f"The report's program (Appendix B): {counted}", *map(str, report.printed)]), run


@cache
def _diagnoses(corrected: bool) -> tuple[Diagnostic, ...]:
    arm = arm_from_paper(open_paper("kr30ha", "kuka"))
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
                 {"lines": len(lines), "loops": len(words)}, CONTRADICTION)  # fmt: skip


DECLARATIONS = (13, 14, 15)

PROGRAM: dict[str, Prove] = {
    "krl-late-declaration": partial(diagnosed, codes=("late-declaration",), lines=DECLARATIONS),
    "krl-missing-type": partial(diagnosed, codes=("missing-type",), lines=DECLARATIONS),
    "krl-initialiser": partial(diagnosed, codes=("initialiser-in-src",), lines=DECLARATIONS),
    "krl-undeclared": partial(diagnosed, codes=("undeclared",), lines=(20,)),
    "krl-status-turn": status_turn,
    "krl-mastering-cartesian": mastering_cartesian,
    "loop-in-text": no_loop,
}
