"""Names that need no declaration, read from TOML: kernel.toml, options.toml, and a user's files of the same form."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import read_bytes
from lwr_dyn.krl.names.known import Function, FunctionParameter, KnownNames, Origin
from lwr_dyn.krl.names.types import GEOMETRY, Type

LARGEST = 10_000_000
"""[bytes] A larger file of names is refused."""
_FIELDS = {"title": str, "package": str, "kss": str, "functions": list, "variables": list, "structures": dict,
           "enumerations": dict}  # fmt: skip
_NAME = r"[A-Za-z_$][A-Za-z0-9_$]*"
_TYPE = rf"{_NAME}(?:\[[0-9, ]*\])?"
_FUNCTION = re.compile(rf"\s*(?:({_TYPE})\s+)?({_NAME})\s*\((.*)\)\s*", re.DOTALL)
_PARAMETER = re.compile(rf"\s*(OUT\s+)?({_TYPE})\s+({_NAME})\s*(\?)?\s*")
_DECLARED = re.compile(rf"\s*(?:({_NAME})\s+)?({_NAME})(\[[0-9, ]*\])?\s*")


def known_names(extra: Iterable[str | Path] = ()) -> KnownNames:
    """The built-in names with those of the user's files; a later file replaces names of an earlier one.

    Raises `FileAccessError`, `OptionError`.

    >>> known_names().functions["STRADD"].parameters[0].mode
    'OUT'
    """
    paths = tuple(str(path) for path in extra)
    return _extended(paths) if paths else _built_in()


@lru_cache(maxsize=1)
def _built_in() -> KnownNames:
    out = KnownNames()
    out.structures.update(GEOMETRY)
    for name in ("kernel.toml", "options.toml"):
        _read(out, name, files("lwr_dyn.krl.names").joinpath(name).read_text(encoding="ascii"))
    return out


def _extended(paths: Sequence[str]) -> KnownNames:
    out = _built_in().copy()
    for path in paths:
        try:
            text = read_bytes(path, "a file of names, .toml", LARGEST).decode("utf-8")
        except UnicodeDecodeError:
            raise FileAccessError(path, "is no text in UTF-8", "a file of names, .toml") from None
        _read(out, path, text)
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
    for text in group.get("variables", ()):
        for name, kind in _declared_in(f"{where}: variables", text)[0].items():
            out.variables[name], out.origins[name] = kind, origin
    for name, text in group.get("structures", {}).items():
        members, more = _declared_in(f"{where}: structures.{name}", text)
        _enter(out, where, name, more, origin)
        out.structures[name.upper()] = members
    for name, text in group.get("enumerations", {}).items():
        constants = _text(f"{where}: enumerations.{name}", text).upper().split()
        _enter(out, where, name, "..." in constants, origin)
        out.enums[name.upper()] = frozenset(constants) - {"..."}


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
    parts = [part for part in match[3].split(",") if part.strip()]
    parts = _rejoined(parts)
    more = bool(parts) and parts[-1].split()[-1] == "..."
    parameters = tuple(_parameter_of(where, part) for part in (parts[:-1] if more else parts))
    return match[2].upper(), Function(None if match[1] is None else _type_of(match[1]), parameters, more)


def _rejoined(parts: Sequence[str]) -> list[str]:
    """Put `REAL[8` and `2] a` together again."""
    out: list[str] = []
    for part in parts:
        if out and out[-1].count("[") > out[-1].count("]"):
            out[-1] += "," + part
        else:
            out.append(part)
    return out


def _parameter_of(where: str, text: str) -> FunctionParameter:
    match = _PARAMETER.fullmatch(text)
    if match is None:
        raise OptionError(where, repr(text.strip()), "TYPE name, OUT TYPE name, or TYPE name? if it may be left out")
    return FunctionParameter(match[3], _type_of(match[2]), "OUT" if match[1] else "IN", bool(match[4]))


def _declared_in(where: str, text: object) -> tuple[dict[str, Type], bool]:
    """The names of `TYPE a, b[3], TYPE c` with their types, and whether `...` stands at the end."""
    out: dict[str, Type] = {}
    kind = None
    parts = _rejoined(_text(where, text).split(","))
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
