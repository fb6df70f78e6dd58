"""The KR 30 HA report's KRL program: its faults each at its line and no other, the program put right, and its run."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.files import write_folder
from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.point_program import generate_program, point_program_of
from lwr_dyn.krl.program import Program, parse_program
from lwr_dyn.krl.run import ProgramRun, check_program, run_program
from lwr_dyn.model.arm import Arm
from lwr_dyn.tables import aligned
from lwr_dyn.viewer.replay_page import write_replay

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
    """Known faults that the check did not find."""
    false: tuple[Fault, ...]
    """What the check said and is no fault."""
    corrected: Program
    said: tuple[Diagnostic, ...]
    """Of the corrected program."""
    run: ProgramRun
    stops: tuple[ProgramPoint, ...]
    home_missed: float
    """How far the axes end from mastering [rad]."""

    @property
    def holds(self) -> bool:
        """Every fault at its line and no false one; the right program clean, at its points and back at mastering."""
        near = all(stop.missed_mm <= EXACT_MM for stop in self.stops)
        return not (self.missing or self.false or self.said) and near and self.home_missed <= 1e-12


def printed_program() -> Program:
    """The program as the report prints it."""
    return parse_program(files("lwr_dyn.reproduction.kr30ha").joinpath("program.src").read_bytes(), None, NAME)


def program_data() -> dict[str, Any]:
    """Where the program is printed, its points, and its faults."""
    return tomllib.loads(files("lwr_dyn.reproduction.kr30ha").joinpath("program.toml").read_text(encoding="utf-8"))


def corrected_program(arm: Arm) -> Program:
    """The same job as a `.src` and `.dat` that a controller takes: typed points with S and T, home in axes, speeds."""
    data = program_data()
    points = [{"name": p["name"], "xyz": p["xyz"], "abc": p["abc"], "wait": data["wait"]} for p in data["points"]]
    return generate_program(point_program_of({"name": NAME, "wait": data["wait"], "point": points}, arm), arm)


def program_report(arm: Arm) -> ProgramReport:
    """The report's program diagnosed, put right, checked and run on the arm."""
    data, found = program_data(), check_program(printed_program(), arm)
    known = {(line, f["severity"], f["code"]) for f in data["fault"] for line in f["lines"]}
    seen = {(d.position.line, str(d.severity), d.code) for d in found}
    right = corrected_program(arm)
    run = run_program(right, arm)
    moved = [(d, p) for d, p in zip(run.executed, run.poses(), strict=True) if d.kind == "PTP"]
    stops = []
    for point, (_, pose) in zip(data["points"], moved, strict=False):
        off = np.array([pose.x_mm, pose.y_mm, pose.z_mm]) - point["xyz"]
        stops.append(ProgramPoint(point["name"], tuple(point["xyz"]), float(np.linalg.norm(off)), pose.s, pose.t))
    return ProgramReport(
        printed=found, missing=tuple(sorted(known - seen)), false=tuple(sorted(seen - known)), corrected=right,
        said=check_program(right, arm), run=run, stops=tuple(stops),
        home_missed=float(np.abs(run.motion.q[-1] - np.array(arm.mastering)).max()),
    )  # fmt: skip


def write_program(report: ProgramReport, arm: Arm, folder: str | Path) -> None:
    """Write the printed and the corrected program, the diagnosis, the run and its replay; raises `FileAccessError`."""
    right = report.corrected
    assert right.data is not None
    diagnosis = "\n".join(str(d) for d in report.printed) + "\n"
    write_folder(
        folder,
        {
            f"{NAME}_printed.src": printed_program().source.to_bytes(),
            "diagnosis.txt": diagnosis,
            right.source.name: right.source.to_bytes(),
            right.data.name: right.data.to_bytes(),
        },
    )
    run = report.run.to_run()
    run.save(Path(folder) / f"{NAME}.npz")
    write_replay(Path(folder) / "replay.html", [run], arm, title=f"KUKA KR 30 HA runs {NAME}.src")


def program_text(report: ProgramReport) -> str:
    """The diagnosis of the printed program and the run of the right one, for people."""
    counted = f"{len(report.printed)} diagnoses, {len(report.missing)} known faults missed, {len(report.false)} false"
    rows = [
        (s.name, ", ".join(f"{x:g}" for x in s.target_mm), f"S {s.s} T {s.t}", f"{s.missed_mm:.1e}")
        for s in report.stops
    ]
    lines = [
        f"The report's program (Appendix B): {counted}",
        *map(str, report.printed),
        f"\nThe corrected program: {len(report.said)} diagnoses, cycle {report.run.cycle_time:.3f} s",
        aligned(rows, ("point", "flange [mm]", "branch", "missed by [mm]")),
        f"back at mastering within {report.home_missed:.1e} rad",
    ]
    return "\n".join(lines)


def program_record(report: ProgramReport) -> dict[str, Any]:
    """The same for programs."""
    return {
        "printed": [d.to_json() for d in report.printed],
        "missed": [list(f) for f in report.missing],
        "false": [list(f) for f in report.false],
        "corrected": {
            "diagnoses": [d.to_json() for d in report.said],
            "cycle_time": report.run.cycle_time,
            "stops": [{"point": s.name, "missed_mm": s.missed_mm, "s": s.s, "t": s.t} for s in report.stops],
            "home_missed_rad": report.home_missed,
        },
    }
