"""How numbers and comments are written into XML."""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import escape

from lwr_dyn.arrays import Array


def number(x: float) -> str:
    """repr without a negative zero.

    >>> number(-0.0), number(0.1)
    ('0.0', '0.1')
    """
    return repr(float(x) + 0.0)


def numbers(values: Array | Sequence[float]) -> str:
    """Numbers separated by blanks."""
    return " ".join(number(v) for v in values)


def comment(text: str) -> str:
    """Text that may stand in an XML comment.

    >>> comment("a -- b")
    'a - - b'
    """
    return " ".join(escape(text).replace("--", "- -").split())
