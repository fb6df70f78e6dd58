"""Which public KRL programs with motion run one pass, with all their motions, to a cycle time.

    python scripts/studies/krl_runs.py FOLDER [--runs scripts/studies/krl_runs.toml] [--only GLOB] [--out FILE]

FOLDER is that of `krl_programs.py`. `krl_runs.toml` has a row for each robot: its machine data, one cell file, and the
programs that it drives. A program counts as run where no error ends it, no bound of steps or time does, and five
motions or more were planned; what was assumed on the way is listed by the run. The robots of most repositories are not
known: then a robot that reaches all points was taken, which is an assumption too. No cycle time is compared with a
KUKA's: there is none to compare with. A run is whole where each motion statement of its file was carried out, but those
behind a jump that no way leads to (`krl_reach.py`).
"""

from __future__ import annotations

import argparse
import re
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from lwr_dyn.arms.loading import load  # noqa: E402
from lwr_dyn.foundation.errors import LwrDynError  # noqa: E402
from lwr_dyn.krl.project.program import load_program  # noqa: E402
from lwr_dyn.krl.running.cell import read_cell, with_cell  # noqa: E402
from lwr_dyn.krl.running.controller import MachineData  # noqa: E402
from lwr_dyn.krl.running.program_run import (  # noqa: E402
    ProgramError,
    ProgramRun,
    run_program,
)
from scripts.studies.krl_programs import program_paths  # noqa: E402
from scripts.studies.krl_reach import reachable_lines  # noqa: E402

HERE = Path(__file__).parent
MOTION = re.compile(rb"(?i)[ \t]*(S?PTP|S?LIN|S?CIRC|SPL|(PTP|LIN|CIRC)_REL)\b")
FEWEST = 5
"""Motions of a run that counts."""
MACHINE = MachineData(steps=200_000, seconds=3600.0, passes=3)


MOVES = ("PTP", "LIN", "CIRC", "SPTP", "SLIN", "SCIRC", "SPL")
"""How the kinds of rows begin that move the arm."""


@dataclass(frozen=True, slots=True)
class TriedRun:
    """A program that was run: its motions and time, or why not."""

    program: str
    robot: str
    statements: int = 0
    """Motion statements of its file that some way leads to."""
    reached: int = 0
    """Of these, those that were carried out."""
    motions: int = 0
    seconds: float = 0.0
    known: float = 0.0
    """[s] The same with everything known ahead."""
    a_pass: float | None = None
    """[s] Of one pass of an endless loop."""
    assumptions: int = 0
    fault: str = ""

    @property
    def whole(self) -> bool:
        """Whether every motion statement of its file that some way leads to was carried out."""
        return self.counts and self.reached == self.statements

    @property
    def counts(self) -> bool:
        """Whether it ran one pass with motions enough."""
        return not self.fault and self.motions >= FEWEST


def motion_lines(path: Path) -> set[int]:
    """The lines of a file that hold a motion statement and that some way of the program leads to."""
    lines = {i for i, line in enumerate(path.read_bytes().splitlines(), 1) if MOTION.match(line)}
    return lines & reachable_lines(load_program(path))


def tried(folder: Path, path: Path, row: dict[str, Any]) -> TriedRun:
    """Run one program in its repository."""
    name = path.relative_to(folder).as_posix()
    machine = row.get("machine", "")
    robot = str(folder / machine) if machine and (folder / machine).exists() else str(HERE / machine)
    try:
        cell = read_cell(HERE / row["cell"])
        arm = load(robot if machine else cell.robot or "")
        program = with_cell(load_program(path, [folder / name.split("/")[0]]), cell)
        run = run_program(program, arm, MACHINE, cell=cell)
    except ProgramError as fault:
        return TriedRun(name, row["name"], len(motion_lines(path)), fault=f"{fault.code}: {fault}")
    except LwrDynError as fault:
        return TriedRun(name, row["name"], len(motion_lines(path)), fault=f"{type(fault).__name__}: {fault}")
    return _of_run(name, row["name"], run, motion_lines(path))


def _of_run(name: str, robot: str, run: ProgramRun, lines: set[int]) -> TriedRun:
    moves = [x for x in run.executed if x.kind.startswith(MOVES)]  # waits and stops are rows too
    places = [*(x.position for x in moves), *run.still]
    reached = lines & {x.line for x in places if x.file == run.program}
    fault = next((f"{d.code}: {d}" for d in run.diagnostics if d.code == "bound"), "")
    a_pass = None if run.passes is None else run.passes.cycle_time
    if a_pass is not None and (not moves or moves[-1].end <= run.duration - a_pass):
        fault = f"idle: its endless loop waits only, after {len(moves)} motions"
    return TriedRun(
        name, robot, len(lines), len(reached), len(moves), run.duration, run.times().known, a_pass,
        len(run.assumptions), fault,
    )  # fmt: skip


def chosen(folder: Path, rows: Sequence[dict[str, Any]], only: str) -> Iterator[tuple[Path, dict[str, Any] | None]]:
    """Each program with motion statements, and the row of its robot."""
    for path in program_paths(folder):
        name = path.relative_to(folder).as_posix()
        if motion_lines(path) and fnmatch(name, only):
            yield path, next((row for row in rows if any(fnmatch(name, x) for x in row["programs"])), None)


def _figures(x: TriedRun) -> str:
    a_pass = "" if x.a_pass is None else f", {x.a_pass:.2f} s a pass"
    lines = f"{x.motions} motions, {x.reached} of {x.statements} lines"
    return f"{lines}, {x.seconds:.2f} s ({x.known:.2f} s), {x.assumptions} assumed{a_pass}"


def table(runs: Sequence[TriedRun], without: int) -> str:
    """A line for each program, then the sums."""
    lines = []
    for x in runs:
        lines.append(f"{'ran ' if x.counts else '    '}{x.robot:12s} {x.program}: {x.fault[:150] or _figures(x)}")
    faults = Counter(x.fault.split(":")[0] for x in runs if x.fault)
    lines.append(
        f"{sum(x.counts for x in runs)} of {len(runs)} ran with {FEWEST} motions or more; {without} without a robot"
    )
    lines.append(
        f"{sum(x.whole for x in runs)} of them carried out every motion statement that some way of their file leads to"
    )
    return "\n".join([*lines, *(f"  {n:4d} {code}" for code, n in faults.most_common())])


def as_toml(runs: Sequence[TriedRun]) -> str:
    """The runs that count, as rows."""
    out = []
    for x in runs:
        if x.counts:
            out += [
                "[[run]]",
                f'program = "{x.program}"',
                f'robot = "{x.robot}"',
                f"motions = {x.motions}",
                f"reached = {[x.reached, x.statements]}",
            ]
            out += [f"seconds = {x.seconds:.3f}", f"known = {x.known:.3f}"]
            out += [f"a_pass = {x.a_pass:.3f}"] if x.a_pass is not None else []
            out += [f"assumed = {x.assumptions}", ""]
    return "\n".join(out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--runs", type=Path, default=Path(__file__).with_suffix(".toml"))
    parser.add_argument("--only", default="*", help="programs whose path fits")
    parser.add_argument("--out", type=Path, help="write the runs that count")
    given = parser.parse_args()
    rows = tomllib.loads(given.runs.read_text(encoding="utf-8"))["robot"]
    runs, without = [], 0
    for path, row in chosen(given.folder, rows, given.only):
        if row is None:
            without += 1
            continue
        start = time.perf_counter()
        runs.append(tried(given.folder, path, row))
        print(f"{time.perf_counter() - start:6.1f} s {runs[-1].program}", file=sys.stderr)
    print(table(runs, without))
    if given.out is not None:
        given.out.write_text(as_toml(runs), encoding="utf-8")


if __name__ == "__main__":
    main()
