"""What a source publishes beside its table: numbers derived from it, a second set of tensors, poses, repeated links.

A value is text, so that its printed digits are known: a reading may miss it by half a unit of the last one.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lwr_dyn.checks.conventions.choices import About, Products
from lwr_dyn.checks.conventions.printed_table import BLANK, TENSOR, PrintedTable
from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import FaultError, UnknownNameError
from lwr_dyn.model.printed_number import PrintedNumber, printed_number

Quantity = Literal["inertia", "worst inertia", "gravity"]


class EvidenceError(FaultError, ValueError):
    """Evidence for a reading cannot be used: `where` is the entry."""

    def __init__(self, where: str, found: str, allowed: str) -> None:
        super().__init__(f"evidence: {where}", found, allowed)
        self.where = where


def evidence_number(text: object, factor: float = 1.0, where: str = "evidence") -> PrintedNumber:
    """A number from text such as "2.924" in a unit of `factor` SI units.

    Raises
    ------
    EvidenceError
        Not text, or text that is no finite number with digits.

    >>> evidence_number("0.4903").half
    5e-05
    """
    if not isinstance(text, str):
        raise EvidenceError(where, f"{text!r}, a number without its digits", 'text as printed, such as "2.908"')
    number = printed_number(text, factor)
    if number is None:
        raise EvidenceError(where, f"{text!r}, no digits", 'a number as printed, such as "2.908"')
    return number


@dataclass(frozen=True, slots=True, eq=False)
class DerivedNumber:
    """A number its authors computed from the table: B_ii or g_i at a pose, or the largest B_ii over the joint box."""

    quantity: Quantity
    joint: int
    """Counted from 0."""
    printed: PrintedNumber
    q: Array | None = None
    """(n,) pose in the DH coordinate [rad or m]; none for "worst inertia"."""
    where: str = ""

    @property
    def name(self) -> str:
        """Such as "b55" or "g2"."""
        letter = "g" if self.quantity == "gravity" else f"b{self.joint + 1}"
        return f"{letter}{self.joint + 1}"


@dataclass(frozen=True, slots=True, eq=False)
class SecondTensors:
    """A second set of tensors for the same links, (n, 6) [kg m^2] in the order xx yy zz xy xz yz, NaN where unknown."""

    values: Array
    half: Array
    about: About
    products: tuple[Products, ...] = ("tensor",)
    """The possible signs of its products; both where they are not stated."""
    where: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class FlangePlace:
    """A printed place of the flange, (3,) [m], at a pose (n,), each with half its last digit."""

    q: Array
    xyz: Array
    half: float
    where: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Everything that a reading is compared with besides the table itself."""

    numbers: tuple[DerivedNumber, ...] = ()
    tensors: SecondTensors | None = None
    places: tuple[FlangePlace, ...] = ()
    alike: tuple[tuple[int, ...], ...] = ()
    """Groups of links declared to be one body, mirrored or turned; detected in the table if empty."""
    convention: str | None = None
    """DH convention, where the source states it."""

    @property
    def outermost_first(self) -> tuple[DerivedNumber, ...]:
        """The numbers, those of the last joint first."""
        return tuple(sorted(self.numbers, key=lambda number: -number.joint))

    def check(self, table: PrintedTable) -> None:
        """Raise `UnknownNameError` or `EvidenceError` where this is about another arm."""
        known = range(table.n)
        for joint in [x.joint for x in self.numbers] + [i for group in self.alike for i in group]:
            if joint not in known:
                raise UnknownNameError(f"joint of {table.name}", str(joint + 1), table.joints)
        for number in self.numbers:
            if number.q is not None:
                joint_array(f"q of {number.name}", number.q, table.n)
            elif number.quantity != "worst inertia":
                raise EvidenceError(number.name, "no pose", "q, or a largest B_ii")
        for place in self.places:
            joint_array("q of a flange place", place.q, table.n)
        if self.tensors is not None and self.tensors.values.shape != (table.n, 6):
            rows = f"{len(self.tensors.values)} rows"
            raise EvidenceError("tensors.values", rows, f"{table.n} rows of xx yy zz xy xz yz, one per link")


def second_tensors(
    rows: Sequence[Sequence[str]], about: About, products: Sequence[Products] = ("tensor",), where: str = ""
) -> SecondTensors:
    """Second tensors from printed texts [kg m^2], rows of xx yy zz xy xz yz, "-" where not printed.

    >>> second_tensors([("0.25", "0.5", "0.5", "-", "-", "-")], "origin").half[0, :2]
    array([0.005, 0.05 ])
    """
    cells = [[evidence_number(x, where="tensors.values") if x != BLANK else None for x in row] for row in rows]
    for i, row in enumerate(cells):
        if len(row) != len(TENSOR):
            raise EvidenceError(f"tensors.values[{i}]", f"{len(row)} entries", "6: xx yy zz xy xz yz")
    values = np.array([[math.nan if c is None else c.value for c in row] for row in cells])
    half = np.array([[math.nan if c is None else c.half for c in row] for row in cells])
    return SecondTensors(values, half, about, tuple(products), where)
