"""What may be wrong with the columns of a log: signs, order, units; each as a linear map that would mend it.

    q' = q Q,  dq' = dq Q,  ddq' = ddq Q,  tau' = tau T

Q and T are permutations with signs and factors.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from math import pi
from typing import Literal

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.log_faults.log_fault import FaultKind

Side = Literal["q", "tau", "both"]
SIDES: tuple[Side, ...] = ("both", "q", "tau")
TURN = 180.0 / pi
TURN_SLIPS = {TURN: "in rad, read as deg", 1.0 / TURN: "in deg, read as rad"}
"""Factors that mend positions in the wrong unit, and what went wrong; torques: see `torque_scale`."""
_WHOSE: Mapping[Side, str] = {"q": "positions", "tau": "torques", "both": "positions and torques"}


@dataclass(frozen=True, slots=True, eq=False)
class ColumnChange:
    """A change that would mend a log: `kind`, `joints` (from 1; empty for all), `side`, and its maps (n, n)."""

    kind: FaultKind
    joints: tuple[int, ...]
    side: Side
    text: str
    Q: Array
    T: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "Q", "T")


def column_changes(n: int) -> Iterator[ColumnChange]:
    """Every single change for an arm of n joints: one sign, two columns exchanged, one unit of q; and of all.

    >>> sum(1 for _ in column_changes(7))
    112
    """
    yield from _sign_changes(n)
    yield from _order_changes(n)
    yield from _unit_changes(n)


def _sign_changes(n: int) -> Iterator[ColumnChange]:
    for side in SIDES:
        for j in range(n):
            yield _change("sign", (j + 1,), side, _signs(n, [j]), f"{_columns(side, j + 1)} with the opposite sign")
        yield _change("sign", (), side, _signs(n, range(n)), f"all {_WHOSE[side]} with the opposite sign")


def _order_changes(n: int) -> Iterator[ColumnChange]:
    for side in SIDES:
        for i, j in combinations(range(n), 2):
            order = list(range(n))
            order[i], order[j] = j, i
            text = f"{_columns(side, i + 1)} exchanged with {_columns(side, j + 1)}"
            yield _change("order", (i + 1, j + 1), side, np.eye(n)[order], text)
        if n > 3:
            yield _change("order", (), side, np.eye(n)[::-1], f"all {_WHOSE[side]} in reverse order")
            for shift, way in ((1, "up"), (-1, "down")):
                moved = np.roll(np.eye(n), shift, axis=1)
                yield _change("order", (), side, moved, f"all {_WHOSE[side]} one joint further {way}")


def _unit_changes(n: int) -> Iterator[ColumnChange]:
    for factor, slip in TURN_SLIPS.items():
        text = f"{factor:.4g} times as large ({slip})"
        yield _change("unit", (), "q", factor * np.eye(n), f"all positions {text}")
        for j in range(n):
            one = np.eye(n)
            one[j, j] = factor
            yield _change("unit", (j + 1,), "q", one, f"q{j + 1} {text}")


def _change(kind: FaultKind, joints: tuple[int, ...], side: Side, map_: Array, text: str) -> ColumnChange:
    none = np.eye(len(map_))
    return ColumnChange(kind, joints, side, text, none if side == "tau" else map_, none if side == "q" else map_)


def _signs(n: int, joints: Iterable[int]) -> Array:
    out = np.ones(n)
    out[list(joints)] = -1.0
    return np.diag(out)


def _columns(side: Side, joint: int) -> str:
    return {"q": f"q{joint}", "tau": f"tau{joint}", "both": f"q{joint} and tau{joint}"}[side]
