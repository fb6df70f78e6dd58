"""What emitted JavaScript functions share: sine and cosine with the bits of the C code, powers of two by their bits."""

import re
from functools import cache

import casadi

from lwr_dyn.codegen.emit.functions import Argument, EmittedFunction
from lwr_dyn.codegen.emit.javascript import js_function
from lwr_dyn.codegen.emit.straight_code import emitted_code

_POWERS = """\
const bits = new Float64Array(1), words = new Int32Array(bits.buffer);
const high = new Int8Array(new Int16Array([1]).buffer)[0];
function two_to(n) {
  words[1 - high] = 0;
  words[high] = (n + 1023) << 20;
  return bits[0];
}
function exponent(x) {
  bits[0] = x;
  return ((words[high] >> 20) & 2047) - 1023;
}
function significand(x) {
  bits[0] = x;
  words[high] = (words[high] & 1048575) | 1072693248;
  return bits[0] + (x - x);
}
"""
"""Of normal numbers; NaN and inf have the fraction NaN."""


def shared_functions(text: str) -> str:
    """The functions that a text of emitted functions calls."""
    needs_turns, needs_powers = "sincos(" in text, re.search(r"\b(two_to|exponent|significand)\(", text) is not None
    return (_sincos() if needs_turns else "") + (_POWERS if needs_powers else "")


@cache
def _sincos() -> str:
    """`sincos(x, i)`: sine and cosine of x[i] into `turned`, operation by operation those of the C code."""
    x = casadi.SX.sym("x")
    symbolic = casadi.Function("sincos", [x], [casadi.vertcat(casadi.sin(x), casadi.cos(x))])
    function = EmittedFunction("sincos", "", (Argument("x", 1, "rad"),), (2,), "1", symbolic)
    text = js_function(emitted_code(function, "own"), "sincos")
    head = "const turned = new Float64Array(2);\nfunction sincos(x, i) {"
    text = text.replace("function sincos(x, out = new Float64Array(2)) {", head)
    return text.replace("x[0]", "x[i]").replace("out[", "turned[").replace("  return out;\n", "")
