"""The tree of a text: functions, statements, expressions, each with its place. Imported as a module: `tree.CSet`."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CNumber:
    """A whole number or a double."""

    value: int | float


@dataclass(frozen=True, slots=True)
class CName:
    """A variable, an argument or a constant."""

    name: str


@dataclass(frozen=True, slots=True)
class CItem:
    """One number of an array."""

    array: str
    place: "CExpression"


@dataclass(frozen=True, slots=True)
class CCall:
    """A call of a function."""

    function: str
    arguments: tuple["CExpression", ...]


@dataclass(frozen=True, slots=True)
class CUnary:
    """- or !"""

    sign: str
    of: "CExpression"


@dataclass(frozen=True, slots=True)
class CBinary:
    """Arithmetic, comparison, && or ||."""

    sign: str
    left: "CExpression"
    right: "CExpression"


@dataclass(frozen=True, slots=True)
class CChoice:
    """test ? yes : no."""

    test: "CExpression"
    yes: "CExpression"
    no: "CExpression"


CExpression = CNumber | CName | CItem | CCall | CUnary | CBinary | CChoice


@dataclass(frozen=True, slots=True)
class CRoom:
    """A local array, its numbers not set."""

    name: str
    size: int


@dataclass(frozen=True, slots=True)
class CSet:
    """target = value; `declared` is "double" or "int" where the variable begins here."""

    declared: str
    target: CName | CItem
    value: CExpression


@dataclass(frozen=True, slots=True)
class CFor:
    """`name` from `first` up to `end` (excluded) by `step`."""

    name: str
    first: CExpression
    end: CExpression
    step: int
    body: tuple["CStatement", ...]


@dataclass(frozen=True, slots=True)
class CWhile:
    """A loop."""

    test: CExpression
    body: tuple["CStatement", ...]


@dataclass(frozen=True, slots=True)
class CIf:
    """A branch."""

    test: CExpression
    yes: tuple["CStatement", ...]
    no: tuple["CStatement", ...]


@dataclass(frozen=True, slots=True)
class CReturn:
    """The end of a function."""

    value: CExpression | None


@dataclass(frozen=True, slots=True)
class CDo:
    """A call whose result, if any, does not count."""

    call: CCall


CStatement = CRoom | CSet | CFor | CWhile | CIf | CReturn | CDo


@dataclass(frozen=True, slots=True)
class CFunction:
    """A function; its kind and those of its arguments are "double", "int", "void", "double*"."""

    name: str
    kind: str
    arguments: tuple[tuple[str, str], ...]
    """(kind, name)."""
    body: tuple[CStatement, ...]


@dataclass(frozen=True, slots=True)
class CText:
    """A whole text."""

    functions: tuple[CFunction, ...]
    constants: Mapping[str, float]
    """Those that the text itself defines."""
