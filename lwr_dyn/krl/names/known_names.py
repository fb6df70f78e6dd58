"""Types of KRL, and the names that need no declaration: KUKA's own, those of option packages, those of a user's file.

The structures of the language itself stand here; all else is read from kernel.toml, system.toml (more `$` variables,
and which of all are read-only), options.toml, and files of a user of the same form.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import read_bytes

SIMPLE = frozenset({"INT", "REAL", "BOOL", "CHAR"})
NUMBERS = frozenset({"INT", "REAL", "CHAR"})
CARTESIAN = ("FRAME", "POS", "E3POS", "E6POS")
AXES = ("AXIS", "E3AXIS", "E6AXIS")
LARGEST = 2**31 - 1
"""The largest INT."""


@dataclass(frozen=True, slots=True)
class Type:
    """A type by its name in capitals; an array if it has dimensions. `UNKNOWN` fits every type."""

    name: str
    dimensions: int = 0
    sizes: tuple[int, ...] = field(default=(), compare=False)
    """The last index of each dimension where it is known: 0 or nothing where it is not."""

    def __str__(self) -> str:
        return self.name + (f"[{',' * (self.dimensions - 1)}]" if self.dimensions else "")

    @property
    def element(self) -> Type:
        """The type of one element."""
        return Type(self.name)

    def accepts(self, value: Type) -> bool:
        """Whether a value of that type may be assigned: numbers to numbers, poses to poses, axes to axes.

        >>> INT.accepts(REAL), BOOL.accepts(INT), FRAME.accepts(Type("E6POS"))
        (True, False, True)
        """
        if "?" in (self.name, value.name) or self == value:
            return True
        groups = (NUMBERS, CARTESIAN, AXES)
        return self.dimensions == value.dimensions and any(self.name in g and value.name in g for g in groups)


UNKNOWN = Type("?")
INT, REAL, BOOL, CHAR = (Type(name) for name in ("INT", "REAL", "BOOL", "CHAR"))
FRAME = Type("FRAME")


def _fields(kind: str, names: str) -> dict[str, Type]:
    return {name: Type(kind) for name in names.split()}


_PLACE = _fields("REAL", "X Y Z A B C")
_BRANCH = _fields("INT", "S T")
_E3, _E6 = _fields("REAL", "E1 E2 E3"), _fields("REAL", "E1 E2 E3 E4 E5 E6")
_AXES = _fields("REAL", "A1 A2 A3 A4 A5 A6")

GEOMETRY: Mapping[str, Mapping[str, Type]] = {
    "FRAME": _PLACE,
    "POS": _PLACE | _BRANCH,
    "E3POS": _PLACE | _BRANCH | _E3,
    "E6POS": _PLACE | _BRANCH | _E6,
    "AXIS": _AXES,
    "E3AXIS": _AXES | _E3,
    "E6AXIS": _AXES | _E6,
}
"""The structures of the language itself: name -> component -> its type."""


@dataclass(frozen=True, slots=True)
class FunctionParameter:
    """A parameter of a function of the controller; `optional` may be left out."""

    name: str
    type: Type
    mode: str = "IN"
    """IN or OUT."""
    optional: bool = False

    def __str__(self) -> str:
        return f"{self.type} {self.name}:{self.mode}{'?' if self.optional else ''}"


@dataclass(frozen=True, slots=True)
class Function:
    """A function or subprogram of every controller, or of an option package."""

    returns: Type | None
    """None for a subprogram without a value."""
    parameters: tuple[FunctionParameter, ...] = ()
    open: bool = False
    """Whether it takes any more arguments."""

    @property
    def least(self) -> int:
        """Fewest arguments."""
        return sum(not p.optional for p in self.parameters)

    @property
    def most(self) -> int:
        """Most arguments."""
        return 99 if self.open else len(self.parameters)


@dataclass(frozen=True, slots=True)
class Origin:
    """Who brings a name: a package ("KSS" is the kernel), its group, and a version of KSS that has it, where known."""

    title: str
    package: str
    kss: str | None = None

    def __str__(self) -> str:
        version = f" {self.kss}" if self.kss else ""
        return f"{self.package}{version}: {self.title}" if self.package == "KSS" else f"{self.package}: {self.title}"


@dataclass(frozen=True, slots=True, eq=False)
class KnownNames:
    """Names by kind, in capitals; `structures` and `enums` as declared, the `open` ones have more members."""

    functions: dict[str, Function] = field(default_factory=dict)
    variables: dict[str, Type] = field(default_factory=dict)
    structures: dict[str, Mapping[str, Type]] = field(default_factory=dict)
    enums: dict[str, frozenset[str]] = field(default_factory=dict)
    open: set[str] = field(default_factory=set)
    """Structures and enumerations with members that are not listed."""
    read_only: set[str] = field(default_factory=set)
    """Variables that a program cannot write."""
    origins: dict[str, Origin] = field(default_factory=dict)

    def copy(self) -> KnownNames:
        """Names of its own, equal to these."""
        return KnownNames(*(getattr(self, name).copy() for name in self.__slots__))

    def text(self, name: str) -> str | None:
        """One line about a name: its declaration and its origin; None for an unknown name."""
        key = name.upper()
        if key in self.functions:
            x = self.functions[key]
            parameters = ", ".join([*map(str, x.parameters), *(["..."] if x.open else [])])
            said = f"{'DEF' if x.returns is None else f'DEFFCT {x.returns}'} {key}({parameters})"
        elif key in self.variables:
            said = f"{self.variables[key]} {key}{', read-only' if key in self.read_only else ''}"
        elif key in self.structures:
            said = f"STRUC {key} {', '.join(f'{kind} {part}' for part, kind in self.structures[key].items())}"
        elif key in self.enums:
            said = f"ENUM {key} {', '.join(sorted(self.enums[key]))}"
        else:
            return None
        more = ", ..." if key in self.open else ""
        origin = self.origins.get(key)
        return f"{said}{more} ({origin})" if origin else said + more


MOST_BYTES = 10_000_000
"""[bytes] A larger file of names is refused."""

_FIELDS = {"title": str, "package": str, "kss": str, "functions": list, "variables": list, "read_only": list,
           "structures": dict, "enumerations": dict}  # fmt: skip

_NAME = r"[A-Za-z_$][A-Za-z0-9_$]*"
_TYPE = rf"{_NAME}(?:\[[0-9, ]*\])?"
_FUNCTION = re.compile(rf"\s*(?:({_TYPE})\s+)?({_NAME})\s*\((.*)\)\s*", re.DOTALL)
_PARAMETER = re.compile(rf"\s*(OUT\s+)?({_TYPE})\s+({_NAME})\s*(\?)?\s*")
_DECLARED = re.compile(rf"\s*(?:({_NAME})\s+)?({_NAME})(\[[0-9, ]*\])?\s*")
_COMMA = re.compile(r",(?![^\[\]]*\])")
"""Not the one in `REAL[8,2]`."""


def known_names(extra: Iterable[str | Path] = ()) -> KnownNames:
    """The built-in names with those of the user's files; a later file replaces names of an earlier one.

    Raises `FileAccessError`, `OptionError`.

    >>> known_names().functions["STRADD"].parameters[0].mode
    'OUT'
    """
    paths = tuple(str(path) for path in extra)
    if not paths:
        return _built_in()
    out = _built_in().copy()
    for path in paths:
        try:
            text = read_bytes(path, "a file of names, .toml", MOST_BYTES).decode("utf-8")
        except UnicodeDecodeError:
            raise FileAccessError(path, "is no text in UTF-8", "a file of names, .toml") from None
        _read(out, path, text)
    return out


@lru_cache(maxsize=1)
def _built_in() -> KnownNames:
    out = KnownNames()
    out.structures.update(GEOMETRY)
    for name in ("system.toml", "kernel.toml", "options.toml"):
        _read(out, name, files("lwr_dyn.krl.names").joinpath(name).read_text(encoding="ascii"))
    return out


def _read(out: KnownNames, file: str, text: str) -> None:
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise OptionError(file, str(fault), "TOML with [[group]]") from None
    groups = data.pop("group", None)
    if data or not isinstance(groups, list) or not groups or not all(isinstance(g, dict) for g in groups):
        raise OptionError(file, ", ".join(data) or "no [[group]]", "one or more [[group]], and nothing else")
    for i, group in enumerate(groups):
        _read_group(out, f"{file}, group {group.get('title', i + 1)!s}", group)


def _read_group(out: KnownNames, where: str, group: Mapping[str, Any]) -> None:
    for key, value in group.items():
        if key not in _FIELDS or not isinstance(value, _FIELDS[key]):
            raise OptionError(f"{where}: {key}", repr(value)[:60], f"one of {', '.join(_FIELDS)}, as in kernel.toml")
    origin = Origin(group.get("title", ""), group.get("package", "a file of names"), group.get("kss"))
    for text in group.get("functions", ()):
        name, function = _function_of(f"{where}: functions", text)
        out.functions[name], out.origins[name] = function, origin
    _read_variables(out, where, group, origin)
    for name, text in group.get("structures", {}).items():
        members, more = _declared_in(f"{where}: structures.{name}", text)
        _enter(out, where, name, more, origin)
        out.structures[name.upper()] = members
    for name, text in group.get("enumerations", {}).items():
        constants = _text(f"{where}: enumerations.{name}", text).upper().split()
        _enter(out, where, name, "..." in constants, origin)
        out.enums[name.upper()] = frozenset(constants) - {"..."}


def _read_variables(out: KnownNames, where: str, group: Mapping[str, Any], origin: Origin) -> None:
    for text in group.get("variables", ()):
        for name, kind in _declared_in(f"{where}: variables", text)[0].items():
            out.variables[name], out.origins[name] = kind, origin
    for text in group.get("read_only", ()):
        out.read_only.update(_text(f"{where}: read_only", text).upper().split())


def _enter(out: KnownNames, where: str, name: str, more: bool, origin: Origin) -> None:
    if not re.fullmatch(_NAME, name):
        raise OptionError(where, repr(name), "a name of KRL")
    key = name.upper()
    out.structures.pop(key, None)
    out.enums.pop(key, None)
    out.open.discard(key)
    out.origins[key] = origin
    if more:
        out.open.add(key)


def _function_of(where: str, text: object) -> tuple[str, Function]:
    match = _FUNCTION.fullmatch(_text(where, text))
    if match is None:
        raise OptionError(where, repr(text), '"TYPE NAME(TYPE a, OUT TYPE b, TYPE c?)"')
    parts = [part for part in _COMMA.split(match[3]) if part.strip()]
    more = bool(parts) and parts[-1].split()[-1] == "..."
    parameters = tuple(_parameter_of(where, part) for part in (parts[:-1] if more else parts))
    return match[2].upper(), Function(None if match[1] is None else _type_of(match[1]), parameters, more)


def _parameter_of(where: str, text: str) -> FunctionParameter:
    match = _PARAMETER.fullmatch(text)
    if match is None:
        raise OptionError(where, repr(text.strip()), "TYPE name, OUT TYPE name, or TYPE name? if it may be left out")
    return FunctionParameter(match[3], _type_of(match[2]), "OUT" if match[1] else "IN", bool(match[4]))


def _declared_in(where: str, text: object) -> tuple[dict[str, Type], bool]:
    """The names of `TYPE a, b[3], TYPE c` with their types, and whether `...` stands at the end."""
    out: dict[str, Type] = {}
    kind = None
    parts = _COMMA.split(_text(where, text))
    more = parts[-1].strip() == "..."
    for part in parts[:-1] if more else parts:
        match = _DECLARED.fullmatch(part)
        kind = match[1] or kind if match else None
        if match is None or kind is None:
            raise OptionError(where, repr(part.strip()), "TYPE name, name[12], TYPE name")
        out[match[2].upper()] = _type_of(kind + (match[3] or ""))
    return out, more


def _type_of(text: str) -> Type:
    name, bracket, sizes = text.partition("[")
    name = "?" if name.upper() == "ANY" else name.upper()
    if not bracket:
        return Type(name)
    numbers = tuple(int(n) if n.strip() else 0 for n in sizes.rstrip("]").split(","))
    return Type(name, len(numbers), numbers if any(numbers) else ())


def _text(where: str, text: object) -> str:
    if not isinstance(text, str):
        raise OptionError(where, repr(text)[:60], "text")
    return text


_NAMES = known_names()
SYSTEM: Mapping[str, Type] = {name: kind for name, kind in _NAMES.variables.items() if name.startswith("$")}
"""System variables whose type is known here; any other name that begins with $ is one of unknown type."""
CONFIG: Mapping[str, Type] = {name: kind for name, kind in _NAMES.variables.items() if not name.startswith("$")}
"""Other variables: those of the standard `$config.dat` and of option packages."""
