"""Lines of a program that is written: its beginning, declared points, its `.src` and `.dat`."""

import re
from collections.abc import Sequence

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.declarations import Declaration, Declarator, Def, DefDat, Header
from lwr_dyn.krl.language.lexer import KEYWORDS
from lwr_dyn.krl.language.source import SourceFile, SourceLine, lines_of
from lwr_dyn.krl.language.unparse import expression_text
from lwr_dyn.krl.running.values import POSE_NAMES
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
