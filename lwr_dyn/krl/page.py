"""One HTML file that replays a run with its program beside the arm: the line that moves it now is marked.

It is the page of any replay, with the program's lines and, for each motion, its line and time in addition.
"""

from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.files import write_file
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.krl.language.source import SourceFile
from lwr_dyn.krl.project.program import Program
from lwr_dyn.krl.running.program_run import ProgramRun
from lwr_dyn.pages.replay.replay_page import pack_int32, page_data, player_page
from lwr_dyn.pages.replay.replayed_runs import replayed_runs

MOST = 20_000
"""Motions, and events, of a run whose lines the page marks; of a longer run the first ones."""
SPEEDS = 2000
"""Most points of the curve of speed."""


def program_html(run: ProgramRun, program: Program) -> str:
    """The page; the same run gives the same text.

    Parameters
    ----------
    run : ProgramRun
    program : Program
        The program that was run.
    """
    shown = replayed_runs([run.to_run()], run.arm, [run.program])
    title = f"{run.program} on {run.arm.name}"
    start = {"trace": True, "frames": False, "beside": False}
    data = page_data(shown) | {"title": title, "live": False, "start": start, "program": program_data(run, program)}
    return player_page(title, data, own=("program.css", "program.js", "speed.js"), of="lwr_dyn.krl")


def write_program_page(path: str | Path, run: ProgramRun, program: Program) -> None:
    """Write `program_html(run, program)` to a file; raises `FileAccessError`."""
    write_file(path, program_html(run, program))


def program_data(run: ProgramRun, program: Program) -> dict[str, Any]:
    """The lines of each file in which something happens; each motion and each event with its file and line from 1."""
    used = {x.position.file for x in run.executed} | {x.position.file for x in run.events}
    files = [file for file in (program.source, *program.included) if file.name in used or file is program.source]
    place = {file.name: i for i, file in reversed(list(enumerate(files)))}
    motions = [x for x in run.executed[:MOST] if x.position.file in place]
    events = [x for x in run.events[:MOST] if x.position.file in place]
    passes = [] if run.passes is None else [f"{run.passes.cycle_time:.3f} s a pass"]
    of_pass = [] if (times := run.pass_times()) is None else times.lines(" of a pass")
    count = f"{len(run.executed)} motions and pauses"
    return {
        "files": [
            {"name": file.name, "lines": [x.shown.expandtabs(4).rstrip() for x in file.lines], "says": _says(run, file)}
            for file in files
        ],
        "motions": [
            [place[x.position.file], x.position.line, round(x.begin, 6), round(x.end, 6), x.kind] for x in motions
        ],
        "events": [[place[x.position.file], x.position.line, round(x.time, 6), x.text] for x in events],
        "left_out": max(0, len(run.executed) - MOST),
        "assumed": [*run.times().lines(), *of_pass, *map(str, run.assumptions)],
        "about": [f"{run.duration:.3f} s" + (" (cut)" if run.cut else ""), *passes, count, f"robot {run.arm.name}"],
        "speed": _flange_speed(run),
    }


def _flange_speed(run: ProgramRun) -> dict[str, Any]:
    """The speed of the flange over time [m/s], of each interval of time its largest, at most `SPEEDS` of them."""
    t = run.motion.t
    if t.size < 2:
        return {"t": pack_int32(t), "values": pack_int32(np.zeros(t.size))}
    place = flange_pose(run.arm.chain, run.motion.q)[:, :3, 3]
    speed = np.linalg.norm(np.diff(place, axis=0), axis=1) / np.diff(t)
    begins = np.arange(0, speed.size, -(-speed.size // SPEEDS))
    largest = np.maximum.reduceat(speed, begins)
    return {"t": pack_int32(0.5 * (t[:-1] + t[1:])[begins]), "values": pack_int32(largest)}


def _says(run: ProgramRun, file: SourceFile) -> dict[int, list[str]]:
    """The warnings of the run by line."""
    says: dict[int, list[str]] = {}
    for d in run.diagnostics:
        if d.position.file == file.name and d.severity != "note":
            says.setdefault(d.position.line, []).append(f"{d.severity}: {d.message}")
    return says
