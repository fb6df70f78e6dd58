"""A list of points -> a `.src` and `.dat` as a KUKA controller expects them, with Status and Turn from the model."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.fields import Fields, parse_toml
from lwr_dyn.foundation.files import read_text
from lwr_dyn.krl.diagnostics import DiagnosticLog, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.declarations import Declaration, Declarator, Def, DefDat, Header
from lwr_dyn.krl.language.lexer import KEYWORDS
from lwr_dyn.krl.language.source import SourceFile, SourceLine, lines_of
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.project.program import Program, program_of
from lwr_dyn.krl.robot.kuka_pose import status, turn
from lwr_dyn.krl.running.targets import RobotState, axes_of_point
from lwr_dyn.krl.running.values import POSE_NAMES, StructValue, pose_matrix
from lwr_dyn.model.arm import Arm

OUTER = tuple(e.Item(f"E{i}", e.Real(0.0)) for i in range(1, 7))
"""External axes, which the model does not have."""
NAMES = "a name of KRL: letters, digits and _, at most 24, no keyword"
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,23}")


def is_name(text: str) -> bool:
    """Whether a text is a name of KRL."""
    return _NAME.fullmatch(text) is not None and text.upper() not in KEYWORDS


def program_file(
    name: str, tool: s.Statement, base: s.Statement, percent: int, speed: float, moves: Sequence[s.Statement]
) -> SourceFile:
    """A `.src`: initialisation, tool and base, speeds [%], [m/s], then the moves."""
    lines: list[s.Statement | SourceLine] = [
        Header("&ACCESS RVP"), Header("&REL 1"), Header("&COMMENT written by lwr_dyn"),
        Def(name),
        SourceLine(None, "FOLD INI"),
        SourceLine(None, " speeds, frames and the advance run as the machine data have them"),
        s.Invoke(e.FunctionCall("BAS", (e.EnumLiteral("INITMOV"), e.Integer(0)))),
        SourceLine(None, "ENDFOLD (INI)"),
        SourceLine(),
        tool,
        base,
        s.Invoke(e.FunctionCall("BAS", (e.EnumLiteral("VEL_PTP"), e.Integer(percent)))),
        component_set("$VEL.CP", speed),
        SourceLine(),
        *moves,
        s.Plain("END"),
    ]  # fmt: skip
    return SourceFile(f"{name}.src", lines_of(lines))


def data_file(name: str, declarations: Sequence[s.Statement]) -> SourceFile:
    """A `.dat`."""
    lines: list[s.Statement | SourceLine] = [
        Header("&ACCESS RVP"), Header("&REL 1"), DefDat(name), *declarations, s.Plain("ENDDAT"),
    ]  # fmt: skip
    return SourceFile(f"{name}.dat", lines_of(lines))


def axes_declared(name: str, arm: Arm, axes_deg: Sequence[float]) -> Declaration:
    """`DECL E6AXIS name = {A1 ...}`."""
    axes = tuple(e.Item(axis, real(x)) for axis, x in zip(arm.joint_names, axes_deg, strict=True))
    return _declared("E6AXIS", name, (*axes, *OUTER))


def pose_declared(name: str, pose: Sequence[float], S: int, T: int) -> Declaration:
    """`DECL E6POS name = {X ..., S ..., T ...}`, S and T in bits."""
    branch = (e.Item("S", e.Integer(S, 2, 3)), e.Item("T", e.Integer(T, 2, 6)))
    return _declared("E6POS", name, (*pose_items(pose), *branch, *OUTER))


def frame_set(name: str, pose: Sequence[float], number: int | None = None) -> s.Statement:
    """`$TOOL = {FRAME: X ...}` of X, Y, Z [mm], A, B, C [deg], or by its number: `BAS(#TOOL, 3)`."""
    if number is None:
        return s.Assign(e.Name(f"${name}"), e.Aggregate(pose_items(pose), "FRAME"))
    return s.Invoke(e.FunctionCall("BAS", (e.EnumLiteral(name), e.Integer(number))))


def config_entries(name: str, number: int, pose: Sequence[float], title: str) -> str:
    """The two lines of `$config.dat` for a tool or base of this number."""
    values = expression_text(e.Aggregate(pose_items(pose)))
    return f'{name}_DATA[{number}]={values}\n{name}_NAME[{number},]="{title}"'


def component_set(name: str, value: float) -> s.Assign:
    """`$VEL.CP = 0.25`."""
    variable, component = name.split(".")
    return s.Assign(e.Component(e.Name(variable), component), real(value))


def pose_items(values: Sequence[float]) -> tuple[e.Item, ...]:
    """X, Y, Z, A, B, C of an aggregate."""
    return tuple(e.Item(name, real(x)) for name, x in zip(POSE_NAMES, values, strict=True))


def real(x: float) -> e.Expression:
    """A number as the grammar reads it: a sign is an operator of its own."""
    return e.Unary("-", e.Real(-x)) if x < 0.0 else e.Real(abs(x))


def _declared(kind: str, name: str, items: tuple[e.Item, ...]) -> Declaration:
    return Declaration(kind, (Declarator(name, None, e.Aggregate(items)),))


KINDS = ("PTP", "LIN")


@dataclass(frozen=True, slots=True)
class TaughtPoint:
    """A point: X, Y, Z [mm], A, B, C [deg] of the tool in the base, the motion to it, the wait there [s]."""

    name: str
    pose: tuple[float, ...]
    motion: str = "PTP"
    wait: float = 0.0


@dataclass(frozen=True, slots=True)
class PointProgram:
    """From home through the points in order and back home; tool and base as X, Y, Z [mm], A, B, C [deg]."""

    name: str
    points: tuple[TaughtPoint, ...]
    home_deg: tuple[float, ...]
    tool: tuple[float, ...] = (0.0,) * 6
    base: tuple[float, ...] = (0.0,) * 6
    ptp_percent: int = 100
    lin_speed: float = 0.25
    """[m/s]"""
    wait: float = 0.0
    """[s] At home, before and after."""


def read_point_program(path: str | Path, arm: Arm) -> PointProgram:
    """Read a task file (TOML); raises `FileAccessError`, or `PaperError` for a field that is missing or wrong."""
    text = read_text(path, "a task file (TOML) for krl write")
    return point_program_of(parse_toml(text, str(path)), arm, str(path))


def point_program_of(table: Mapping[str, Any], arm: Arm, file: str = "task") -> PointProgram:
    """From a table: name, [[point]] with name, xyz, abc, motion, wait; home_deg, tool, base, ptp_percent ...

    Raises `PaperError`.
    """
    top = Fields(table, file)
    points = tuple(map(_point, top.tables("point", default=[])))
    if not points:
        raise top.refuse("point", "none", "one or more [[point]] tables")
    names = [p.name.upper() for p in points]
    if len(set(names)) < len(names) or "XHOME" in names:
        raise top.refuse("point", "a name that is there twice (or XHOME)", "a different name for each point")
    home = top.take("home_deg", list, **({"default": np.degrees(arm.mastering).tolist()} if arm.mastering else {}))
    zeros = (0.0,) * 6
    program = PointProgram(
        name=_name(top), points=points,
        home_deg=top.row_at("home_deg", home, arm.n, f"{arm.n} finite numbers"),
        tool=top.row("tool", 6, "6 finite numbers", default=zeros),
        base=top.row("base", 6, "6 finite numbers", default=zeros),
        ptp_percent=int(top.number("ptp_percent", 100, least=1, most=100)),
        lin_speed=top.number("lin_speed", 0.25, least=1e-3, most=10.0),
        wait=top.number("wait", 0.0, least=0.0, most=1e4),
    )  # fmt: skip
    top.refuse_unknown()
    return program


def _point(fields: Fields) -> TaughtPoint:
    xyz = fields.row("xyz", 3, "3 finite numbers")
    abc = fields.row("abc", 3, "3 finite numbers", default=(0.0, 0.0, 0.0))
    motion, wait = fields.choice("motion", KINDS, default="PTP"), fields.number("wait", 0.0, least=0.0, most=1e4)
    point = TaughtPoint(_name(fields), (*xyz, *abc), motion, wait)
    fields.refuse_unknown()
    return point


def _name(fields: Fields) -> str:
    value: str = fields.text("name")
    if not is_name(value):
        raise fields.refuse("name", repr(value), NAMES)
    return value


def generate_program(points: PointProgram, arm: Arm) -> Program:
    """The KRL program; Status and Turn of each point are those of the solution nearest to the point before.

    Raises `OptionError` for a point that the arm cannot reach.
    """
    q = np.radians(points.home_deg)
    base, tool = (pose_matrix(_struct(x, "FRAME"), "a frame") for x in (points.base, points.tool))
    declared = [axes_declared("XHOME", arm, points.home_deg)]
    for point in points.points:
        q = _axes_of(points.name, point, RobotState(arm, q, base, tool, None))
        declared.append(pose_declared(point.name, point.pose, status(arm, q), turn(q)))
    return program_of(_source(points), data_file(points.name, declared))


def _axes_of(program: str, point: TaughtPoint, robot: RobotState) -> Array:
    log = DiagnosticLog(SourcePosition(program, 1), tolerant=True)
    q = axes_of_point(robot, _struct(point.pose, "POS"), False, log.report)
    errors = [d.message for d in log.diagnostics if d.severity == "error"]
    if q is None or errors:
        raise OptionError(f"point {point.name} of {program}", "; ".join(errors), "a point the arm can reach")
    return q


def _source(points: PointProgram) -> SourceFile:
    home = [s.Move("PTP", e.Name("XHOME")), *waiting(points.wait)]
    there = [x for point in points.points for x in (s.Move(point.motion, e.Name(point.name)), *waiting(point.wait))]
    moves = [*home, *there, *home]
    tool, base = frame_set("TOOL", points.tool), frame_set("BASE", points.base)
    return program_file(points.name, tool, base, points.ptp_percent, points.lin_speed, moves)


def waiting(seconds: float) -> list[s.Statement]:
    """WAIT SEC; nothing for no time."""
    return [s.Wait("SEC", e.Real(seconds))] if seconds > 0.0 else []


def _struct(values: Sequence[float], kind: str) -> StructValue:
    return StructValue(kind, dict(zip(POSE_NAMES, map(float, values), strict=True)))
