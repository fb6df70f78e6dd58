"""What heads a file or a routine, and what declares names, as data: DEF, DECL, STRUC, SIGNAL, EXT."""

from __future__ import annotations

from dataclasses import dataclass, field

from lwr_dyn.krl.expressions import Expression, Reference


@dataclass(frozen=True, slots=True)
class Header:
    """`&ACCESS RVP`: text for the controller's file system, whole."""

    text: str


@dataclass(frozen=True, slots=True)
class Parameter:
    """`name[]:IN`; `dimensions` counts the places between the brackets, 0 without."""

    name: str
    mode: str | None = None
    dimensions: int = 0
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Def:
    """`DEF name(...)`, or `DEFFCT returns name(...)`."""

    name: str
    parameters: tuple[Parameter, ...] = ()
    returns: str | None = None
    returns_array: bool = False
    is_global: bool = False
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class DefDat:
    """`DEFDAT name PUBLIC`."""

    name: str
    public: bool = False
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Declarator:
    """One declared name: `name[3, 4] = value`; `sizes` is None without brackets, () for `[]`."""

    name: str
    sizes: tuple[Expression, ...] | None = None
    value: Expression | None = None
    column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Declaration:
    """`DECL E6POS P1, P2`; the type is None where it is forgotten, `decl` says whether DECL is written."""

    type: str | None
    names: tuple[Declarator, ...]
    decl: bool = True
    is_global: bool = False
    const: bool = False
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class EnumType:
    """`ENUM name A, B, C`."""

    name: str
    members: tuple[str, ...]
    is_global: bool = False
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class StructType:
    """`STRUC name INT A, B, REAL C`: one declaration for each type."""

    name: str
    members: tuple[tuple[str, tuple[Declarator, ...]], ...]
    is_global: bool = False
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class Signal:
    """`SIGNAL name $IN[1] TO $IN[4]`."""

    name: str
    first: Reference
    last: Reference | None = None
    is_global: bool = False
    column: int = field(default=1, compare=False)


@dataclass(frozen=True, slots=True)
class External:
    """`EXT name(INT:IN)`, `EXTFCT REAL name(...)`: a subprogram that lives elsewhere."""

    name: str
    returns: str | None = None
    parameters: tuple[str, ...] = ()
    column: int = field(default=1, compare=False)
