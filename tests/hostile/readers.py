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
from lwr_dyn.arms.export.mjcf import mjcf_text
from lwr_dyn.arms.papers.catalog import open_paper, template
from lwr_dyn.checks.conventions.evidence import read_evidence
from lwr_dyn.checks.conventions.printed_table import printed_table
from lwr_dyn.checks.tables.rules import lint, sheet_of_file
from lwr_dyn.checks.urdf.lint import lint_file
from lwr_dyn.cli.main import main
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.krl.project.program import load_program, parse_program
from lwr_dyn.krl.running.cell import input_values, read_cell, with_cell
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import check_program
from lwr_dyn.studies.sweep.read_study import read_study
from tests.hostile.changes import VALUES, changed
from tests.hostile.folders import bag, machine_data, sweep_folder, xacro
from tests.hostile.recordings import log_csv, log_parquet, motion_csv, run_file, written
from tests.krl.mutations import SOURCES

ROOT = Path(__file__).resolve().parents[2]
GOOD = "tests/hostile/good"
Reader = Callable[[Path, random.Random], bool | None]
"""Makes an input in a folder and reads it; False or an error of ours: it is refused."""
MORE_NUMBERS = "nnnnnnnnvrrwdsx"


@functools.cache
def _text(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def _posed(path: Path) -> None:
    """An arm, and where its flange is."""
    arm = lwr_dyn.load(path)
    lwr_dyn.forward_kinematics(arm, np.zeros(arm.n))


def of_text(ending: str, seeds: Callable[[], tuple[str, ...]], read: Callable[[Path], object]) -> Reader:
    """A reader of one file of text, one of the seeds with changes."""

    def reader(folder: Path, rng: random.Random) -> None:
        read(written(folder, f"x{ending}", changed(rng.choice(seeds()), rng)))

    return reader


@functools.cache
def _robots() -> tuple[str, ...]:
    own = template("own.toml", "own", "RPR")
    return own, own, *(_text(f"lwr_dyn/arms/papers/{name}.toml") for name in ("lwr4", "wam7"))


@functools.cache
def _urdfs() -> tuple[str, ...]:
    return (*(_text(f"{GOOD}/{name}.urdf") for name in ("two", "free", "mimic")), _text("models/lwr4/lwr4.urdf"))


@functools.cache
def _kuka() -> Any:
    return lwr_dyn.load("kr30ha")


@functools.cache
def _mjcf() -> tuple[str, ...]:
    """One that this package wrote, and one of all ways to write a chain."""
    return mjcf_text(_kuka()), _text(f"{GOOD}/tree.xml")


def _study(path: Path) -> None:
    """A study of many runs, and the values of its first and last run."""
    read = read_study(path)
    for first in {0, read.count - 1}:
        assert all(len(values) == 1 for values in read.values(first, first + 1).values())


@functools.cache
def _programs() -> tuple[tuple[str, str | None], ...]:
    data = [path.with_suffix(".dat") for path in SOURCES]
    beside = [path.read_text(encoding="latin-1") if path.exists() else None for path in data]
    return tuple(zip((path.read_text(encoding="latin-1") for path in SOURCES), beside, strict=True))


def krl(folder: Path, rng: random.Random) -> bool:
    """A KRL program without an error, and inputs from outside; every tenth is moved."""

    def put(name: str, text: str, share: float) -> Path:
        return written(
            folder, name, (changed(text, rng) if rng.random() < share else text).encode("latin-1", "replace")
        )

    source, data = rng.choice(_programs())
    path = put("x.src", source, 0.85)
    (folder / "x.dat").unlink(missing_ok=True)
    if data is not None:
        put("x.dat", data, 0.25)
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
    read = read_cell(written(folder, "x.toml", changed(_text(f"{GOOD}/cell.toml"), rng, MORE_NUMBERS)))
    lines = ("DEF a(JOB :IN)", "DECL INT JOB", "GRIP()", "$OUT[5]=$IN[3] AND NOT $T1", "WAIT FOR $IN[7] AND $IN[8]",
             "BAS(#TOOL,1)", "PTP XHOME", "JOB=JOB+PART+$ERR.NUMBER", "PTP P[2]", "END")  # fmt: skip
    program = with_cell(parse_program("\n".join(lines), name="a"), replace(read, submits=()))
    check_program(program, _kuka(), cell=replace(read, submits=()))


def sheet(folder: Path, rng: random.Random) -> None:
    """A table of numbers, CSV or TOML, linted."""
    name = rng.choice(("sheet.csv", "gains.toml", "rows.toml"))
    lint(sheet_of_file(written(folder, f"x{Path(name).suffix}", changed(_text(f"{GOOD}/{name}"), rng))))


@functools.cache
def _table(name: str) -> Any:
    return printed_table(open_paper(name))


def evidence(folder: Path, rng: random.Random) -> None:
    """Evidence for a table of a paper."""
    name = rng.choice(("lwr4plus", "wam7"))
    text = changed(_text(f"lwr_dyn/arms/papers/evidence/{name}.toml"), rng, MORE_NUMBERS)
    read_evidence(written(folder, "x.toml", text), _table(name))


def tool(folder: Path, rng: random.Random) -> None:
    """An arm with a tool or a mount from a file."""
    what = rng.choice(("tool", "tool", "mount"))
    lwr_dyn.load("lwr4", **{what: written(folder, "x.toml", changed(_text(f"{GOOD}/{what}.toml"), rng))})


COMMANDS = (
    ("list",), ("list", "--json"), ("fk", "lwr4plus", "--q-deg", "0,10,0,-20,0,30,0"), ("krl", "write", "x.toml"),
    ("fk", "lwr4", "--q", "0,0,0,0,0,0,0"), ("fk", "x.urdf", "--q", "0.1,0.2", "--json"), ("fk", "--help"),
    ("urdf", "lwr4", "--out", "out"), ("urdf", "x.urdf", "--out", "out"), ("lint", "x.csv"), ("gains", "x.urdf"),
    ("lint", "x.toml", "--json"), ("krl", "check", "x.src", "--no-motion"), ("--version",),
    ("new", "arm", "own.toml", "--joints", "RR"),
)  # fmt: skip
WORDS = (*VALUES, "--json", "--robot", "--reading", "--tip", "--q", "x.urdf", "/dev/zero", "\0", "n" * 300, "空")


def command_line(folder: Path, rng: random.Random) -> bool:
    """`lwr-dyn` with words left out, doubled, exchanged or changed; read: it ends with 0 or 1."""
    words = list(rng.choice(COMMANDS))
    texts = (_urdfs()[0], _text(f"{GOOD}/sheet.csv"), _text(f"{GOOD}/gains.toml"), "DEF x( )\nEND\n")
    for ending, text in zip((".urdf", ".csv", ".toml", ".src"), texts, strict=True):
        written(folder, f"x{ending}", text)
    if rng.random() < 0.6:
        i, kind, extra = rng.randrange(len(words)), rng.randrange(5), rng.choice(WORDS)
        words[i : i + 1] = ([], [words[i]] * 2, [words[i], extra], [extra], [changed(words[i], rng)])[kind]
    before = Path.cwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as said:
            main(words)
    except SystemExit as end:
        if not (end.code in (0, 1) or (end.code == 2 and said.getvalue())):
            raise AssertionError(f"exit code {end.code}: {said.getvalue()[:200]}") from None
        return end.code in (0, 1)
    finally:
        os.chdir(before)
    raise AssertionError("no exit code")


READERS: dict[str, Reader] = {
    "robot TOML": of_text(".toml", _robots, _posed), "URDF": of_text(".urdf", _urdfs, _posed),
    "MJCF": of_text(".xml", _mjcf, _posed), "URDF judged": of_text(".urdf", _urdfs, lint_file), "xacro": xacro,
    "CSV log": log_csv, "CSV motion": motion_csv, "Parquet log": log_parquet, "run npz": run_file,
    "KRL and --set": krl, "KRL cell": cell, "lint sheet": sheet, "evidence": evidence, "tool and mount": tool,
    "study": of_text(".toml", lambda: (_text(f"{GOOD}/study.toml"),), _study), "command line": command_line, "bag": bag,
    "machine.dat": machine_data, "sweep folder": sweep_folder,
}  # fmt: skip


def one_input(name: str, seed: int, number: int, folder: Path) -> bool:
    """Whether input `number` of a reader is read; ours is caught, anything else goes through."""
    try:
        return READERS[name](folder, random.Random(f"{name} {seed} {number}")) is not False
    except LwrDynError:
        return False
