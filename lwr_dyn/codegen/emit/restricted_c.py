"""The texts of `kinematics.closed_forms` as C with an arm's constants and as JavaScript: one text, two languages.

In JavaScript local arrays are made once, beside the function, so that a call makes none.
"""

import re
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.kinematics.closed_forms.texts import FUNCTION

Constants = Mapping[str, ArrayLike]
"""Name -> number or array; whole Python numbers are for places in arrays."""

_MATH = {"fabs": "abs"} | {x: x for x in ("sin", "cos", "sqrt", "atan2", "acos", "floor")}

_COPYSIGN = """\
function copysign(size, x) {
    return x < 0.0 || 1.0 / x < 0.0 ? -size : size;
}
"""
"""Of a size that is not negative; JavaScript has none."""

_HEAD = re.compile(r"^(?:static )?(?:double|int|void) (\w+)\((.*?)\)\n", re.M)

_ARRAY = re.compile(r"^ +double (\w+)\[(\d+)\];\n", re.M)


def c_text(text: str, constants: Constants, prefix: str) -> str:
    """The text as C: constants first, every name of file scope with the prefix."""
    lines = [_c_constant(name, value) for name, value in constants.items() if _is_used(name, text)]
    return _prefixed("\n".join([*lines, "", text]), prefix)


def javascript_text(text: str, constants: Constants) -> str:
    """The text as JavaScript: plain functions, to be put into a scope of their own."""
    lines = [f"const {name} = {_js_value(value)};" for name, value in constants.items() if _is_used(name, text)]
    functions = FUNCTION.sub(lambda match: _js_function(match[0]), text.replace("static const double ", "const "))
    functions = functions.replace("(double)NAN", "NaN")
    for name, other in _MATH.items():
        functions = re.sub(rf"\b{name}\(", f"Math.{other}(", functions)
    return "\n".join([*lines, *([_COPYSIGN] if "copysign(" in functions else []), functions])


def declarations(text: str, names: tuple[str, ...], prefix: str) -> str:
    """The heads of functions, as C declares them, without the last semicolon."""
    heads = {match[1]: match[0].strip() for match in _HEAD.finditer(text)}
    return _prefixed(";\n".join(heads[name] for name in names), prefix, text)


def _is_used(name: str, text: str) -> bool:
    return re.search(rf"\b{name}\b", text) is not None


def _c_constant(name: str, value: ArrayLike) -> str:
    if isinstance(value, int):
        return f"enum {{ {name} = {value} }};"
    if np.ndim(value) == 0:
        return f"static const double {name} = {float(value)!r};"  # type: ignore[arg-type]
    numbers = np.ravel(np.asarray(value, dtype=np.float64)).tolist()
    rows = [", ".join(map(repr, numbers[i : i + 6])) for i in range(0, len(numbers), 6)]
    return f"static const double {name}[{len(numbers)}] = {{{(',' + chr(10) + '    ').join(rows)}}};"


def _js_value(value: ArrayLike) -> str:
    if isinstance(value, int) or np.ndim(value) == 0:
        return repr(value if isinstance(value, int) else float(value))  # type: ignore[arg-type]
    numbers = np.ravel(np.asarray(value, dtype=np.float64)).tolist()
    return f"new Float64Array([{', '.join(map(repr, numbers))}])"


def _js_function(text: str) -> str:
    head = _HEAD.search(text)
    assert head is not None
    name, arguments = head[1], [re.sub(r"\[\d+\]", "", x).split()[-1].lstrip("*") for x in head[2].split(",")]
    before, body = text[: head.start()], text[head.end() :]
    for array, size in _ARRAY.findall(body):
        before += f"const {name}_{array} = new Float64Array({size});\n"
    for array, _ in _ARRAY.findall(body):
        body = re.sub(rf"\b{array}\b", f"{name}_{array}", _ARRAY.sub(_without(array), body))
    body = re.sub(r"\bconst (?:double|int) ", "const ", body)
    body = re.sub(r"\b(?:double|int) (?=\w+ = )", "let ", body)
    return f"{before}function {name}({', '.join(arguments)})\n{body}"


def _without(array: str) -> Callable[[re.Match[str]], str]:
    return lambda match: "" if match[1] == array else match[0]


def _prefixed(made: str, prefix: str, text: str | None = None) -> str:
    """Names of file scope with the prefix; `inverse_kinematics...` stands for the function itself."""
    scope = made if text is None else text
    names = {match[1] for match in _HEAD.finditer(scope)}
    names |= set(re.findall(r"^(?:static const double|enum \{) (\w+)", scope, re.M))
    for name in sorted(names, key=len, reverse=True):
        new = (
            name.replace("inverse_kinematics", prefix) if name.startswith("inverse_kinematics") else f"{prefix}_{name}"
        )
        made = re.sub(rf"(?<![\w@]){name}\b", new, made)
    return made
