"""Numbers as a paper prints them: text with its digits, and whether a computed value agrees to those digits."""

from __future__ import annotations

import tomllib
from decimal import Decimal
from importlib import resources
from typing import Any

TIE = Decimal("1e-9")
"""Share of the last printed digit allowed beyond half of it: a value that rounds up or down from an exact half."""


def printed_tables(paper: str, file: str = "results") -> dict[str, Any]:
    """What a paper prints, from a data file in its room: blocks with their cells and what is given beside them."""
    text = resources.files(f"lwr_dyn.reproduction.{paper}").joinpath(f"{file}.toml").read_text(encoding="utf-8")
    raw = tomllib.loads(text)
    return {name: _merged(block) if isinstance(block, dict) else block for name, block in raw.items()}


def _merged(block: dict[str, Any]) -> dict[str, Any]:
    merged: dict[str, Any] = block | block.get("given", {}) | block.get("cells", {})
    return merged


def last_digit(printed: str) -> Decimal:
    """The unit of the last printed digit.

    >>> last_digit("0.4903")
    Decimal('0.0001')
    """
    exponent = Decimal(printed).as_tuple().exponent
    if not isinstance(exponent, int):
        raise ValueError(printed)
    return Decimal(1).scaleb(exponent)


def agrees(printed: str, value: float, step: str = "") -> bool:
    """`value` lies within half a unit of the last printed digit, or of `step` where that is finer.

    >>> agrees("2.924", 2.92437), agrees("2.924", 2.9233)
    (True, False)
    >>> agrees("0", 0.4), agrees("0", 0.4, "0.01")
    (True, False)
    """
    unit = min(last_digit(printed), Decimal(step)) if step else last_digit(printed)
    return abs(Decimal(value) - Decimal(printed)) <= unit * (Decimal("0.5") + TIE)
