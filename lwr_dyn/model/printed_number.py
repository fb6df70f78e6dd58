"""A number as it is printed: its text, its value, and half a unit of its last digit."""

import re
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
LONGEST = 60
"""Characters of a number."""
LARGEST_EXPONENT = 300
ROUND = 1e-9
"""Share of the half unit allowed beyond it: a value that rounds up or down from an exact half."""


@dataclass(frozen=True, slots=True)
class PrintedNumber:
    """A printed number; value and half are in SI where it was read with the factor of its unit."""

    text: str
    value: float
    half: float
    """Half a unit of the last printed digit: how far the true value may lie from it."""

    @property
    def digits(self) -> str:
        """Its significant digits, trailing zeros kept.

        >>> printed_number("-0.00437543").digits, printed_number("7310").digits
        ('437543', '7310')
        """
        mantissa = re.split("[eE]", self.text.lstrip("+-"))[0]
        return mantissa.replace(".", "").lstrip("0")

    @property
    def is_whole(self) -> bool:
        """Printed without a decimal point or exponent."""
        return self.text.lstrip("+-").isdigit()

    def meets(self, value: float, slack: float = 0.0) -> bool:
        """`value` rounds to this number, or comes within `slack` of doing so.

        >>> printed_number("2.924").meets(2.92437), printed_number("2.924").meets(2.9233)
        (True, False)
        """
        return bool(abs(value - self.value) <= self.half * (1.0 + ROUND) + slack)


def printed_number(text: str, factor: float = 1.0) -> PrintedNumber | None:
    """The number that a text prints in a unit of `factor` SI units; None where it prints none ("-", "cos(q1)").

    >>> printed_number("1.325e-7"), printed_number("-") is None
    (PrintedNumber(text='1.325e-7', value=1.325e-07, half=5e-11), True)
    """
    bare = text.strip().replace("\N{MINUS SIGN}", "-").replace("\N{EN DASH}", "-")
    if len(bare) > LONGEST or not _NUMBER.fullmatch(bare):
        return None
    try:
        unit = last_digit(bare)
    except ValueError:
        return None
    if abs(unit.adjusted()) > LARGEST_EXPONENT:
        return None
    return PrintedNumber(bare, float(bare) * factor, 0.5 * float(unit) * factor)


def last_digit(printed: str) -> Decimal:
    """The unit of the last printed digit; raises `ValueError` for infinity, NaN and exponents of 19 digits.

    >>> last_digit("0.4903")
    Decimal('0.0001')
    """
    try:
        exponent = Decimal(printed).as_tuple().exponent
    except InvalidOperation:
        raise ValueError(printed) from None
    if not isinstance(exponent, int):
        raise ValueError(printed)
    return Decimal((0, (1,), exponent))  # unlike scaleb, for every exponent


def agrees(printed: str, value: float, step: str = "") -> bool:
    """`value` lies within half a unit of the last printed digit, or of `step` where that is finer.

    Raises `ValueError` for a text that prints no number.

    >>> agrees("2.924", 2.92437), agrees("2.924", 2.9233)
    (True, False)
    >>> agrees("0", 0.4), agrees("0", 0.4, "0.01")
    (True, False)
    """
    number = printed_number(printed)
    if number is None:
        raise ValueError(printed)
    if step and float(step) < 2 * number.half:
        number = PrintedNumber(number.text, number.value, float(step) / 2)
    return number.meets(value)


def power_of_ten(value: float, printed: PrintedNumber, slack: float = 0.0, most: int = 9) -> int:
    """The k of 10^k by which the print is off, value = 10^k printed within its digits; 0 when there is none.

    >>> power_of_ten(1.325e-5, printed_number("1.325e-7"))
    2
    """
    for k in (sign * k for k in range(1, most + 1) for sign in (1, -1)):
        scale = 10.0**k
        if abs(value - scale * printed.value) <= scale * printed.half * (1.0 + ROUND) + slack:
            return k if printed.value else 0
    return 0
