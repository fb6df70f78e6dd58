"""Calls: the routine that one enters; else the value of a stub, or of a function of the controller.

Of mathematics, geometry, text (an array of characters), inline forms, and VARSTATE, which says whether a variable, an
element or a component is declared and has a value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.solution import nearest_solution
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language.blocks import Routine
from lwr_dyn.krl.language.line_parser import statement_of
from lwr_dyn.krl.language.statements import Assign
from lwr_dyn.krl.names.known_names import UNKNOWN, Type
from lwr_dyn.krl.running import values as v
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import Environment, number_of, reference_to, value_of
from lwr_dyn.krl.running.inline_forms import INLINE
from lwr_dyn.krl.running.running_program import RunningProgram
from lwr_dyn.krl.running.values import AXIS_NAMES, ArrayValue, EnumValue, StructValue, Value, VariableReference


def _variable(env: Environment, x: e.Expression | None) -> VariableReference | None:
    """The variable, element or component that an argument is; None for another expression."""
    return reference_to(env, x) if isinstance(x, e.Name | e.Index | e.Component) else None


def _text(env: Environment, arguments: Arguments, i: int) -> str:
    if i >= len(arguments):
        raise ExecutionError("arguments", f"{len(arguments)} arguments are too few", "a text is missing")
    variable = _variable(env, arguments[i])
    if variable is None:
        return v.text_of(value_of(env, arguments[i]))
    value = variable.read()
    return "" if value is None else v.text_of(value)


def _room(variable: VariableReference | None) -> int | None:
    """The declared number of characters of a variable; None where it is open."""
    value = None if variable is None else variable.read()
    return value.sizes[0] if isinstance(value, ArrayValue) and value.sizes else None


def _write(env: Environment, x: e.Expression, text: str) -> bool:
    """Put text into a variable; False (nothing is written) where it is longer than the variable."""
    variable = _variable(env, x)
    if variable is None:
        raise ExecutionError("type", "a text function writes into what is no variable", "a variable: T[]")
    room = _room(variable)
    if room is not None and len(text) > room:
        return False
    variable.write(v.text_array(text, () if room is None else (room,)))
    return True


def _case(env: Environment, a: Arguments, i: int) -> bool:
    """Whether capitals count, #CASE_SENS, which is the rule without the argument."""
    value = value_of(env, a[i]) if i < len(a) else EnumValue("CASE_SENS")
    return value != EnumValue("NOT_CASE_SENS")


def _declared_length(env: Environment, a: Arguments) -> Value:
    room = _room(_variable(env, a[0])) if a else None
    return len(_text(env, a, 0)) if room is None else room


def _add(env: Environment, a: Arguments) -> Value:
    whole = _text(env, a, 0) + _text(env, a, 1)
    return len(whole) if _write(env, a[0], whole) else 0


def _equal(env: Environment, a: Arguments) -> Value:
    left, right = _text(env, a, 0), _text(env, a, 1)
    return left == right if _case(env, a, 2) else left.upper() == right.upper()


def _find(env: Environment, a: Arguments) -> Value:
    """The first place from `from` on at which the second text stands in the first one, 0 for none."""
    variable = _variable(env, a[0]) if len(a) > 2 else None
    first = None if len(a) < 3 else value_of(env, a[0]) if variable is None else variable.read()
    shift = 0 if isinstance(first, int | float) else -1
    begin = int(number_of(env, a[0], "STRFIND")) if shift == 0 else 1
    within, wanted = _text(env, a, shift + 1), _text(env, a, shift + 2)
    if not _case(env, a, shift + 3):
        within, wanted = within.upper(), wanted.upper()
    return within.find(wanted, max(begin, 1) - 1) + 1


def _to(read: Callable[[str], Value]) -> Callable[[Environment, Arguments], Value]:
    """STRTOINT and the like: TRUE and the value in the second argument where the text can be read."""

    def convert(env: Environment, a: Arguments) -> Value:
        text = _text(env, a, 0)
        variable = _variable(env, a[1]) if len(a) > 1 else None
        if variable is None:
            raise ExecutionError("arguments", "no variable for the value that is read", "a variable")
        try:
            value = read(text.strip())
        except (ValueError, KeyError):
            return False
        variable.write(value)
        return True

    return convert


def _real(text: str) -> float:
    if not set(text) <= set("+-.0123456789eE"):
        raise ValueError(text)
    return float(text)


TEXT: dict[str, Callable[[Environment, Arguments], Value]] = {
    "STRLEN": lambda env, a: len(_text(env, a, 0)),
    "STRDECLLEN": _declared_length,
    "STRCLEAR": lambda env, a: bool(a) and _write(env, a[0], ""),
    "STRADD": _add,
    "STRCOPY": lambda env, a: bool(a) and _write(env, a[0], _text(env, a, 1)),
    "STRCOMP": _equal,
    "STRFIND": _find,
    "STRTOINT": _to(int),
    "STRTOREAL": _to(_real),
    "STRTOBOOL": _to(lambda text: {"TRUE": True, "FALSE": False}[text.upper()]),
    "STRTOSTRING": lambda env, a: len(a) > 1 and _write(env, a[1], _text(env, a, 0)),
}
"""Function -> its value; those with an OUT argument write into it."""


def _variable_state(m: RunningProgram, arguments: Arguments) -> Value:
    """#INITIALIZED, #DECLARED or #UNDEFINED; raises `ExecutionError` for an argument that is no text."""
    if not arguments:
        raise ExecutionError("arguments", "VARSTATE without a name", 'VARSTATE("name")')
    statement = statement_of(f"{v.text_of(value_of(m, arguments[0]))} = 0")
    try:
        if isinstance(statement, Assign):
            value = reference_to(m, statement.target).read()
            return EnumValue("DECLARED" if value is None else "INITIALIZED")
    except ExecutionError:
        pass
    return EnumValue("UNDEFINED")


Arguments: TypeAlias = Sequence[e.Expression]

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


def _number(m: RunningProgram, arguments: Arguments, name: str) -> int | float:
    if name == "FRAND":
        m.controller.assume("FRAND", "", "the middle of its range")
    numbers: list[int | float] = []
    for a in arguments:
        value = value_of(m, a)
        whole = isinstance(value, int) and not isinstance(value, bool) and name == "ABS"
        numbers.append(value if whole else number_of(m, a, f"an argument of {name}"))  # type: ignore[arg-type]
    try:
        return v.ranged(MATHEMATICS[name](*numbers))
    except (ValueError, TypeError):
        hint = _HINTS.get(name, "one number")
        raise ExecutionError("number-range", f"{name} of {', '.join(map(str, numbers))}", hint) from None


def _inv_pos(m: RunningProgram, arguments: Arguments) -> Value:
    point = value_of(m, _at(arguments, 0, "INV_POS"))
    inverse = np.asarray(np.linalg.inv(v.pose_matrix(point, "INV_POS")), dtype=np.float64)
    return v.pose_value(inverse, point.type if isinstance(point, StructValue) else "FRAME")


def _forward(m: RunningProgram, arguments: Arguments) -> Value:
    q = _axes(value_of(m, _at(arguments, 0, "FORWARD")), "FORWARD")
    _set_status(m, arguments, 1, 0)
    return m.controller.pose_at(q)


def _axes(value: Value, what: str) -> Array:
    """A1 to A6 (6,) [rad] of a structure; raises `ExecutionError` where one is missing."""
    parts = value.parts if isinstance(value, StructValue) else {}
    angles = [parts.get(name) for name in AXIS_NAMES]
    if not all(isinstance(a, int | float) for a in angles):
        raise ExecutionError("no-value", f"{what} needs A1 to A6", "an E6AXIS with all six axes")
    return np.asarray(np.radians(np.array(angles, dtype=float)))


def _inverse(m: RunningProgram, arguments: Arguments) -> Value:
    c, point = m.controller, value_of(m, _at(arguments, 0, "INVERSE"))
    if not isinstance(point, StructValue):
        raise ExecutionError("type", "INVERSE of what is no structure", "an E6POS")
    start = _axes(value_of(m, _at(arguments, 1, "INVERSE")), "the start of INVERSE")
    flange = np.asarray(c.base @ v.pose_matrix(point, "INVERSE") @ np.linalg.inv(c.tool))
    try:
        result = inverse_kinematics(c.arm, flange)
    except LwrDynError as fault:
        raise ExecutionError("not-modelled", str(fault)) from None
    matching = [x for x in result.solutions if _fits(c, x.q, point)]
    _set_status(m, arguments, 2, 0 if matching else 2)
    return v.axes_value(nearest_solution(matching, start).q if matching else start)


def _fits(c: ControllerState, q: np.ndarray, point: StructValue) -> bool:
    """Whether the axes have the Status and Turn that the point gives."""
    at = c.pose_at(q).parts
    return all(point.parts.get(name) in (None, at[name]) for name in ("S", "T"))


def _set_status(env: Environment, arguments: Arguments, at: int, status: int) -> None:
    """The last argument of FORWARD and INVERSE: 0 where there is a solution."""
    variable = _variable(env, arguments[at]) if at < len(arguments) else None
    if variable is not None:
        variable.write(status)


def _at(arguments: Arguments, i: int, name: str) -> e.Expression:
    if i >= len(arguments):
        raise ExecutionError("arguments", f"{name} with {len(arguments)} arguments", "more of them")
    return arguments[i]


def _inline(m: RunningProgram, arguments: Arguments, name: str) -> Value:
    return INLINE[name](m, next(iter([value_of(m, a) for a in arguments]), None))


FUNCTIONS: Mapping[str, Callable[[RunningProgram, Arguments], Value]] = {
    "INV_POS": _inv_pos,
    "FORWARD": _forward,
    "INVERSE": _inverse,
    "VARSTATE": _variable_state,
    **{name: partial(_inline, name=name) for name in INLINE},
    **TEXT,
    **{name: partial(_number, name=name) for name in MATHEMATICS},
}
"""All that the model computes; each raises `ExecutionError`."""
_EMPTY: dict[str, Value] = {"BOOL": False, "INT": 0, "REAL": 0.0, "CHAR": " "}


def called_routine(m: RunningProgram, name: str) -> Routine | None:
    """The routine that a call enters; None for a stub, and for what `bas.src` defines and the model computes."""
    if name in m.controller.cell.stubs:
        return None
    routine = m.here.routine(name)
    if routine is not None and routine.file.name.lower().endswith("bas.src") and (name == "BAS" or name in FUNCTIONS):
        return None
    return routine


def value_of_call(m: RunningProgram, x: e.FunctionCall) -> Value | None:
    """The value of a stub or of a function of the controller; None where there is none; raises `ExecutionError`."""
    name = x.name.upper()
    if name in m.controller.cell.stubs:
        return _stub_value(m, x)
    function = FUNCTIONS.get(name)
    return None if function is None else function(m, [a for a in x.arguments if a is not None])


def empty_value(m: RunningProgram, x: e.FunctionCall) -> Value | None:
    """With `stubs.others` of the cell the value of a function that is not there; else None."""
    if not m.controller.cell.other_stubs:
        return None
    name = x.name.upper()
    function, external = m.here.project.known.functions.get(name), m.here.names.externals.get(name)
    kind = function.returns if function is not None else None
    if external is not None and external.returns is not None:
        kind = Type(external.returns.upper())
    value = _empty(m, UNKNOWN if kind is None else kind)
    m.controller.assume(f"{name}( )", v.value_text(value), "stubs.others of the cell file")
    return value


def _empty(m: RunningProgram, kind: Type) -> Value:
    if kind.name in _EMPTY:
        return _EMPTY[kind.name]
    parts = m.here.names.structures.get(kind.name) or m.here.project.known.structures.get(kind.name)
    if parts is None:
        return 0
    return StructValue(
        kind.name, {k: _EMPTY[v.name] for k, v in parts.items() if v.name in _EMPTY and not v.dimensions}
    )


def _stub_value(m: RunningProgram, x: e.FunctionCall) -> Value | None:
    """What the cell file gives for a call, its OUT arguments set."""
    name = x.name.upper()
    stub = m.controller.cell.stubs[name]
    m.controller.assume(f"{name}( )", "nothing" if stub.returns is None else v.value_text(stub.returns), "stub")
    for i, value in stub.out.items():
        target = _variable(m, x.arguments[i - 1] if i <= len(x.arguments) else None)
        if target is None:
            raise ExecutionError("arguments", f"the stub of {name} sets argument {i}, which is no variable", "")
        target.write(value)
    return stub.returns
