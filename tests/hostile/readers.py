"""The readers of this package, each with a generator of inputs: `scripts/soak.py fuzz` runs all, the tests a share.

A reader reads one input from a folder; it gives "read" or "refused", and any exception that is not ours goes through.
"""

from __future__ import annotations

import contextlib
import functools
import io
import os
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError
from tests.hostile.changes import VALUES, changed
from tests.hostile.folders import bag, machine_data, sweep_folder, xacro
from tests.hostile.recordings import log_csv, log_parquet, motion_csv, run_file, written

ROOT = Path(__file__).resolve().parents[2]
GOOD = "tests/hostile/good"
Reader = Callable[[Path, random.Random], bool | None]
"""Makes an input in a folder and reads it; False or an error of ours: it is refused."""


@functools.cache
def _text(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def _posed(path: Path) -> None:
    """An arm, and where its flange is."""
    arm = lwr_dyn.load(path)
    lwr_dyn.forward_kinematics(arm, np.zeros(arm.n))


def robot_file(folder: Path, rng: random.Random) -> None:
    """A robot's TOML."""
    seeds = (_own_arm(), _own_arm(), _text("lwr_dyn/arms/papers/lwr4.toml"), _text("lwr_dyn/arms/papers/wam7.toml"))
    _posed(written(folder, "x.toml", changed(rng.choice(seeds), rng)))


@functools.cache
def _own_arm() -> str:
    import tempfile

    with tempfile.TemporaryDirectory() as place:
        _command("new", "arm", f"{place}/own.toml", "--joints", "RPR")
        return Path(f"{place}/own.toml").read_text(encoding="utf-8")


@functools.cache
def _urdfs() -> tuple[str, ...]:
    own = tuple(_text(f"{GOOD}/{name}.urdf") for name in ("two", "free", "mimic"))
    return (*own, _text("models/lwr4/lwr4.urdf"))


def urdf(folder: Path, rng: random.Random) -> None:
    """A URDF."""
    _posed(written(folder, "x.urdf", changed(rng.choice(_urdfs()), rng)))


@functools.cache
def _mjcf() -> tuple[str, ...]:
    from lwr_dyn.arms.export.mjcf import mjcf_text

    return mjcf_text(_kuka()), _text(f"{GOOD}/tree.xml")


def mjcf(folder: Path, rng: random.Random) -> None:
    """An MJCF that this package wrote, and one of all ways to write a chain."""
    _posed(written(folder, "x.xml", changed(rng.choice(_mjcf()), rng)))


def urdf_judged(folder: Path, rng: random.Random) -> None:
    """A URDF judged link by link."""
    from lwr_dyn.checks.urdf.lint import lint_file

    lint_file(written(folder, "x.urdf", changed(rng.choice(_urdfs()), rng)))


@functools.cache
def _programs() -> tuple[tuple[str, str | None], ...]:
    from tests.krl.mutations import SOURCES

    texts = []
    for path in SOURCES:
        data = path.with_suffix(".dat")
        beside = data.read_text(encoding="latin-1") if data.exists() else None
        texts.append((path.read_text(encoding="latin-1"), beside))
    return tuple(texts)


@functools.cache
def _kuka() -> Any:
    return lwr_dyn.load("kr30ha")


def krl(folder: Path, rng: random.Random) -> bool:
    """A KRL program without an error, and inputs from outside; every tenth is moved."""
    from lwr_dyn.krl.project.program import load_program
    from lwr_dyn.krl.running.cell import input_values
    from lwr_dyn.krl.running.controller import MachineData
    from lwr_dyn.krl.running.program_run import check_program

    source, data = rng.choice(_programs())
    path = written(
        folder, "x.src", (changed(source, rng) if rng.random() < 0.85 else source).encode("latin-1", "replace")
    )
    (folder / "x.dat").unlink(missing_ok=True)
    if data is not None:
        written(folder, "x.dat", (changed(data, rng) if rng.random() < 0.25 else data).encode("latin-1", "replace"))
    settings = changed("$IN[3]=TRUE", rng) if rng.random() < 0.5 else "$IN[1]=TRUE"
    try:
        inputs = input_values([settings])
    except LwrDynError:
        inputs = {}
    arm = _kuka() if rng.random() < 0.1 else None
    diagnostics = check_program(load_program(path), arm, MachineData(steps=2000, motions=10), inputs)
    return not any(d.severity == "error" for d in diagnostics)


def cell(folder: Path, rng: random.Random) -> None:
    """A cell file, and the check of a small program in it."""
    from lwr_dyn.krl.project.program import parse_program
    from lwr_dyn.krl.running.cell import read_cell, with_cell
    from lwr_dyn.krl.running.program_run import check_program

    read = read_cell(written(folder, "x.toml", changed(_text(f"{GOOD}/cell.toml"), rng, "nnnnnnnnvrrwdsx")))
    lines = ("DEF a(JOB :IN)", "DECL INT JOB", "GRIP()", "$OUT[5]=$IN[3] AND NOT $T1", "WAIT FOR $IN[7] AND $IN[8]",
             "BAS(#TOOL,1)", "PTP XHOME", "JOB=JOB+PART+$ERR.NUMBER", "PTP P[2]", "END")  # fmt: skip
    program = with_cell(parse_program("\n".join(lines), name="a"), replace(read, submits=()))
    check_program(program, _kuka(), cell=replace(read, submits=()))


def sheet(folder: Path, rng: random.Random) -> None:
    """A table of numbers, CSV or TOML, linted."""
    from lwr_dyn.checks.tables.rules import lint, sheet_of_file

    name = rng.choice(("sheet.csv", "gains.toml", "rows.toml"))
    lint(sheet_of_file(written(folder, f"x{Path(name).suffix}", changed(_text(f"{GOOD}/{name}"), rng))))


@functools.cache
def _tables() -> dict[str, Any]:
    from lwr_dyn.arms.papers.catalog import open_paper
    from lwr_dyn.checks.conventions.printed_table import printed_table

    return {name: printed_table(open_paper(name)) for name in ("lwr4plus", "wam7")}


def evidence(folder: Path, rng: random.Random) -> None:
    """Evidence for a table of a paper."""
    from lwr_dyn.checks.conventions.evidence import read_evidence

    name = rng.choice(("lwr4plus", "wam7"))
    text = changed(_text(f"lwr_dyn/arms/papers/evidence/{name}.toml"), rng, "nnnnnnnnvrrwdsx")
    read_evidence(written(folder, "x.toml", text), _tables()[name])


def tool(folder: Path, rng: random.Random) -> None:
    """An arm with a tool or a mount from a file."""
    what = rng.choice(("tool", "tool", "mount"))
    path = written(folder, "x.toml", changed(_text(f"{GOOD}/{what}.toml"), rng))
    lwr_dyn.load("lwr4", **{what: path})


def study(folder: Path, rng: random.Random) -> None:
    """A study of many runs, and the values of its first and last run."""
    from lwr_dyn.studies.sweep.read_study import read_study

    read = read_study(written(folder, "x.toml", changed(_text(f"{GOOD}/study.toml"), rng)))
    for first in {0, read.count - 1}:
        assert all(len(values) == 1 for values in read.values(first, first + 1).values())


COMMANDS = (
    ("list",), ("list", "--json"), ("fk", "lwr4plus", "--q-deg", "0,10,0,-20,0,30,0"), ("krl", "write", "x.toml"),
    ("fk", "lwr4", "--q", "0,0,0,0,0,0,0"), ("fk", "x.urdf", "--q", "0.1,0.2", "--json"), ("fk", "--help"),
    ("urdf", "lwr4", "--out", "out"), ("urdf", "x.urdf", "--out", "out"), ("lint", "x.csv"), ("gains", "x.urdf"),
    ("lint", "x.toml", "--json"), ("krl", "check", "x.src", "--no-motion"), ("--version",),
    ("new", "arm", "own.toml", "--joints", "RR"),
)  # fmt: skip


def command_line(folder: Path, rng: random.Random) -> bool:
    """`lwr-dyn` with words left out, doubled, exchanged or changed; read: it ends with 0 or 1."""
    words = list(rng.choice(COMMANDS))
    written(folder, "x.urdf", _urdfs()[0])
    written(folder, "x.csv", _text(f"{GOOD}/sheet.csv"))
    written(folder, "x.toml", _text(f"{GOOD}/gains.toml"))
    written(folder, "x.src", "DEF x( )\nEND\n")
    if rng.random() < 0.6:
        i, kind = rng.randrange(len(words)), rng.randrange(5)
        extra = rng.choice(
            (*VALUES, "--json", "--robot", "--reading", "--tip", "--q", "x.urdf", "/dev/zero", "\0", "n" * 300, "空")
        )
        words[i : i + 1] = ([], [words[i]] * 2, [words[i], extra], [extra], [changed(words[i], rng)])[kind]
    before = Path.cwd()
    os.chdir(folder)
    try:
        return _command(*words) in (0, 1)
    finally:
        os.chdir(before)


def _command(*words: str) -> int:
    """The exit code; what it prints goes nowhere."""
    from lwr_dyn.cli.main import main

    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as said:
        try:
            main(list(words))
        except SystemExit as end:
            code = end.code
    if not (code in (0, 1) or (code == 2 and said.getvalue())):
        raise AssertionError(f"exit code {code}: {said.getvalue()[:200]}")
    return int(code)


READERS: dict[str, Reader] = {
    "robot TOML": robot_file, "URDF": urdf, "MJCF": mjcf, "URDF judged": urdf_judged, "xacro": xacro,
    "CSV log": log_csv, "CSV motion": motion_csv, "Parquet log": log_parquet, "run npz": run_file,
    "KRL and --set": krl, "KRL cell": cell, "lint sheet": sheet, "evidence": evidence, "tool and mount": tool,
    "study": study, "command line": command_line, "bag": bag, "machine.dat": machine_data,
    "sweep folder": sweep_folder,
}  # fmt: skip


def one_input(name: str, seed: int, number: int, folder: Path) -> bool:
    """Whether input `number` of a reader is read; ours is caught, anything else goes through."""
    try:
        return READERS[name](folder, random.Random(f"{name} {seed} {number}")) is not False
    except LwrDynError:
        return False
