"""Sine and cosine without a branch: x = m pi + r, then polynomials in r^2 over |r| <= pi/2.

sin x = (-1)^m sin r, cos x = (-1)^m cos r; pi is subtracted in three parts (Cody and Waite), so that m times the first
is exact. Polynomials are near-minimax (Chebyshev), fitted with mpmath when a kernel is generated.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

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

        def rounded(value: Any) -> Any:
            magic = number(self.magic)
            return plus(plus(value, magic), minus(magic))

        half_turns = rounded(times(x, number(1.0 / np.pi)))
        odd = plus(half_turns, minus(times(number(2.0), rounded(times(half_turns, number(0.5))))))
        sign = plus(number(1.0), minus(times(number(2.0), times(odd, odd))))
        first, second, third = (times(half_turns, number(part)) for part in self.pi_parts)
        r = plus(plus(x, minus(first)), minus(plus(second, third)))  # exact, then one rounding
        square, signed = times(r, r), times(sign, r)
        sine = plus(signed, times(times(signed, square), self._horner(writer, self.sine, square)))
        low = plus(number(1.0), minus(times(number(0.5), square)))
        high = times(times(square, square), self._horner(writer, self.cosine, square))
        return sine, times(sign, plus(low, high)), half_turns

    def _horner(self, writer: Any, coefficients: tuple[float, ...], x: Any) -> Any:
        total = writer.number(coefficients[0])
        for c in coefficients[1:]:
            total = writer.plus(times_x := writer.times(total, x), writer.number(c)) if c else times_x
        return total


@cache
def sincos(dtype: str) -> SinCos:
    """The constants for float64 (errors below 3e-16) or float32 (below 2e-7)."""
    if dtype == "float64":
        return _fitted(significand=53, part=33, terms=(8, 7))
    return _fitted(significand=24, part=12, terms=(4, 4))


def _fitted(significand: int, part: int, terms: tuple[int, int]) -> SinCos:
    with mpmath.workdps(DIGITS):
        end = (mpmath.pi / 2) ** 2
        sine = mpmath.chebyfit(_sine_rest, [0, end], terms[0])
        cosine = mpmath.chebyfit(_cosine_rest, [0, end], terms[1])
        first = mpmath.floor(mpmath.ldexp(mpmath.pi, part - 2)) / mpmath.mpf(2) ** (part - 2)
        second = mpmath.floor(mpmath.ldexp(mpmath.pi - first, 2 * part - 2)) / mpmath.mpf(2) ** (2 * part - 2)
        parts = (float(first), float(second), float(mpmath.pi - first - second))
        return SinCos(
            pi_parts=parts,
            magic=1.5 * 2.0 ** (significand - 1),
            most_half_turns=2 ** (significand - part - 1),
            sine=tuple(float(c) for c in sine),
            cosine=tuple(float(c) for c in cosine),
        )


def _sine_rest(t: Any) -> Any:
    """(sin r - r) / r^3 at t = r^2, by its series."""
    return mpmath.nsum(lambda k: (-1) ** (int(k) + 1) * t ** int(k) / mpmath.factorial(2 * k + 3), [0, 25])


def _cosine_rest(t: Any) -> Any:
    """(cos r - 1 + r^2/2) / r^4 at t = r^2, by its series."""
    return mpmath.nsum(lambda k: (-1) ** int(k) * t ** int(k) / mpmath.factorial(2 * k + 4), [0, 25])
