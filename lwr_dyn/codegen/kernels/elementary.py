"""Sine, cosine, exponential, tanh, logarithm, choices and whole numbers as straight-line code, without a branch.

Sine and cosine: x = m pi + r, then polynomials in r^2 over |r| <= pi/2; sin x = (-1)^m sin r, cos x = (-1)^m cos r. Pi
is subtracted in three parts (Cody and Waite), so that m times the first is exact. The others are exact to a few 1e-16,
of float64 alone; powers of two are made and taken apart by their bits (`straight_line.OPERATIONS`). Polynomials are
near-minimax (Chebyshev), fitted with mpmath when a kernel is generated.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi
import mpmath
import numpy as np

DIGITS = 50


@dataclass(frozen=True, slots=True)
class SinCos:
    """Constants of the range reduction and the polynomials for one number type."""

    pi_parts: tuple[float, float, float]
    magic: float
    """Adding and subtracting it rounds to an integer: 1.5 times 2^(bits of the significand - 1)."""
    most_half_turns: int
    """Most half turns whose product with the first part of pi is exact."""
    sine: tuple[float, ...]
    """(sin r - r) / r^3 as a polynomial in r^2, highest power first."""
    cosine: tuple[float, ...]
    """(cos r - 1 + r^2/2) / r^4 as a polynomial in r^2, highest power first."""

    def expand(self, writer: Any, x: Any) -> tuple[Any, Any, Any]:
        """sin x, cos x and the half turns m, as nodes of straight-line code."""
        plus, minus, times, number = writer.plus, writer.minus, writer.times, writer.number
        half_turns = _rounded(writer, times(x, number(1.0 / np.pi)))
        odd = plus(half_turns, minus(times(number(2.0), _rounded(writer, times(half_turns, number(0.5))))))
        sign = plus(number(1.0), minus(times(number(2.0), times(odd, odd))))
        first, second, third = (times(half_turns, number(part)) for part in self.pi_parts)
        r = plus(plus(x, minus(first)), minus(plus(second, third)))  # exact, then one rounding
        square, signed = times(r, r), times(sign, r)
        sine = plus(signed, times(times(signed, square), _polynomial(writer, self.sine, square)))
        low = plus(number(1.0), minus(times(number(0.5), square)))
        high = times(times(square, square), _polynomial(writer, self.cosine, square))
        return sine, times(sign, plus(low, high)), half_turns


@cache
def sincos(dtype: str) -> SinCos:
    """The constants for float64 (errors below 3e-16) or float32 (below 2e-7)."""
    if dtype == "float64":
        return _fitted(significand=53, part=33, terms=(8, 7))
    return _fitted(significand=24, part=12, terms=(4, 4))


def _fitted(significand: int, part: int, terms: tuple[int, int]) -> SinCos:
    with mpmath.workdps(DIGITS):
        end = (mpmath.pi / 2) ** 2
        rests = [  # of `SinCos.sine` and `SinCos.cosine`, by their series
            lambda t: mpmath.nsum(lambda k: (-1) ** (int(k) + 1) * t ** int(k) / mpmath.factorial(2 * k + 3), [0, 25]),
            lambda t: mpmath.nsum(lambda k: (-1) ** int(k) * t ** int(k) / mpmath.factorial(2 * k + 4), [0, 25]),
        ]
        sine, cosine = (mpmath.chebyfit(rest, [0, end], count) for rest, count in zip(rests, terms, strict=True))
        first = mpmath.floor(mpmath.ldexp(mpmath.pi, part - 2)) / mpmath.mpf(2) ** (part - 2)
        second = mpmath.floor(mpmath.ldexp(mpmath.pi - first, 2 * part - 2)) / mpmath.mpf(2) ** (2 * part - 2)
        parts = (float(first), float(second), float(mpmath.pi - first - second))
        magic, most = 1.5 * 2.0 ** (significand - 1), 2 ** (significand - part - 1)
        return SinCos(parts, magic, most, tuple(map(float, sine)), tuple(map(float, cosine)))


LARGEST = 700.0
"""exp of more than this [1] is exp of this: no overflow, so that choices between infinite numbers do not occur."""

_DIGITS = 40

_LOG2E, _ROOT2 = 1.4426950408889634, 1.4142135623730951

_LN2 = (0.693147180369123816490, 1.90821492927058770002e-10)
"""ln 2 in two parts, the first with 33 bits: a product with an exponent is exact."""


def apply(writer: Any, op: int, x: Sequence[Any]) -> Any:
    """One CasADi instruction that `straight_line` itself does not know; raises `NotImplementedError`."""
    if op not in _RULES:
        raise NotImplementedError(f"CasADi operation {op} in a symbolic function")
    return _RULES[op](writer, *x)


def _plain(writer: Any, x: Any) -> Any:
    """A value without a sign of its own."""
    return x if x.sign > 0 else writer.node("-", writer.number(0.0).node, x.node)


def _pair(op: str) -> Callable[..., Any]:
    return lambda writer, x, y: writer.node(op, _plain(writer, x).node, _plain(writer, y).node)


def _chosen(writer: Any, condition: Any, x: Any) -> Any:
    """x where the condition (1 or 0) holds, else 0, whatever x is."""
    chosen = writer.node("?", _plain(writer, condition).node, x.node)
    return type(x)(x.sign, chosen.node)


def _not(writer: Any, x: Any) -> Any:
    return writer.node(">", writer.number(0.5).node, _plain(writer, x).node)


def _absolute(writer: Any, x: Any) -> Any:
    return writer.node("abs", x.node, x.node)


def _rounded(writer: Any, x: Any) -> Any:
    """The nearest whole number, half to even; |x| below 2^51."""
    magic = writer.number(writer.sincos.magic)
    return writer.plus(writer.plus(x, magic), writer.minus(magic))


def _remainder(writer: Any, x: Any, y: Any) -> Any:
    """x less the nearest whole number: of y = 1 alone."""
    if writer.nodes[y.node] != ("const", 1.0, None) or y.sign < 0:
        raise NotImplementedError("a remainder by another number than 1")
    return writer.plus(x, writer.minus(_rounded(writer, x)))


def _reduced(writer: Any, x: Any) -> tuple[Any, Any]:
    """2^n and e^r - 1 with x = n ln 2 + r."""
    n = _rounded(writer, writer.times(x, writer.number(_LOG2E)))
    high, low = (writer.times(n, writer.number(part)) for part in _LN2)
    r = writer.plus(writer.plus(x, writer.minus(high)), writer.minus(low))
    rest = writer.times(writer.times(r, r), _polynomial(writer, _exponential(), r))
    power = _plain(writer, n)
    return writer.node("2^", power.node, power.node), writer.plus(r, rest)


def _within(writer: Any, x: Any) -> Any:
    """x held in +-LARGEST; NaN stays."""
    below = writer.node("min", _plain(writer, x).node, writer.number(LARGEST).node)
    return writer.node("max", below.node, _plain(writer, writer.number(-LARGEST)).node)


def _exp(writer: Any, x: Any) -> Any:
    power, less_one = _reduced(writer, _within(writer, x))
    return writer.plus(power, writer.times(power, less_one))


def _tanh(writer: Any, x: Any) -> Any:
    """(1 - e^-2|x|) / (1 + e^-2|x|) with the sign of x, by e^-2|x| - 1: exact near 0 too."""
    size = _absolute(writer, x)
    power, less_one = _reduced(writer, _within(writer, writer.times(writer.number(-2.0), size)))
    less = writer.plus(writer.times(power, less_one), writer.plus(power, writer.number(-1.0)))
    positive = writer.minus(writer.over(less, writer.plus(less, writer.number(2.0))))
    is_negative = writer.is_positive(writer.minus(x))
    return writer.plus(positive, writer.minus(_chosen(writer, is_negative, writer.plus(positive, positive))))


def _log(writer: Any, x: Any) -> Any:
    """ln x of a normal number above 0: x = 2^e m, ln m by (m - 1) / (m + 1)."""
    x = _plain(writer, x)
    m, e = (writer.node(op, x.node, x.node) for op in ("significand", "exponent"))
    is_large = writer.is_positive(writer.plus(m, writer.number(-_ROOT2)))
    m = writer.plus(m, writer.minus(_chosen(writer, is_large, writer.times(writer.number(0.5), m))))
    e = writer.plus(e, is_large)
    f = writer.over(writer.plus(m, writer.number(-1.0)), writer.plus(m, writer.number(1.0)))
    square = writer.times(f, f)
    rest = writer.times(writer.times(f, square), _polynomial(writer, _logarithm(), square))
    high, low = (writer.times(e, writer.number(part)) for part in _LN2)
    return writer.plus(high, writer.plus(writer.plus(low, rest), writer.plus(f, f)))


def _polynomial(writer: Any, coefficients: tuple[float, ...], x: Any) -> Any:
    total = writer.number(coefficients[0])
    for c in coefficients[1:]:
        total = writer.plus(writer.times(total, x), writer.number(c))
    return total


@cache
def _exponential() -> tuple[float, ...]:
    """(e^r - 1 - r) / r^2 over |r| <= ln 2 / 2, highest power first."""
    with mpmath.workdps(_DIGITS):
        end = mpmath.log(2) / 2
        fitted = mpmath.chebyfit(
            lambda r: mpmath.fsum(r**k / mpmath.factorial(k + 2) for k in range(30)), [-end, end], 11
        )
    return tuple(map(float, fitted))


@cache
def _logarithm() -> tuple[float, ...]:
    """(ln((1 + f) / (1 - f)) - 2 f) / f^3 in f^2, over 1/sqrt 2 <= m <= sqrt 2, highest power first."""
    with mpmath.workdps(_DIGITS):
        end = ((mpmath.sqrt(2) - 1) / (mpmath.sqrt(2) + 1)) ** 2
        fitted = mpmath.chebyfit(lambda t: mpmath.fsum(2 * t**k / (2 * k + 3) for k in range(40)), [0, end], 8)
    return tuple(map(float, fitted))


_RULES: dict[int, Callable[..., Any]] = {
    casadi.OP_FMIN: _pair("min"),
    casadi.OP_FMAX: _pair("max"),
    casadi.OP_FABS: _absolute,
    casadi.OP_IF_ELSE_ZERO: _chosen,
    casadi.OP_NOT: _not,
    casadi.OP_AND: lambda writer, x, y: writer.times(x, y),
    casadi.OP_LE: lambda writer, x, y: _not(writer, writer.is_positive(writer.plus(x, writer.minus(y)))),
    casadi.OP_REMAINDER: _remainder,
    casadi.OP_EXP: _exp,
    casadi.OP_TANH: _tanh,
    casadi.OP_LOG: _log,
}
