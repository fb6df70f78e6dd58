"""Numbers as text for people: a few digits, a true minus, raised exponents."""

import math
import re


def number_text(value: float) -> str:
    """A number in six digits, as short as it can be.

    >>> number_text(0.1 + 0.2), number_text(-0.0)
    ('0.3', '0')
    """
    return f"{value + 0.0:.6g}"


def written_out(x: float) -> str:
    """Six significant digits, without an exponent from 1e-9 to 1e9; whole numbers in full.

    >>> written_out(1.5e-7), written_out(0.0), written_out(1 / 3), written_out(1e6)
    ('0.00000015', '0', '0.333333', '1000000')
    """
    if x == 0.0:
        return "0"
    text = f"{x:.6g}"
    if "e" in text and 1e-9 <= abs(x) < 1e9:
        decimals = 5 - math.floor(math.log10(abs(x)))
        text = f"{x:.{decimals}f}".rstrip("0") if decimals > 0 else f"{x:.0f}"
    return text


def short(value: float, digits: int = 3) -> str:
    """A number with a few significant digits and a true minus; far from 1 as a power of ten.

    >>> short(-0.000331), short(40.24), short(2.4e-7), short(0.0), short(1e-5)
    ('\u22120.000331', '40.2', '2.4\u00b710\u207b\u2077', '0', '10\u207b\u2075')
    """
    if value == 0.0 or 1e-4 <= abs(value) < 1e5:
        return true_minus(f"{float(f'{value:.{digits}g}'):.10f}".rstrip("0").rstrip("."))
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    power = power_of_ten(int(exponent))
    return true_minus(mantissa[:-1] + power if mantissa in ("1", "-1") else f"{mantissa}\u00b7{power}")


def power_of_ten(exponent: int) -> str:
    """A power of ten with its exponent raised."""
    return f"10{str(exponent).translate(_RAISED)}"


def raised(text: str) -> str:
    """Text with the exponents 0 to 4 of units raised.

    >>> raised("kg m^2 s^-1")
    'kg m\u00b2 s\u207b\u00b9'
    """
    return re.sub(r"\^(-?[0-4])", lambda found: found[1].translate(_RAISED), text)


_RAISED = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")


def true_minus(text: str) -> str:
    """Text with a true minus in place of hyphens."""
    return text.replace("-", "\u2212")
