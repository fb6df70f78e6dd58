"""A job of points -> a `.src` and `.dat` as a KUKA controller expects them, Status and Turn from the model."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import FileAccessError, OptionError
from lwr_dyn.kinematics.kuka_pose import status, turn
from lwr_dyn.krl import expressions as e
from lwr_dyn.krl import statements as s
from lwr_dyn.krl.declarations import Declaration, Declarator, Def, DefDat, Header
from lwr_dyn.krl.program import Program, program_of
from lwr_dyn.krl.source import Line, SourceFile, lines_of
from lwr_dyn.krl.targets import Where, axes_of_point
from lwr_dyn.krl.values import Struct, pose_matrix
from lwr_dyn.model.arm import Arm

KINDS = ("PTP", "LIN")
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,23}")
SIX = ("X", "Y", "Z", "A", "B", "C")


@dataclass(frozen=True, slots=True)
class JobPoint:
    """A point: X, Y, Z [mm], A, B, C [deg] of the tool in the base, how to go there, how long to stand there [s]."""

    name: str
    place: tuple[float, ...]
    motion: str = "PTP"
    wait: float = 0.0


@dataclass(frozen=True, slots=True)
class Job:
    """From home through points in order and back home; speeds in % (PTP) and m/s (LIN); frames as X ... C [mm, deg]."""

    name: str
    points: tuple[JobPoint, ...]
    home_deg: tuple[float, ...]
    tool: tuple[float, ...] = (0.0,) * 6
    base: tuple[float, ...] = (0.0,) * 6
    ptp_percent: int = 100
    lin_speed: float = 0.25
    wait: float = 0.0
    """[s] at home, before and after."""


def read_job(path: str | Path, arm: Arm) -> Job:
    """A job from its task file (TOML); raises `FileAccessError`, `OptionError` for a field that is missing or wrong."""
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        raise FileAccessError(str(path), reason, "a task file (TOML) for krl write") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as fault:
        raise OptionError(str(path), f"not TOML ({fault})", "a task file for krl write") from None
    return job_of(table, arm, str(path))


def job_of(table: Mapping[str, Any], arm: Arm, file: str = "task") -> Job:
    """A job from a table: name, [[point]] with name, xyz, abc, motion, wait; home_deg, tool, base, ptp_percent ...

    Raises `OptionError`.
    """
    _known(file, table, {"name", "point", "home_deg", "tool", "base", "ptp_percent", "lin_speed", "wait"})
    rows = table.get("point")
    if not isinstance(rows, list) or not rows:
        raise OptionError(f"{file}: point", "none", "one or more [[point]] tables")
    points = tuple(_point(f"{file}: point {i + 1}", row) for i, row in enumerate(rows))
    names = [p.name.upper() for p in points]
    if len(set(names)) < len(names) or "XHOME" in names:
        raise OptionError(f"{file}: point", "a name that is there twice (or XHOME)", "a name of its own for each point")
    home = table.get("home_deg", np.degrees(arm.mastering).tolist() if arm.mastering else None)
    return Job(
        name=_name(f"{file}: name", table.get("name")), points=points,
        home_deg=_numbers(f"{file}: home_deg", home, arm.n),
        tool=_numbers(f"{file}: tool", table.get("tool", [0] * 6), 6),
        base=_numbers(f"{file}: base", table.get("base", [0] * 6), 6),
        ptp_percent=int(_between(f"{file}: ptp_percent", table.get("ptp_percent", 100), 1, 100)),
        lin_speed=_between(f"{file}: lin_speed", table.get("lin_speed", 0.25), 1e-3, 10.0),
        wait=_between(f"{file}: wait", table.get("wait", 0.0), 0.0, 1e4),
    )  # fmt: skip


def job_program(job: Job, arm: Arm) -> Program:
    """The program of a job; Status and Turn of each point are those of the solution the axes reach with least travel.

    Raises `OptionError` for a point that the arm cannot reach.
    """
    q = np.radians(job.home_deg)
    base, tool = (pose_matrix(_struct(x), "a frame") for x in (job.base, job.tool))
    taught = []
    for point in job.points:
        q = _solved(arm, job, point, Where(arm, q, base, tool, None))
        taught.append((point, status(arm, q), turn(q)))
    return program_of(_source(job), _data(job, taught, arm))


def _solved(arm: Arm, job: Job, point: JobPoint, where: Where) -> Array:
    said: list[str] = []

    def say(severity: str, code: str, message: str, hint: str) -> None:
        if severity == "error":
            said.append(message)

    q = axes_of_point(where, _struct(point.place, "POS"), False, say)
    if q is None or said:
        raise OptionError(f"point {point.name} of {job.name}", "; ".join(said), "a point the arm can reach")
    return q


def _source(job: Job) -> SourceFile:
    number = e.Integer
    lines: list[s.Statement | Line] = [
        Header("&ACCESS RVP"), Header("&REL 1"), Header("&COMMENT written by lwr_dyn"),
        Def(job.name),
        Line(None, "FOLD INI"),
        Line(None, " speeds, frames and the advance run as the machine data have them"),
        s.Invoke(e.Call("BAS", (e.EnumConstant("INITMOV"), number(0)))),
        Line(None, "ENDFOLD (INI)"),
        Line(),
        s.Assign(e.Name("$TOOL"), _aggregate(job.tool, "FRAME")),
        s.Assign(e.Name("$BASE"), _aggregate(job.base, "FRAME")),
        s.Invoke(e.Call("BAS", (e.EnumConstant("VEL_PTP"), number(job.ptp_percent)))),
        s.Assign(e.Component(e.Name("$VEL"), "CP"), e.Real(job.lin_speed)),
        Line(),
        s.Move("PTP", e.Name("XHOME")), *_wait(job.wait),
    ]  # fmt: skip
    for point in job.points:
        lines += [s.Move(point.motion, e.Name(point.name)), *_wait(point.wait)]
    lines += [s.Move("PTP", e.Name("XHOME")), *_wait(job.wait), s.Plain("END")]
    return SourceFile(f"{job.name}.src", lines_of(lines))


def _data(job: Job, taught: Sequence[tuple[JobPoint, int, int]], arm: Arm) -> SourceFile:
    axes = tuple(e.Item(name, _real(x)) for name, x in zip(arm.joint_names, job.home_deg, strict=True))
    outer = tuple(e.Item(f"E{i}", _real(0.0)) for i in range(1, 7))
    lines: list[s.Statement | Line] = [
        Header("&ACCESS RVP"), Header("&REL 1"), DefDat(job.name),
        _declared("E6AXIS", "XHOME", e.Aggregate((*axes, *outer))),
    ]  # fmt: skip
    for point, S, T in taught:
        place = tuple(e.Item(name, _real(x)) for name, x in zip(SIX, point.place, strict=True))
        branch = (e.Item("S", e.Integer(S, 2, 3)), e.Item("T", e.Integer(T, 2, 6)))
        lines.append(_declared("E6POS", point.name, e.Aggregate((*place, *branch, *outer))))
    return SourceFile(f"{job.name}.dat", lines_of([*lines, s.Plain("ENDDAT")]))


def _declared(kind: str, name: str, value: e.Expression) -> Declaration:
    return Declaration(kind, (Declarator(name, None, value),))


def _wait(seconds: float) -> list[s.Statement]:
    return [s.Wait("SEC", e.Real(seconds))] if seconds > 0.0 else []


def _aggregate(values: Sequence[float], kind: str) -> e.Aggregate:
    return e.Aggregate(tuple(e.Item(n, _real(x)) for n, x in zip(SIX, values, strict=True)), kind)


def _real(x: float) -> e.Expression:
    """A number as the grammar reads it: a sign is an operator of its own."""
    return e.Unary("-", e.Real(-x)) if x < 0.0 else e.Real(abs(x))


def _struct(values: Sequence[float], kind: str = "FRAME") -> Struct:
    return Struct(kind, dict(zip(SIX, map(float, values), strict=True)))


def _point(where: str, row: object) -> JobPoint:
    if not isinstance(row, dict):
        raise OptionError(where, repr(row), "a table")
    _known(where, row, {"name", "xyz", "abc", "motion", "wait"})
    place = (*_numbers(f"{where}: xyz", row.get("xyz"), 3), *_numbers(f"{where}: abc", row.get("abc", [0, 0, 0]), 3))
    motion = row.get("motion", "PTP")
    if motion not in KINDS:
        raise OptionError(f"{where}: motion", repr(motion), ", ".join(KINDS))
    wait = _between(f"{where}: wait", row.get("wait", 0.0), 0.0, 1e4)
    return JobPoint(_name(f"{where}: name", row.get("name")), place, motion, wait)


def _known(where: str, table: Mapping[str, Any], names: set[str]) -> None:
    unknown = sorted(set(table) - names)
    if unknown:
        raise OptionError(where, f"unknown field {unknown[0]}", ", ".join(sorted(names)))


def _name(where: str, value: object) -> str:
    from lwr_dyn.krl.lexer import KEYWORDS

    if not isinstance(value, str) or not _NAME.fullmatch(value) or value.upper() in KEYWORDS:
        raise OptionError(where, repr(value), "a name of KRL: letters, digits and _, at most 24, no keyword")
    return value


def _numbers(where: str, value: object, count: int) -> tuple[float, ...]:
    row = list(value) if isinstance(value, list | tuple) else []
    if len(row) != count or not all(_is_number(x) for x in row):
        raise OptionError(where, repr(value), f"{count} finite numbers")
    return tuple(float(x) for x in row)


def _is_number(x: object) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool) and bool(np.isfinite(x))


def _between(where: str, value: object, least: float, most: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= most:
        raise OptionError(where, repr(value), f"a number from {least:g} to {most:g}")
    return float(value)
