"""A number as it is printed: its text, its value, and half a unit of its last digit."""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
ROUND = 1e-9
"""Share of the last digit allowed beyond its half: a value that rounds up or down from an exact half."""


@dataclass(frozen=True, slots=True)
class Number:
    """A printed number: what it reads, its value, and how far the true value may lie from it."""

    text: str
    value: float
    half: float
    """Half a unit of the last printed digit."""

    @property
    def digits(self) -> str:
        """Its significant digits, trailing zeros kept.

        >>> number_in("-0.00437543").digits, number_in("7310").digits
        ('437543', '7310')
        """
        mantissa = re.split("[eE]", self.text.lstrip("+-"))[0]
        return mantissa.replace(".", "").lstrip("0")

    @property
    def whole(self) -> bool:
        """Printed without a decimal point or exponent."""
        return self.text.lstrip("+-").isdigit()

    def meets(self, value: float, slack: float = 0.0) -> bool:
        """`value` rounds to this number, or comes within `slack` of doing so.

        >>> number_in("2.924").meets(2.92437), number_in("2.924").meets(2.9233)
        (True, False)
        """
        return abs(value - self.value) <= self.half * (1.0 + ROUND) + slack


def number_in(text: str) -> Number | None:
    """The number that a cell prints, or nothing when it prints none ("-", "n/a", "cos(q1)").

    >>> number_in("1.325e-7"), number_in("-") is None
    (Number(text='1.325e-7', value=1.325e-07, half=5e-11), True)
    """
    bare = text.strip().replace("\N{MINUS SIGN}", "-").replace("\N{EN DASH}", "-")
    if len(bare) > 60 or not _NUMBER.fullmatch(bare):
        return None
    exponent = Decimal(bare).as_tuple().exponent
    if not isinstance(exponent, int) or abs(exponent) > 300:
        return None
    return Number(bare, float(bare), 0.5 * 10.0**exponent)


def power_of_ten(value: float, printed: Number, slack: float = 0.0, most: int = 9) -> int:
    """The k of 10^k by which the print is off, value = 10^k printed within its digits; 0 when there is none.

    >>> power_of_ten(1.325e-5, number_in("1.325e-7"))
    2
    """
    for k in range(1, most + 1):
        for sign in (k, -k):
            scale = 10.0**sign
            if abs(value - scale * printed.value) <= scale * printed.half * (1.0 + ROUND) + slack:
                return sign if printed.value else 0
    return 0
