"""What a line of KRL can say, as data. KRL has one statement a line, so a program is a sequence of these.

Blocks (IF ... ENDIF) are lines too; `structure` pairs them up.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from lwr_dyn.krl.declarations import Declaration, Def, DefDat, EnumType, External, Header, Signal, StructType
from lwr_dyn.krl.expressions import Call, Expression, Reference


@dataclass(frozen=True, slots=True)
class Plain:
    """A line of one keyword: END, ENDFCT, ENDDAT, ELSE, ENDIF, LOOP, HALT, CONTINUE ..."""

    keyword: str
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Assign:
    """`target = value`."""

    target: Reference
    value: Expression
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Invoke:
    """A subprogram call as a statement."""

    call: Call
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Move:
    """A motion: PTP, LIN, CIRC, their _REL and spline forms; CIRC has an auxiliary point perhaps an angle CA [deg]."""

    kind: str
    target: Expression
    auxiliary: Expression | None = None
    angle: Expression | None = None
    settings: tuple[Assign, ...] = ()
    """What stands after WITH."""
    blends: tuple[str, ...] = ()
    """C_PTP, C_DIS, C_ORI, C_VEL, C_SPL."""
    frame: str | None = None
    """#BASE or #TOOL of a relative motion, without the hash."""
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class SplineBlock:
    """`SPLINE WITH ...`, or `PTP_SPLINE`."""

    kind: str
    settings: tuple[Assign, ...] = ()
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class EndSpline:
    """`ENDSPLINE C_SPL`."""

    blends: tuple[str, ...] = ()
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Wait:
    """`WAIT SEC seconds` or `WAIT FOR condition`."""

    kind: str
    value: Expression
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Condition:
    """`IF x THEN`, `WHILE x`, `UNTIL x`, `SWITCH x`: a keyword with an expression."""

    keyword: str
    value: Expression
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Case:
    """`CASE 1, 2`."""

    values: tuple[Expression, ...]
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class For:
    """`FOR variable = first TO last STEP step`."""

    variable: Reference
    first: Expression
    last: Expression
    step: Expression | None = None
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Jump:
    """`GOTO label`."""

    label: str
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Label:
    """`label:`."""

    name: str
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Return:
    """`RETURN`, in a function with its value."""

    value: Expression | None = None
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class InterruptDeclaration:
    """`INTERRUPT DECL priority WHEN condition DO action`."""

    priority: Expression
    condition: Expression
    action: Assign | Invoke
    is_global: bool = False
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class InterruptSwitch:
    """`INTERRUPT ON 3`; mode is ON, OFF, ENABLE or DISABLE."""

    mode: str
    priority: Expression | None = None
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Trigger:
    """`TRIGGER WHEN DISTANCE = 0 DELAY = 20 DO action PRIO = -1`; `place` is DISTANCE or PATH."""

    place: str
    value: Expression
    delay: Expression
    action: Assign | Invoke
    priority: Expression | None = None
    on_start: bool = False
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Analog:
    """`ANOUT ON x = 0.5 * y + 0.1 DELAY = 0.2`, `ANIN OFF x`."""

    keyword: str
    mode: str
    target: Reference
    value: Expression | None = None
    options: tuple[Assign, ...] = ()
    column: int = field(default=1, compare=False)


Statement: TypeAlias = (
    Header | Def | DefDat | Plain | Declaration | EnumType | StructType | Signal | External | Assign | Invoke | Move
    | SplineBlock | EndSpline | Wait | Condition | Case | For | Jump | Label | Return | InterruptDeclaration
    | InterruptSwitch | Trigger | Analog
)  # fmt: skip
