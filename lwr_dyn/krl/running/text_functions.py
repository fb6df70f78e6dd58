"""KRL's functions on text: STRLEN, STRADD, STRCOMP, STRFIND, STRTOINT ... Text is an array of characters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.running.evaluate import Environment, number_of, reference_to, value_of
from lwr_dyn.krl.running.values import ArrayValue, EnumValue, Value, text_array, text_of

Arguments: TypeAlias = Sequence[e.Expression]


def _text(env: Environment, arguments: Arguments, i: int) -> str:
    if i >= len(arguments):
        raise ExecutionError("arguments", f"{len(arguments)} arguments are too few", "a text is missing")
    x = arguments[i]
    if isinstance(x, e.Name | e.Index | e.Component):
        value = reference_to(env, x).read()
        return "" if value is None else text_of(value)
    return text_of(value_of(env, x))


def _room(env: Environment, x: e.Expression) -> int | None:
    """The declared number of characters of a variable; None where it is open."""
    if not isinstance(x, e.Name | e.Index | e.Component):
        return None
    value = reference_to(env, x).read()
    return value.sizes[0] if isinstance(value, ArrayValue) and value.sizes else None


def _write(env: Environment, x: e.Expression, text: str) -> bool:
    """Put text into a variable; False (nothing is written) where it is longer than the variable."""
    if not isinstance(x, e.Name | e.Index | e.Component):
        raise ExecutionError("type", "a text function writes into what is no variable", "a variable: T[]")
    room = _room(env, x)
    if room is not None and len(text) > room:
        return False
    reference_to(env, x).write(text_array(text, () if room is None else (room,)))
    return True


def _length(env: Environment, a: Arguments) -> Value:
    return len(_text(env, a, 0))


def _declared_length(env: Environment, a: Arguments) -> Value:
    room = _room(env, a[0]) if a else None
    return len(_text(env, a, 0)) if room is None else room


def _clear(env: Environment, a: Arguments) -> Value:
    return bool(a) and _write(env, a[0], "")


def _add(env: Environment, a: Arguments) -> Value:
    whole = _text(env, a, 0) + _text(env, a, 1)
    return len(whole) if _write(env, a[0], whole) else 0


def _copy(env: Environment, a: Arguments) -> Value:
    return _write(env, a[0], _text(env, a, 1)) if a else False


def _case(env: Environment, a: Arguments, i: int) -> bool:
    """Whether capitals count, #CASE_SENS, which is the rule without the argument."""
    value = value_of(env, a[i]) if i < len(a) else EnumValue("CASE_SENS")
    return value != EnumValue("NOT_CASE_SENS")


def _equal(env: Environment, a: Arguments) -> Value:
    left, right = _text(env, a, 0), _text(env, a, 1)
    return left == right if _case(env, a, 2) else left.upper() == right.upper()


def _find(env: Environment, a: Arguments) -> Value:
    """The first place from `from` on at which the second text stands in the first one, 0 for none."""
    shift = 0 if len(a) > 2 and not isinstance(a[0], e.Text) and _is_number(env, a[0]) else -1
    begin = int(number_of(env, a[0], "STRFIND")) if shift == 0 else 1
    within, wanted = _text(env, a, shift + 1), _text(env, a, shift + 2)
    if not _case(env, a, shift + 3):
        within, wanted = within.upper(), wanted.upper()
    return within.find(wanted, max(begin, 1) - 1) + 1


def _is_number(env: Environment, x: e.Expression) -> bool:
    if isinstance(x, e.Name | e.Index | e.Component):
        return isinstance(reference_to(env, x).read(), int | float)
    return isinstance(value_of(env, x), int | float)


def _to(read: Callable[[str], Value]) -> Callable[[Environment, Arguments], Value]:
    """STRTOINT and the like: TRUE and the value in the second argument where the text can be read."""

    def convert(env: Environment, a: Arguments) -> Value:
        text = _text(env, a, 0)
        if len(a) < 2 or not isinstance(a[1], e.Name | e.Index | e.Component):
            raise ExecutionError("arguments", "no variable for the value that is read", "a variable")
        try:
            value = read(text.strip())
        except (ValueError, KeyError):
            return False
        reference_to(env, a[1]).write(value)
        return True

    return convert


def _real(text: str) -> float:
    if not set(text) <= set("+-.0123456789eE"):
        raise ValueError(text)
    return float(text)


def _to_text(env: Environment, a: Arguments) -> Value:
    text = _text(env, a, 0)
    return len(a) > 1 and _write(env, a[1], text)


TEXT: dict[str, Callable[[Environment, Arguments], Value]] = {
    "STRLEN": _length,
    "STRDECLLEN": _declared_length,
    "STRCLEAR": _clear,
    "STRADD": _add,
    "STRCOPY": _copy,
    "STRCOMP": _equal,
    "STRFIND": _find,
    "STRTOINT": _to(int),
    "STRTOREAL": _to(_real),
    "STRTOBOOL": _to(lambda text: {"TRUE": True, "FALSE": False}[text.upper()]),
    "STRTOSTRING": _to_text,
}
"""Function -> its value; those with an OUT argument write into it."""
