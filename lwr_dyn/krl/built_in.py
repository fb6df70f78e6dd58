"""Functions that every controller has: expressions as arguments, angles of SIN, COS ... in degrees."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lwr_dyn.krl import expressions as e
from lwr_dyn.krl.evaluate import Environment, number_of, value_of
from lwr_dyn.krl.operators import ranged
from lwr_dyn.krl.values import HaltError, Value, pose_matrix, pose_value

MATHEMATICS: dict[str, Callable[..., float]] = {
    "SQRT": math.sqrt,
    "SIN": lambda x: math.sin(math.radians(x)),
    "COS": lambda x: math.cos(math.radians(x)),
    "TAN": lambda x: math.tan(math.radians(x)),
    "ACOS": lambda x: math.degrees(math.acos(x)),
    "ATAN2": lambda y, x: math.degrees(math.atan2(y, x)),
}


def function_value(env: Environment, x: e.Call) -> Value | None:
    """The value of a built-in function; None when there is none of that name here."""
    name = x.name.upper()
    arguments = [a for a in x.arguments if a is not None]
    if name == "ABS" and len(arguments) == 1:
        value = value_of(env, arguments[0])
        if isinstance(value, int | float) and not isinstance(value, bool):
            return ranged(abs(value))
        return abs(number_of(env, arguments[0], "ABS"))
    if name == "INV_POS" and len(arguments) == 1:
        return pose_value(
            np.asarray(np.linalg.inv(pose_matrix(value_of(env, arguments[0]), "INV_POS")), dtype=np.float64)
        )
    function = MATHEMATICS.get(name)
    if function is None:
        return None
    numbers = [number_of(env, a, f"an argument of {name}") for a in arguments]
    try:
        return ranged(function(*numbers))
    except (ValueError, TypeError):
        hint = "from -1 to 1" if name == "ACOS" else "not negative" if name == "SQRT" else "the right arguments"
        raise HaltError("number-range", f"{name} of {', '.join(map(str, numbers))}", hint) from None
