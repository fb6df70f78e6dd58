"""The eight branches of an arm with shoulder, elbow and wrist: three signs, whatever each arm counts them from."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple


class Branch(NamedTuple):
    """Which of the eight solutions.

    S-R-S arms: the signs of tilt 2, elbow 4 and tilt 6, counted from where rolls or arm align. Six joints with a
    spherical wrist: shoulder +1 with the wrist centre ahead of axis 1, elbow and wrist the signs of bend and tilt.
    """

    shoulder: int
    elbow: int
    wrist: int

    @property
    def label(self) -> str:
        """The three signs.

        >>> Branch(1, -1, 1).label
        '+-+'
        """
        return "".join("+" if sign > 0 else "-" for sign in self)


BRANCHES = tuple(Branch(*signs) for signs in product((1, -1), repeat=3))
