"""What works a closed form's text out for one pose: machine code where LLVM is installed, else Python; the same bits.

A runner is made for one arm. It takes a pose and gives the numbers of `solutions`, at the places of
`arm_numbers.places`, or None for what is no pose.
"""

from collections.abc import Callable, Mapping
from functools import cache
from types import CodeType
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.kinematics.closed_forms.python_text import python_text
from lwr_dyn.kinematics.closed_forms.text_parser import CText, parsed
from lwr_dyn.kinematics.closed_forms.texts import (
    ANGLE_NUMBERS,
    closed_form_text,
    used_functions,
    with_own_angles,
)

ENTRY = "solutions"
"""The function of the text that a runner calls."""

Runner = Callable[..., Array | None]
"""From a pose (4, 4), and for an S-R-S arm arm angle and margin [rad], to the result's numbers."""

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
def text_tree(texts: tuple[str, ...], wholes: tuple[tuple[str, int], ...]) -> CText:
    """The tree of what `ENTRY` needs of these texts, with these whole numbers put in."""
    text = used_functions(with_own_angles(closed_form_text(*texts)), (ENTRY,))
    return parsed(text, dict(wholes))


def whole_numbers(numbers: Mapping[str, Any]) -> tuple[tuple[str, int], ...]:
    """Those that are whole, by name."""
    return tuple(sorted((name, x) for name, x in {**ANGLE_NUMBERS, **numbers}.items() if isinstance(x, int)))


@cache
def _python_code(texts: tuple[str, ...], wholes: tuple[tuple[str, int], ...]) -> CodeType:
    return compile(python_text(text_tree(texts, wholes)), f"<{' '.join(texts)}>", "exec")


def python_names(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """What the Python text takes from outside: each array, and each of its numbers as NAME_PLACE."""
    names: dict[str, Any] = {}
    for name, value in {**ANGLE_NUMBERS, **numbers}.items():
        flat = np.ravel(np.asarray(value, dtype=np.float64)).tolist()
        names |= {name: tuple(flat) if np.ndim(value) else flat[0], **{f"{name}_{i}": x for i, x in enumerate(flat)}}
    return names


def python_runner(texts: tuple[str, ...], numbers: Mapping[str, Any]) -> Runner:
    """The row "python" of `RUNNERS`: the texts are written and compiled once, arms differ in the names around them."""
    wholes, names = whole_numbers(numbers), python_names(numbers)
    exec(_python_code(texts, wholes), names)
    function, size = names[ENTRY], dict(wholes)["SIZE"]

    def run(pose: Array, *more: float) -> Array | None:
        out = [0.0] * size
        return None if function([*pose.ravel().tolist(), *more], out) else np.array(out)

    return run
