"""Statements of KRL as records. KRL has one statement a line; `blocks` pairs the lines of a block (IF ... ENDIF).

A new statement needs a rule in `grammar.lark`; a record, its row in `RULES` and its place in `Statement` here; and a
row each in `unparse`, `static_checks` and `execute`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

from lwr_dyn.krl.language.declarations import Declared, PlacedLine
from lwr_dyn.krl.language.expressions import Expression, FunctionCall, Name, Nodes, Reference, Rules
from lwr_dyn.krl.language.lexer import LineError, Token


@dataclass(frozen=True, slots=True)
class Plain(PlacedLine):
    """A line of one keyword: END, ENDFCT, ENDDAT, ELSE, ENDIF, LOOP, HALT, BRAKE F ..."""

    keyword: str


@dataclass(frozen=True, slots=True)
class Assign(PlacedLine):
    """`target = value`."""

    target: Reference
    value: Expression


@dataclass(frozen=True, slots=True)
class Invoke(PlacedLine):
    """A subprogram call as a statement."""

    call: FunctionCall


@dataclass(frozen=True, slots=True)
class Move(PlacedLine):
    """A motion: PTP, LIN, CIRC, their _REL and spline forms; CIRC has an auxiliary point and may have an angle."""

    kind: str
    target: Expression
    auxiliary: Expression | None = None
    angle: Expression | None = None
    """[deg] CA of CIRC."""
    settings: tuple[Assign, ...] = ()
    """The assignments after WITH."""
    blends: tuple[str, ...] = ()
    """C_PTP, C_DIS, C_ORI, C_VEL, C_SPL."""
    frame: str | None = None
    """#BASE or #TOOL of a relative motion, without the hash."""


@dataclass(frozen=True, slots=True)
class SplineBlock(PlacedLine):
    """`SPLINE WITH ...`, or `PTP_SPLINE`."""

    kind: str
    settings: tuple[Assign, ...] = ()


@dataclass(frozen=True, slots=True)
class EndSpline(PlacedLine):
    """`ENDSPLINE C_SPL`."""

    blends: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Wait(PlacedLine):
    """`WAIT SEC seconds` or `WAIT FOR condition`."""

    kind: str
    value: Expression


@dataclass(frozen=True, slots=True)
class Condition(PlacedLine):
    """`IF x THEN`, `WHILE x`, `UNTIL x`, `SWITCH x`: a keyword with an expression."""

    keyword: str
    value: Expression


@dataclass(frozen=True, slots=True)
class CaseBranch(PlacedLine):
    """`CASE 1, 2`."""

    values: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class For(PlacedLine):
    """`FOR variable = first TO last STEP step`."""

    variable: Reference
    first: Expression
    last: Expression
    step: Expression | None = None


@dataclass(frozen=True, slots=True)
class Jump(PlacedLine):
    """`GOTO label`."""

    label: str


@dataclass(frozen=True, slots=True)
class Label(PlacedLine):
    """`label:`."""

    name: str


@dataclass(frozen=True, slots=True)
class Return(PlacedLine):
    """`RETURN`, in a function with its value."""

    value: Expression | None = None


@dataclass(frozen=True, slots=True)
class InterruptDeclaration(PlacedLine):
    """`INTERRUPT DECL priority WHEN condition DO action`; with `INTERRUPT WITH BRAKE DECL` it also brakes the robot."""

    priority: Expression
    condition: Expression
    action: Assign | Invoke
    is_global: bool = False
    with_brake: bool = False


@dataclass(frozen=True, slots=True)
class InterruptSwitch(PlacedLine):
    """`INTERRUPT ON 3`; mode is ON, OFF, ENABLE or DISABLE."""

    mode: str
    priority: Expression | None = None


@dataclass(frozen=True, slots=True)
class Trigger(PlacedLine):
    """`TRIGGER WHEN DISTANCE = 0 DELAY = 20 DO action PRIO = -1`; `place` is DISTANCE or PATH."""

    place: str
    value: Expression
    delay: Expression
    action: Assign | Invoke
    priority: Expression | None = None
    on_start: bool = False


@dataclass(frozen=True, slots=True)
class ConstantSpeed(PlacedLine):
    """`CONST_VEL START = 10 ONSTART` or `CONST_VEL END = -5`: a range of SPLINE that is run at constant speed."""

    bound: str
    """START or END."""
    offset: Expression
    """[mm] Along the path from the end of the motion before, or from its start."""
    on_start: bool = False


@dataclass(frozen=True, slots=True)
class TimeBlock(PlacedLine):
    """`TIME_BLOCK START`, `TIME_BLOCK PART = 20`, `TIME_BLOCK END = 2.5`: parts of a spline and the time of all."""

    bound: str
    """START, PART or END."""
    value: Expression | None = None
    """Of PART its share of the whole, of END [s] the whole."""


@dataclass(frozen=True, slots=True)
class ConditionalStop(PlacedLine):
    """`STOP WHEN PATH = 50 IF $IN[1]`: the arm waits at a place of a spline as long as the condition holds."""

    distance: Expression
    """[mm] As that of a TRIGGER WHEN PATH."""
    condition: Expression
    on_start: bool = False


@dataclass(frozen=True, slots=True)
class Analog(PlacedLine):
    """`ANOUT ON x = 0.5 * y + 0.1 DELAY = 0.2`, `ANIN OFF x`."""

    keyword: str
    mode: str
    target: Reference
    value: Expression | None = None
    options: tuple[Assign, ...] = ()


@dataclass(frozen=True, slots=True)
class Confirm(PlacedLine):
    """`CONFIRM number`: acknowledge messages, all with 0."""

    value: Expression


Statement: TypeAlias = (
    Declared | Plain | Confirm | Assign | Invoke | Move | SplineBlock | EndSpline | Wait | Condition | CaseBranch
    | For | Jump | Label | Return | InterruptDeclaration | InterruptSwitch | Trigger | ConstantSpeed | TimeBlock
    | ConditionalStop | Analog
)  # fmt: skip


def _motion_options(c: Nodes) -> dict[str, Any]:
    blends = tuple(x.text.upper() for x in c if isinstance(x, Token) and x.kind == "BLEND")
    frames = [x.text[1:].lstrip() for x in c if isinstance(x, Token) and x.kind == "ENUMERATION"]
    settings = tuple(a for x in c if isinstance(x, tuple) for a in x)
    return {"blends": blends, "frame": frames[-1] if frames else None, "settings": settings}


def _brake(c: Nodes) -> Plain:
    if c[1] is None:
        return Plain("BRAKE", column=c[0].column)
    if c[1].text.upper() != "F":
        raise LineError(c[1].column, "syntax", f"{c[1].text!r} does not belong here", "BRAKE, or BRAKE F")
    return Plain("BRAKE F", column=c[0].column)


def _constant_speed(c: Nodes) -> ConstantSpeed:
    return ConstantSpeed(_bound(c[1], "START", "END"), c[2], c[3] is not None, column=c[0].column)


def _time_block(c: Nodes) -> TimeBlock:
    bound, value = _bound(c[1], "START", "PART", "END"), c[2]
    if (value is None) != (bound == "START"):
        allowed = "TIME_BLOCK START, TIME_BLOCK PART = share, TIME_BLOCK END = seconds"
        raise LineError(c[1].column, "syntax", f"TIME_BLOCK {bound} with{'out' * (value is None)} a value", allowed)
    return TimeBlock(bound, value, column=c[0].column)


def _bound(word: Token, *allowed: str) -> str:
    if word.text.upper() not in allowed:
        hint = f"allowed here: {', '.join(allowed)}"
        raise LineError(word.column, "syntax", f"{word.text!r} does not belong here", hint)
    return word.text.upper()


RULES: Rules = {
    "assign": lambda c: Assign(c[0], c[1], column=c[0].column),
    "invoke": lambda c: Invoke(c[0], column=c[0].column),
    "move": lambda c: Move(c[0].text.upper(), c[1], column=c[0].column, **_motion_options(c[2:])),
    # parts: CIRC auxiliary end [CA angle] options...
    "circ": lambda c: Move(c[0].text.upper(), c[2], c[1], c[4], column=c[0].column, **_motion_options(c[5:])),
    "with_": lambda c: tuple(c[1:]),
    "spline": lambda c: SplineBlock(c[0].text.upper(), c[1] or (), column=c[0].column),
    "endspline": lambda c: EndSpline(tuple(x.text.upper() for x in c[1:]), column=c[0].column),
    "wait": lambda c: Wait(c[1].text.upper(), c[2], column=c[0].column),
    "condition": lambda c: Condition(c[0].text.upper(), c[1], column=c[0].column),
    "case": lambda c: CaseBranch(tuple(c[1:]), column=c[0].column),
    "for_": lambda c: For(c[1], c[2], c[4], c[6], column=c[0].column),
    "jump": lambda c: Jump(c[1].text, column=c[0].column),
    "label": lambda c: Label(c[0].text, column=c[0].column),
    "return_": lambda c: Return(c[1], column=c[0].column),
    "interrupt_declaration": lambda c: InterruptDeclaration(
        c[5], c[7], c[9], bool(c[0]), bool(c[2]), column=c[1].column
    ),
    "interrupt_switch": lambda c: InterruptSwitch(c[1].text.upper(), c[2], column=c[0].column),
    "trigger": lambda c: Trigger(c[2].text.upper(), c[3], c[6], c[8], c[10], c[4] is not None, column=c[0].column),
    "constant_speed": _constant_speed,
    "time_block": _time_block,
    # parts: STOP WHEN PATH distance [ONSTART] IF condition
    "stop_when": lambda c: ConditionalStop(c[3], c[6], c[4] is not None, column=c[0].column),
    "analog": lambda c: Analog(c[0].text.upper(), c[1].text.upper(), c[2], c[3], c[4] or (), column=c[0].column),
    "options": lambda c: (Assign(Name(c[0].text.upper(), column=c[0].column), c[1], column=c[0].column), *(c[2] or ())),
    "brake": _brake,
    "confirm": lambda c: Confirm(c[1], column=c[0].column),
    "plain": lambda c: Plain(c[0].text.upper(), column=c[0].column),
}
