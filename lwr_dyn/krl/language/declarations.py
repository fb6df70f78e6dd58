"""Headers and declarations of KRL as records: DEF, DECL, STRUC, ENUM, SIGNAL, EXT."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from lwr_dyn.krl.language.expressions import Bool, Expression, Nodes, Placed, Reference, Rules


@dataclass(frozen=True, slots=True)
class PlacedLine(Placed):
    """A line, by the column of its first word that matters."""

    column: int = field(default=1, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Header:
    """`&ACCESS RVP`: a whole line for the controller's file system."""

    text: str


@dataclass(frozen=True, slots=True)
class Parameter(Placed):
    """`name[]:IN`; `dimensions` is the number of indices between the brackets, 0 without brackets."""

    name: str
    mode: str | None = None
    dimensions: int = 0
    sizes: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Def(PlacedLine):
    """`DEF name(...)`, or `DEFFCT returns[sizes] name(...)`."""

    name: str
    parameters: tuple[Parameter, ...] = ()
    returns: str | None = None
    returns_sizes: tuple[Expression, ...] | None = None
    """() for `CHAR[]`, None without brackets."""
    is_global: bool = False


@dataclass(frozen=True, slots=True)
class DefDat(PlacedLine):
    """`DEFDAT name PUBLIC`."""

    name: str
    public: bool = False


@dataclass(frozen=True, slots=True)
class Declarator(Placed):
    """One declared name: `name[3, 4] = value`; `sizes` is None without brackets, () for `[]` and `[,]`."""

    name: str
    sizes: tuple[Expression, ...] | None = None
    value: Expression | None = None
    commas: int = 0
    """Those of brackets without sizes: 1 for `[,]`."""


@dataclass(frozen=True, slots=True)
class Declaration(PlacedLine):
    """`DECL E6POS P1, P2`; `type` is None where it is missing, `decl` is False without the word DECL."""

    type: str | None
    names: tuple[Declarator, ...]
    decl: bool = True
    is_global: bool = False
    const: bool = False


@dataclass(frozen=True, slots=True)
class EnumType(PlacedLine):
    """`ENUM name A, B, C`."""

    name: str
    members: tuple[str, ...]
    is_global: bool = False


@dataclass(frozen=True, slots=True)
class StructType(PlacedLine):
    """`STRUC name INT A, B, REAL C`: one declaration for each type."""

    name: str
    members: tuple[tuple[str, tuple[Declarator, ...]], ...]
    is_global: bool = False


@dataclass(frozen=True, slots=True)
class Signal(PlacedLine):
    """`SIGNAL name $IN[1] TO $IN[4]`; `SIGNAL name FALSE` switches one off."""

    name: str
    first: Reference | Bool
    last: Reference | None = None
    is_global: bool = False


@dataclass(frozen=True, slots=True)
class Channel(PlacedLine):
    """`CHANNEL :name :channel $structure`: a serial line of the controller."""

    name: str
    channel: str
    structure: Reference
    is_global: bool = False


@dataclass(frozen=True, slots=True)
class External(PlacedLine):
    """`EXT name(INT:IN)`, `EXTFCT REAL name(...)`: a subprogram of another file; EXTP, EXTFCTP: of the controller."""

    name: str
    returns: str | None = None
    parameters: tuple[str, ...] = ()
    returns_sizes: tuple[Expression, ...] | None = None
    of_controller: bool = False


Declared: TypeAlias = Header | Def | DefDat | Declaration | EnumType | StructType | Signal | Channel | External


def _declaration(c: Nodes, kind: str | None, names_at: int) -> Declaration:
    # parts: [GLOBAL] DECL [GLOBAL] [CONST] type names...
    names, is_global = tuple(c[names_at:]), (c[0] or c[2]) is not None
    return Declaration(kind, names, True, is_global, c[3] is not None, column=c[1].column)


def _without_decl(c: Nodes, kind: str) -> Declaration:
    # parts: [GLOBAL] [CONST] type names...
    return Declaration(kind, tuple(c[3:]), False, c[0] is not None, c[1] is not None, column=c[2].column)


def _declarator(c: Nodes) -> Declarator:
    if isinstance(c[1], int):
        return Declarator(c[0].text, (), c[2], c[1], column=c[0].column)
    return Declarator(c[0].text, c[1], c[2], column=c[0].column)


def _structure(c: Nodes) -> StructType:
    members: list[tuple[str, tuple[Declarator, ...]]] = []
    for kind, declarator in c[3:]:
        if kind is None:  # another name of the type before
            members[-1] = (members[-1][0], (*members[-1][1], declarator))
        else:
            members.append((kind, (declarator,)))
    return StructType(c[2].text, tuple(members), c[0] is not None, column=c[2].column)


def _external_type(c: Nodes) -> str:
    # type [name] [brackets] [mode]
    name = "" if c[1] is None else f" {c[1].text}"
    return str(c[0]) + name + (c[2] or "") + ("" if c[3] is None else f":{c[3]}")


def _parameter(c: Nodes) -> Parameter:
    if isinstance(c[1], int):
        return Parameter(c[0].text, c[2], c[1] + 1, column=c[0].column)
    dimensions = 0 if c[1] is None else max(len(c[1]), 1)
    return Parameter(c[0].text, c[2], dimensions, c[1] or (), column=c[0].column)


def _external(c: Nodes) -> External:
    # EXT name [types], or EXTFCT type [sizes] name [types]
    returns, sizes, name, types = (None, None, *c[1:]) if len(c) == 3 else c[1:]
    own = c[0].kind.endswith("P")
    return External(name.text, returns, types or (), sizes, own, column=name.column)


RULES: Rules = {
    "def_": lambda c: Def(c[2].text, c[3] or (), is_global=c[0] is not None, column=c[2].column),
    "deffct": lambda c: Def(c[4].text, c[5] or (), c[2], c[3], c[0] is not None, column=c[4].column),
    "defdat": lambda c: DefDat(c[1].text, c[2] is not None, column=c[1].column),
    "parameters": tuple,
    "parameter": _parameter,
    "brackets": lambda c: "".join(x.text for x in c),
    "mode": lambda c: c[0].text.upper(),
    "typed": lambda c: _declaration(c, c[4], 5),
    "untyped": lambda c: _declaration(c, None, 4),
    "bare": lambda c: _without_decl(c, c[2].text.upper()),
    "bare_named": lambda c: _without_decl(c, c[2].text),
    "type": lambda c: c[0].text.upper() if c[0].kind == "SIMPLE" else c[0].text,
    "declarator": _declarator,
    "commas": len,
    "enum_": lambda c: EnumType(c[2].text, tuple(x.text for x in c[3:]), c[0] is not None, column=c[2].column),
    "struc": _structure,
    "member": lambda c: (c[0], Declarator(c[1].text, c[2], column=c[1].column)),
    "also": lambda c: (None, Declarator(c[0].text, c[1], column=c[0].column)),
    "signal": lambda c: Signal(c[2].text, c[3], c[5], c[0] is not None, column=c[2].column),
    "no_signal": lambda c: Signal(
        c[2].text, Bool(False, column=c[3].column), None, c[0] is not None, column=c[2].column
    ),
    "channel": lambda c: Channel(c[2].text, c[3].text, c[4], c[0] is not None, column=c[2].column),
    "ext": _external,
    "extfct": _external,
    "ext_types": tuple,
    "ext_type": _external_type,
}
