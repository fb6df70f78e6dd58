"""The values of the controller's own functions: mathematics, geometry, text, and those of the inline forms."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import nearest_solution
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import Environment, number_of, reference_to, value_of
from lwr_dyn.krl.running.inline_functions import INLINE
from lwr_dyn.krl.running.operators import ranged
from lwr_dyn.krl.running.text_functions import TEXT
from lwr_dyn.krl.running.values import AXIS_NAMES, StructValue, Value, axes_value, pose_matrix, pose_value
from lwr_dyn.krl.running.variable_state import variable_state

Arguments: TypeAlias = Sequence[e.Expression]


def function_value(env: Environment, c: ControllerState, x: e.FunctionCall) -> Value | None:
    """The value of a function of the controller; None where the model does not compute it; raises `ExecutionError`."""
    name = x.name.upper()
    arguments = [a for a in x.arguments if a is not None]
    if name == "FRAND":
        c.assumptions.note("FRAND", "", "the middle of its range")
    if name in MATHEMATICS:
        return _number(env, name, arguments)
    if name in TEXT:
        return TEXT[name](env, arguments)
    if name in INLINE:
        return INLINE[name](c, [value_of(env, a) for a in arguments], env)
    if name in GEOMETRY:
        return GEOMETRY[name](env, c, arguments)
    return None


def is_computed(name: str) -> bool:
    """Whether the model computes this function."""
    return any(name.upper() in table for table in (MATHEMATICS, TEXT, INLINE, GEOMETRY))


MATHEMATICS: dict[str, Callable[..., int | float]] = {
    "ABS": abs,
    "SQRT": math.sqrt,
    "SIN": lambda x: math.sin(math.radians(x)),
    "COS": lambda x: math.cos(math.radians(x)),
    "TAN": lambda x: math.tan(math.radians(x)),
    "ACOS": lambda x: math.degrees(math.acos(x)),
    "ATAN2": lambda y, x: math.degrees(math.atan2(y, x)),
    "FRAND": lambda least, most: 0.5 * (least + most),
}
"""Of numbers; angles in degrees."""
_HINTS = {"ACOS": "from -1 to 1", "SQRT": "not negative", "ATAN2": "two numbers", "FRAND": "the least and the most"}


def _number(env: Environment, name: str, arguments: Arguments) -> int | float:
    numbers: list[int | float] = []
    for a in arguments:
        value = value_of(env, a)
        whole = isinstance(value, int) and not isinstance(value, bool) and name == "ABS"
        numbers.append(value if whole else number_of(env, a, f"an argument of {name}"))  # type: ignore[arg-type]
    try:
        return ranged(MATHEMATICS[name](*numbers))
    except (ValueError, TypeError):
        hint = _HINTS.get(name, "one number")
        raise ExecutionError("number-range", f"{name} of {', '.join(map(str, numbers))}", hint) from None


def _inv_pos(env: Environment, c: ControllerState, arguments: Arguments) -> Value:
    point = value_of(env, _at(arguments, 0, "INV_POS"))
    inverse = np.linalg.inv(pose_matrix(point, "INV_POS"))
    return pose_value(np.asarray(inverse, dtype=np.float64), point.type if isinstance(point, StructValue) else "FRAME")


def _forward(env: Environment, c: ControllerState, arguments: Arguments) -> Value:
    q = _axes(value_of(env, _at(arguments, 0, "FORWARD")), "FORWARD")
    _set_status(env, arguments, 1, 0)
    return c.pose_at(q)


def _axes(value: Value, what: str) -> Array:
    """A1 to A6 (6,) [rad] of a structure; raises `ExecutionError` where one is missing."""
    parts = value.parts if isinstance(value, StructValue) else {}
    angles = [parts.get(name) for name in AXIS_NAMES]
    if not all(isinstance(a, int | float) for a in angles):
        raise ExecutionError("no-value", f"{what} needs A1 to A6", "an E6AXIS with all six axes")
    return np.asarray(np.radians(np.array(angles, dtype=float)))


def _inverse(env: Environment, c: ControllerState, arguments: Arguments) -> Value:
    point = value_of(env, _at(arguments, 0, "INVERSE"))
    if not isinstance(point, StructValue):
        raise ExecutionError("type", "INVERSE of what is no structure", "an E6POS")
    start = _axes(value_of(env, _at(arguments, 1, "INVERSE")), "the start of INVERSE")
    flange = np.asarray(c.base @ pose_matrix(point, "INVERSE") @ np.linalg.inv(c.tool))
    try:
        result = inverse_kinematics(c.arm, flange)
    except LwrDynError as fault:
        raise ExecutionError("not-modelled", str(fault)) from None
    matching = [x for x in result.solutions if _fits(c, x.q, point)]
    _set_status(env, arguments, 2, 0 if matching else 2)
    return axes_value(nearest_solution(matching, start).q if matching else start)


def _fits(c: ControllerState, q: np.ndarray, point: StructValue) -> bool:
    """Whether the axes have the Status and Turn that the point gives."""
    at = c.pose_at(q).parts
    return all(point.parts.get(name) in (None, at[name]) for name in ("S", "T"))


def _set_status(env: Environment, arguments: Arguments, at: int, status: int) -> None:
    """The last argument of FORWARD and INVERSE: 0 where there is a solution."""
    if at < len(arguments) and isinstance(arguments[at], e.Name | e.Index | e.Component):
        reference_to(env, arguments[at]).write(status)  # type: ignore[arg-type]


def _at(arguments: Arguments, i: int, name: str) -> e.Expression:
    if i >= len(arguments):
        raise ExecutionError("arguments", f"{name} with {len(arguments)} arguments", "more of them")
    return arguments[i]


GEOMETRY: dict[str, Callable[[Environment, ControllerState, Arguments], Value]] = {
    "INV_POS": _inv_pos,
    "FORWARD": _forward,
    "INVERSE": _inverse,
    "VARSTATE": variable_state,
}
