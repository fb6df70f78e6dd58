"""Single faults that explain wrong cells: two exchanged, a power of ten, the other sign, two digits exchanged."""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TypeVar

from lwr_dyn.model.printed_number import PrintedNumber, power_of_ten, printed_number

Place = TypeVar("Place")
POWERS = (-3, -2, -1, 1, 2, 3)
"""Powers of ten by which a cell of a sum may be off."""


def exchanges(
    numbers: Mapping[Place, PrintedNumber], holds: Callable[[Mapping[Place, PrintedNumber]], bool]
) -> list[tuple[Place, Place]]:
    """Every two places that print each other's numbers: `holds` with the two numbers exchanged."""
    return [
        (one, other)
        for one, other in itertools.combinations(numbers, 2)
        if holds({one: numbers[other], other: numbers[one]})
    ]


def scale_or_sign(value: float, printed: Sequence[PrintedNumber], slack: float = 0.0) -> tuple[str, str] | None:
    """Rule and words of the fault that turns `value` into one of the printed numbers; None when there is none.

    >>> scale_or_sign(1.325e-5, [printed_number("1.325e-7")])
    ('power-of-ten', 'off by 1e2')
    """
    powers = [k for n in printed if (k := power_of_ten(value, n, slack))]
    if powers:
        return "power-of-ten", f"off by 1e{powers[0]}"
    return ("sign", "the sign is the other one") if any(n.meets(-value, slack) for n in printed) else None


def corrections(number: PrintedNumber) -> Iterator[tuple[float, str]]:
    """Values that a number may stand for when it has one fault, each with the fault in words.

    >>> [value for value, _ in corrections(printed_number("12"))][-2:]
    [-12.0, 21.0]
    """
    if not number.value:
        return
    for k in POWERS:
        yield number.value * 10.0**k, f"a factor 1e{k}"
    yield -number.value, "the other sign"
    text = number.text
    for i in range(len(text) - 1):
        if text[i].isdigit() and text[i + 1].isdigit() and text[i] != text[i + 1]:
            exchanged = printed_number(text[:i] + text[i + 1] + text[i] + text[i + 2 :])
            if exchanged is not None:
                yield exchanged.value, "two digits exchanged"
