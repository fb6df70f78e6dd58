"""What works a closed form's text out for one pose: machine code where LLVM is installed, else Python; the same bits.

A runner is made for one arm. It takes a pose and gives the numbers of `solutions`, at the places of
`arm_numbers.places`, or None for what is no pose. Copies whole turns apart are listed by it when asked for.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from types import CodeType
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.kinematics.closed_forms import tree
from lwr_dyn.kinematics.closed_forms.python_text import python_text
from lwr_dyn.kinematics.closed_forms.text_parser import parsed
from lwr_dyn.kinematics.closed_forms.texts import (
    ANGLE_NUMBERS,
    closed_form_text,
    used_functions,
    with_own_angles,
)
from lwr_dyn.kinematics.solution import TURN

ENTRY = "solutions"
"""The function of the text that a runner calls for a pose."""

ROWS = "rows"
"""The one that it calls for copies."""

RESIDUALS = "residuals"
"""The one that finds residuals, in Python beside the rows."""

RowsOf = Callable[[Array, int], Array]
"""From the numbers of `solutions` and how many copies there are to `SolutionRows.numbers`, by falling margin; residuals
that are not known yet are found and put in their places."""


@dataclass(frozen=True, slots=True, eq=False)
class Runner:
    """Of one arm."""

    run: Callable[..., Array | None]
    """From a pose (4, 4) of float64, and for an S-R-S arm arm angle and margin [rad], to the numbers of `solutions`."""
    rows_of: RowsOf


RUNNERS: Registry[Callable[[tuple[str, ...], Mapping[str, Any]], Runner]] = Registry(
    "runner of closed forms",
    {
        "compiled": Row("lwr_dyn.codegen.branches.compiled_text:compiled_runner", "machine code, made once", "batch"),
        "python": Row("lwr_dyn.kinematics.closed_forms.runners:python_runner", "plain Python"),
    },
)
"""Factories of (texts, numbers), the fastest first."""


def runner(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> Runner:
    """The first one whose packages are installed."""
    try:
        return RUNNERS.load("compiled")(texts, numbers)
    except MissingPackageError:
        return RUNNERS.load("python")(texts, numbers)


@cache
def text_tree(texts: tuple[str, ...], wholes: tuple[tuple[str, int], ...], *entries: str) -> tree.CText:
    """The tree of what functions need of these texts, with these whole numbers put in."""
    text = used_functions(with_own_angles(closed_form_text(*texts)), entries)
    return parsed(text, dict(wholes))


def whole_numbers(numbers: Mapping[str, Any]) -> tuple[tuple[str, int], ...]:
    """Those that are whole, by name."""
    return tuple(sorted((name, x) for name, x in {**ANGLE_NUMBERS, **numbers}.items() if isinstance(x, int)))


@lru_cache(maxsize=32)
def _python_code(
    texts: tuple[str, ...], wholes: tuple[tuple[str, int], ...], plain: tuple[tuple[str, float], ...]
) -> CodeType:
    known = {**python_names({}), **dict(plain)}
    text = python_text(
        text_tree(texts, wholes, ENTRY, RESIDUALS), {k: x for k, x in known.items() if isinstance(x, float)}
    )
    return compile(text, f"<{' '.join(texts)}>", "exec")


def _plain_numbers(numbers: Mapping[str, Any]) -> tuple[tuple[str, float], ...]:
    """Which joints are limited, and zeros and ones of the links' frames.

    In a residual they are multiplied with finite numbers, and no zero's sign counts.
    """
    flat = {**python_names({"FRAMES": numbers["FRAMES"]}), **python_names({"LIMITED": numbers["LIMITED"]})}
    return tuple((name, x) for name, x in flat.items() if name not in ANGLE_NUMBERS and x in (0.0, 1.0, -1.0))


def python_names(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """What the Python text takes from outside: each array, and each of its numbers as NAME_PLACE."""
    names: dict[str, Any] = {}
    for name, value in {**ANGLE_NUMBERS, **numbers}.items():
        flat = np.ravel(np.asarray(value, dtype=np.float64)).tolist()
        names |= {name: tuple(flat) if np.ndim(value) else flat[0], **{f"{name}_{i}": x for i, x in enumerate(flat)}}
    return names


def python_runner(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> Runner:
    """The row "python" of `RUNNERS`: the texts are written and compiled once for arms with the same plain frames."""
    wholes, names = whole_numbers(numbers), python_names(numbers)
    exec(_python_code(texts, wholes, _plain_numbers(numbers)), names)
    function, size, at = names[ENTRY], numbers["SIZE"], numbers["RESIDUAL"]

    def run(pose: Array, *more: float) -> Array | None:
        out = [0.0] * size
        return None if function([*pose.ravel().tolist(), *more], out) else np.array(out)

    def rows_of(out: Array, count: int) -> Array:
        if not numbers["IS_CHECKED"]:
            listed = out.tolist()
            names[RESIDUALS](listed)
            out[at : at + 8] = listed[at : at + 8]
        return numpy_rows(numbers, out, count)

    return Runner(run, rows_of)


@cache
def _turns(many: tuple[int, ...]) -> Array:
    """All places (k, n) of a grid with so many of each, the last joint first."""
    return read_only(np.indices(many).reshape(len(many), -1).T)


def numpy_rows(numbers: Mapping[str, Any], out: Array, count: int) -> Array:
    """The rows of `Runner.rows_of` in NumPy, with the bits of the text `rows`."""
    n, copies = numbers["JOINTS"], out[numbers["COPIES"] :][:8].tolist()
    first, many = out[numbers["FIRST"] :][: 8 * n], out[numbers["MANY"] :][: 8 * n].tolist()
    listed = []
    for b, x in enumerate(out[: 8 * n : n].tolist()):
        at = slice(n * b, n * b + n)
        if x == x and copies[b]:
            listed.append((b, out[at] + TURN * (first[at] + _turns(tuple(map(int, many[at]))))))
        elif x == x:
            listed.append((b, out[None, at]))
    rows = np.empty((count, n + 3))
    rows[:, :n] = np.concatenate([q for _, q in listed])
    room = np.minimum(numbers["UP"] - rows[:, :n], rows[:, :n] - numbers["LOW"])
    rows[:, n + 1] = joint = room.argmin(axis=1)
    rows[:, n] = room[np.arange(count), joint]
    rows[:, n + 2] = np.repeat([b for b, _ in listed], [len(q) for _, q in listed])
    return frozen(rows[np.argsort(-rows[:, n], kind="stable")])


def frozen(rows: Array) -> Array:
    """The array itself, read-only from now on."""
    rows.flags.writeable = False
    return rows
