"""Numbers in attributes: what cannot be used is None, what is too small to matter 0."""

import math

import numpy as np

from lwr_dyn.checks.urdf.xml_tree import XmlElement
from lwr_dyn.foundation.arrays import Array, number_of

LARGEST = 1e15
"""Magnitude beyond which a number is not used: no robot has it, and its square may overflow."""
SMALLEST = 1e-30
"""Magnitude below which a number is used as 0."""


def numbers(text: str | None) -> tuple[float, ...] | None:
    """The numbers of an attribute; None where one is no number, not finite, or too large to be meant.

    >>> numbers("1 -2e-3"), numbers("1,5"), numbers("nan")
    ((1.0, -0.002), None, None)
    """
    try:
        values = [number_of(word) for word in (text or "").split()]
    except ValueError:
        return None
    if not all(math.isfinite(v) and abs(v) < LARGEST for v in values):
        return None
    return tuple(v if abs(v) > SMALLEST else 0.0 for v in values)


def scalar(element: XmlElement | None, name: str) -> float | None:
    """An attribute that is one number."""
    values = numbers(element.attributes.get(name)) if element is not None else None
    return values[0] if values is not None and len(values) == 1 else None


def vector(element: XmlElement | None, name: str, default: tuple[float, float, float]) -> Array | None:
    """An attribute that is three numbers; the default where it is not written."""
    if element is None or name not in element.attributes:
        return np.array(default)
    values = numbers(element.attributes[name])
    return np.array(values) if values is not None and len(values) == 3 else None
