"""Values while a program runs: numbers, truth, text, structures, arrays, and the places that hold them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.kuka_pose import KukaPose, pose_of_matrix
from lwr_dyn.krl.types import AXES, CARTESIAN, LARGEST, Type

AXIS_NAMES = ("A1", "A2", "A3", "A4", "A5", "A6")
PLACE_NAMES = ("X", "Y", "Z", "A", "B", "C")


class HaltError(Exception):
    """The program cannot go on: a code, what, and a hint. Never leaves this room."""

    def __init__(self, code: str, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.code, self.message, self.hint = code, message, hint


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant of an enumeration, in capitals."""

    name: str


@dataclass(slots=True)
class Struct:
    """A structure: the name of its type ("?" when it stands alone) and the components that have a value."""

    type: str
    parts: dict[str, Value] = field(default_factory=dict)


@dataclass(slots=True)
class Many:
    """An array: its element's type, its sizes (() where they are open), and the elements that have a value."""

    type: str
    sizes: tuple[int, ...]
    items: dict[tuple[int, ...], Value] = field(default_factory=dict)


Value: TypeAlias = "int | float | bool | str | Constant | Struct | Many"


@dataclass(slots=True)
class Slot:
    """A place that holds a value; None while it has none."""

    type: Type
    value: Value | None = None


@dataclass(frozen=True, slots=True)
class Target:
    """Something that can be read and assigned: a variable, an element, a component."""

    read: Callable[[], Value | None]
    write: Callable[[Value], None]
    type: Type


def copied(value: Value) -> Value:
    """A copy that shares nothing."""
    if isinstance(value, Struct):
        return Struct(value.type, {k: copied(v) for k, v in value.parts.items()})
    if isinstance(value, Many):
        return Many(value.type, value.sizes, {k: copied(v) for k, v in value.items.items()})
    return value


def converted(value: Value, to: Type) -> Value:
    """A value as it goes into a variable: REAL to INT rounds, INT to REAL widens; raises `HaltError`."""
    if to.name == "?":
        return copied(value)
    if to.name in ("INT", "REAL") and not to.dimensions:
        return _number(value, to.name)
    if to.name == "BOOL" and not isinstance(value, bool) and not to.dimensions:
        raise HaltError("type", f"BOOL is given {said(value)}", "TRUE or FALSE")
    out = copied(value)
    if isinstance(out, Struct) and not to.dimensions:
        out.type = to.name
    return out


def _number(value: Value, name: str) -> int | float:
    if isinstance(value, str) and len(value) == 1:
        value = ord(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise HaltError("type", f"{name} is given {said(value)}", "a number")
    if not math.isfinite(value):
        raise HaltError("number-range", f"the value {value} is no number", "")
    if name == "REAL":
        return float(value)
    rounded = math.floor(value + 0.5)
    if abs(rounded) > LARGEST + 1:
        raise HaltError("number-range", f"{rounded} is no INT", f"from {-LARGEST - 1} to {LARGEST}")
    return rounded


def said(value: Value | None) -> str:
    """A value in a message."""
    if value is None:
        return "nothing"
    if isinstance(value, Struct):
        return "{" + ", ".join(f"{k} {said(v)}" for k, v in value.parts.items()) + "}"
    if isinstance(value, Constant):
        return f"#{value.name}"
    if isinstance(value, Many):
        return f"an array of {value.type}"
    return str(value).upper() if isinstance(value, bool) else str(value)


def is_axes(value: Struct) -> bool:
    """Whether a structure holds axes rather than a pose."""
    return value.type in AXES or (value.type == "?" and any(name in value.parts for name in AXIS_NAMES))


def is_pose(value: Struct) -> bool:
    """Whether a structure holds a pose."""
    return value.type in CARTESIAN or (value.type == "?" and bool(value.parts) and not is_axes(value))


def pose_matrix(value: Value | None, what: str) -> Array:
    """The pose (4, 4) [m] of X, Y, Z, A, B, C; raises `HaltError` where one of them is missing."""
    if not isinstance(value, Struct) or not is_pose(value):
        raise HaltError("type", f"{what} is {said(value)}", "a FRAME, POS or E6POS")
    numbers = [value.parts.get(name) for name in PLACE_NAMES]
    missing = [name for name, x in zip(PLACE_NAMES, numbers, strict=True) if not isinstance(x, int | float)]
    if missing:
        raise HaltError("no-value", f"{what} has no {', '.join(missing)}", "a pose needs X, Y, Z, A, B, C")
    return KukaPose(*(float(x) for x in numbers)).matrix()  # type: ignore[arg-type]


def pose_value(T: Array, type_name: str = "FRAME", rest: Mapping[str, Value] | None = None) -> Struct:
    """A pose (4, 4) [m] as a structure; `rest` adds S, T and external axes."""
    p = pose_of_matrix(T)
    parts = dict(zip(PLACE_NAMES, (p.x_mm, p.y_mm, p.z_mm, p.a_deg, p.b_deg, p.c_deg), strict=True))
    return Struct(type_name, {**parts, **(rest or {})})


def axes_value(q: Array, type_name: str = "E6AXIS") -> Struct:
    """Axes [rad] as a structure [deg], external axes at 0."""
    values = dict(zip(AXIS_NAMES, map(float, np.degrees(q)), strict=True))
    return Struct(type_name, {**values, **{f"E{i}": 0.0 for i in range(1, 7)}})


def struct(type_name: str, **parts: Value) -> Struct:
    """A structure written by hand."""
    return Struct(type_name, dict(parts))


def filled(type_name: str, values: Iterable[Value]) -> Many:
    """An array of one dimension."""
    items: dict[tuple[int, ...], Value] = {(i + 1,): v for i, v in enumerate(values)}
    return Many(type_name, (len(items),), items)


def null_frame() -> Struct:
    """The frame of nothing: all zero."""
    return Struct("FRAME", dict.fromkeys(PLACE_NAMES, 0.0))
