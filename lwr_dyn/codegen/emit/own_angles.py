"""Sine, cosine, arctangent and arccosine as functions of a text: products, sums and quotients in a fixed order.

So inverse kinematics has the same bits on every machine. Of angles up to 1.6e6 rad; atan2 errs by at most 1.6 units in
the last place, acos by 2, sine and cosine by 3e-16.
"""

import re
from functools import cache
from importlib.resources import files
from typing import Any

import mpmath
import numpy as np

from lwr_dyn.codegen.kernels.sincos import sincos

_NAMES = re.compile(r"\b(sin|cos|atan2|acos)\(")
_DIGITS, _TERMS = 40, 12


def with_own_angles(text: str) -> str:
    """A text whose calls of sin, cos, atan2 and acos are those of functions in front of it."""
    own = (files("lwr_dyn.codegen.emit") / "own_angles.c").read_text(encoding="utf-8")
    return own + "\n" + _NAMES.sub(r"own_\1(", text)


@cache
def angle_constants() -> dict[str, Any]:
    """The numbers of these functions."""
    numbers = sincos("float64")
    with mpmath.workdps(_DIGITS):
        eighths = [k * mpmath.pi / 4 for k in range(5)]
        near = [float(x) for x in eighths]
        rest = [float(x - mpmath.mpf(y)) for x, y in zip(eighths, near, strict=True)]
        arctangent = [float(c) for c in mpmath.chebyfit(_arctangent_rest, [0, mpmath.mpf(1) / 4], _TERMS)]
    lists: dict[str, Any] = {
        "PI_PARTS": numbers.pi_parts, "SINE": numbers.sine, "COSINE": numbers.cosine, "ARCTANGENT": arctangent,
        "EIGHTHS": near, "EIGHTHS_REST": rest,
    }  # fmt: skip
    counts = {f"{name}_TERMS": len(lists[name]) for name in ("SINE", "COSINE", "ARCTANGENT")}
    return lists | counts | {"MAGIC": numbers.magic, "PER_HALF_TURN": float(1.0 / np.pi)}


def _arctangent_rest(z: Any) -> Any:
    """(atan t - t) / t^3 at z = t^2, by its series."""
    return mpmath.fsum((-1) ** (k + 1) * z**k / (2 * k + 3) for k in range(90))
