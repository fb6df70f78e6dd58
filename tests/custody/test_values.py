"""The numbers that no user gives stay: constants, defaults of functions and records, tables, by module.

They decide verdicts, and a default is part of what a command does. Nothing here says that a number is right: this is
a record, in which a change has to be meant. One that is goes into `values.toml` (`python -m tests.custody.test_values`)
and, where a user sees it, into the changelog. Short values stand there as they are, long ones as a digest.
"""

import ast
import hashlib
import inspect
import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from pathlib import Path

import click
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
RECORD = Path(__file__).with_name("values.toml")
SHORT = 60
"""Characters of a value that is written as it is."""
OPTION = ("opts", "secondary_opts", "required", "nargs", "multiple", "hidden", "help", "type")
NUMBERS = (bool, int, float, complex)


def text(value, depth=0):
    """Of a value: the same on any machine."""
    if isinstance(value, Enum):
        return f"{type(value).__name__}.{value.name}"
    if isinstance(value, np.ndarray | np.generic):
        value = (np.round(value, 12) + 0 if np.issubdtype(value.dtype, np.floating) else value).tolist()
    if isinstance(value, float):
        return f"{value:.12g}" if value != int(value if abs(value) < 1e9 else 0.5) else f"{value:.1f}"
    if value is None or isinstance(value, str | bytes | bool | int):
        return repr(value)
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{text(k, depth + 1)}: {text(x, depth + 1)}' for k, x in value.items())}}}"
    if isinstance(value, tuple | list):
        return f"({', '.join(text(x, depth + 1) for x in value)})"
    if isinstance(value, set | frozenset):
        return f"{{{', '.join(sorted(text(x, depth + 1) for x in value))}}}"
    return of_object(value, depth)


def of_object(value, depth):
    """Records by their fields, options by what a user sees of them, functions and anything else by name."""
    if isinstance(value, re.Pattern):
        return f"{value.pattern!r}/{int(value.flags)}"
    named = type(value).__name__
    if is_dataclass(value) and not isinstance(value, type) and depth < 6:
        names = [f.name for f in fields(value)]
    elif isinstance(value, click.Option | click.Argument):
        default = value.default if isinstance(value.default, (*NUMBERS, str, tuple)) else None  # click has its own none
        return f"{named}({text([default, *(getattr(value, name, None) for name in OPTION)], depth + 1)})"
    else:
        return getattr(value, "__qualname__", named) if callable(value) else named
    return f"{named}({', '.join(f'{name}={text(getattr(value, name, None), depth + 1)}' for name in names)})"


def written(value):
    """As it stands in the record."""
    whole = text(value)
    return whole if len(whole) <= SHORT and "\n" not in whole else f"~{hashlib.sha256(whole.encode()).hexdigest()[:8]}"


def defaults(function):
    """Of its parameters that have one, but for None."""
    found = {p.name: p.default for p in inspect.signature(function).parameters.values()}
    return {name: x for name, x in found.items() if x is not inspect.Parameter.empty and x is not None}


def of_class(kind):
    """Defaults of its fields and of its methods."""
    own = {name: x for name, x in vars(kind).items() if not name.startswith("__")}
    out = {name: x for name, x in own.items() if isinstance(x, NUMBERS) and name != "_is_protocol"}
    if is_dataclass(kind):
        out |= {field.name: field.default for field in fields(kind) if isinstance(field.default, (*NUMBERS, tuple))}
    for name, x in own.items():
        if inspect.isfunction(method := getattr(x, "__func__", x)):
            out |= {f"{name}({k})": y for k, y in defaults(method).items()}
    return {f"{kind.__name__}.{name}": x for name, x in out.items()}


def names_of(node):
    """That a statement of a module binds, but for imports."""
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    flat = [x for y in targets for x in (y.elts if isinstance(y, ast.Tuple) else [y])]
    return [x.id for x in flat if isinstance(x, ast.Name)] + [getattr(node, "name", "")]


def is_filled_later(node):
    """Whether a statement binds an empty list or table, as of what a process keeps."""
    value = getattr(node, "value", None)
    return isinstance(value, ast.Dict | ast.List) and not (getattr(value, "keys", None) or getattr(value, "elts", None))


def values(path):
    """Of a module: name and value, what has neither number nor yes or no left out."""
    module, out = import_module(".".join(path.relative_to(ROOT).with_suffix("").parts)), {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        for name in (x for x in names_of(node) if x in vars(module)):
            x = vars(module)[name]
            if inspect.isclass(x) and isinstance(node, ast.ClassDef):
                out |= of_class(x)
            elif inspect.isfunction(x):
                out |= {f"{name}({k})": y for k, y in defaults(x).items()}
            elif name.isupper() and not is_filled_later(node):
                out[name] = x
    shown = {name: written(x) for name, x in out.items()}
    return "; ".join(f"{name} {x}" for name, x in shown.items() if re.search(r"\d|True|False|~", x))


def recorded(package):
    """Module -> its values, of those that have any."""
    paths = [p for p in sorted((ROOT / "lwr_dyn" / package).rglob("*.py")) if p.stem not in ("__init__", "__main__")]
    names = [p.relative_to(ROOT / "lwr_dyn").with_suffix("").as_posix() for p in paths]
    return {name: found for name, path in zip(names, paths, strict=True) if (found := values(path))}


PACKAGES = sorted(path.parent.name for path in (ROOT / "lwr_dyn").glob("*/__init__.py"))


@pytest.mark.parametrize("package", PACKAGES)
def test_the_values_of_a_package_are_those_recorded(package):
    record = tomllib.loads(RECORD.read_text(encoding="utf-8"))
    here, there = recorded(package), {name: x for name, x in record.items() if name.startswith(f"{package}/")}
    changed = [name for name in here.keys() | there.keys() if here.get(name) != there.get(name)]
    assert {name: (there.get(name), here.get(name)) for name in changed} == {}


def test_a_changed_value_is_seen():
    assert [written(x) for x in (0.1, 0.2, 3.0, True)] == ["0.1", "0.2", "3.0", "True"]
    assert written({"a": (1, 2.0)}) == "{'a': (1, 2.0)}" != written({"a": (1, 2)})
    long = [tuple(range(50)), tuple(range(1, 51))]
    assert len({written(x) for x in long}) == 2
    assert {len(written(x)) for x in long} == {9}


if __name__ == "__main__":
    lines = [
        "# Constants, defaults and tables of each module: see test_values.py. A change here is one of what it does."
    ]
    every = {name: x for package in PACKAGES for name, x in recorded(package).items()}
    lines += [f"{json.dumps(name)} = {json.dumps(x, ensure_ascii=False)}" for name, x in every.items()]
    RECORD.write_text("\n".join(lines) + "\n", encoding="utf-8")
