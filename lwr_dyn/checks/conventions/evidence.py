"""What a source publishes beside its table: numbers derived from it, a second set of tensors, poses, repeated links.

A value is text, so that its printed digits are known: a reading may miss it by half a unit of the last one. As a TOML
file, each number with its page:

    robot = "my arm"
    [[number]]                     # what the authors computed from the table
    quantity = "inertia"           # B_ii; "gravity" for g_i; "worst inertia" for the largest B_ii over the limits
    joint = "joint_2"
    value = "2.908"                # text, so that its digits are known
    unit = "kg m^2"                # or "N m" for gravity
    q = [0, 90, 0]                 # in q_unit, sliding joints in m; left out for "worst inertia"
    q_unit = "deg"
    where = "Table IV"
    [tensors]                      # a second set, xx yy zz xy xz yz a link, "-" where not printed
    about = "origin"
    products = "tensor"            # "integral", or "unknown"
    unit = "kg m^2"
    where = "..."
    values = [["0.2948", "0.1135", "0.2506", "0.0079", "-", "-"]]
    [[place]]                      # where the flange is at a pose
    q = [0, 0, 0]
    q_unit = "deg"
    xyz = ["0.45", "0", "0.910"]
    unit = "m"
    where = "..."
    [arm]
    convention = "standard"        # where the source does state it
    alike = [["link_1", "link_2"]] # links that are declared to be one body, mirrored

Every table may be left out.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Literal

import numpy as np

from lwr_dyn.arms.papers.schema import ABOUT, PRODUCTS, UNITS, to_si, units_of
from lwr_dyn.checks.conventions.printed_table import BLANK, TENSOR, About, PrintedTable, Products
from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import FaultError, UnknownNameError
from lwr_dyn.foundation.fields import Fields, parse_toml
from lwr_dyn.foundation.files import read_text
from lwr_dyn.model.chain import Convention, JointKind
from lwr_dyn.model.printed_number import PrintedNumber, printed_number

Quantity = Literal["inertia", "worst inertia", "gravity"]


class EvidenceError(FaultError, ValueError):
    """Evidence for a reading cannot be used: `where` is the entry."""

    def __init__(self, where: str, found: str, allowed: str) -> None:
        super().__init__(f"evidence: {where}", found, allowed)
        self.where = where


def evidence_number(text: object, factor: float = 1.0, where: str = "evidence") -> PrintedNumber:
    """A number from text such as "2.924" in a unit of `factor` SI units.

    Raises `EvidenceError` for anything but the text of a finite number with digits.

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


@dataclass(frozen=True, slots=True, eq=False)
class FlangePlace:
    """A printed place of the flange, (3,) [m], at a pose (n,), each with half its last digit."""

    q: Array
    xyz: Array
    half: float


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
    rows: Sequence[Sequence[str]], about: About, products: Sequence[Products] = ("tensor",)
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
    return SecondTensors(values, half, about, tuple(products))


QUANTITIES = {
    "inertia": ("inertia", "mass"), "worst inertia": ("inertia", "mass"), "gravity": ("torque", "force"),
}  # fmt: skip
"""Quantity of a derived number -> quantity of its unit at a turning joint, at a sliding one."""


def read_evidence(path: str | Path, table: PrintedTable) -> Evidence:
    """Evidence from a TOML file, for the arm of a table.

    Raises `FileAccessError`; `EvidenceError` for broken TOML, an unknown or missing field, a number without digits;
    `UnknownNameError` for a joint or link that the arm does not have.
    """
    return parse_evidence(read_text(path, "a readable .toml file"), Path(path).name, table)


def packaged_evidence(robot: str, table: PrintedTable) -> Evidence:
    """Evidence that comes with the package for a robot's name; empty where there is none."""
    place = resources.files("lwr_dyn.arms.papers").joinpath("evidence", f"{robot}.toml")
    return parse_evidence(place.read_text(encoding="utf-8"), place.name, table) if place.is_file() else Evidence()


def parse_evidence(text: str, file: str, table: PrintedTable) -> Evidence:
    """`read_evidence` on text; raises as it does."""
    top = Fields(parse_toml(text, file), file)
    top.text("robot", default="")
    numbers = tuple(_number(x, table) for x in top.tables("number", default=[]))
    places = tuple(_place(x, table) for x in top.tables("place", default=[]))
    second = None if "tensors" not in top.unread() else _tensors(top.table("tensors"))
    arm = top.table("arm", default={})
    convention = arm.choice("convention", [c.value for c in Convention], default="")
    links = [f"link_{i + 1}" for i in range(table.n)]
    alike = tuple(_group(group, links, file) for group in arm.take("alike", list, default=[]))
    arm.refuse_unknown()
    top.refuse_unknown()
    evidence = Evidence(numbers, second, places, alike, convention or None)
    evidence.check(table)
    return evidence


def _group(names: object, links: list[str], file: str) -> tuple[int, ...]:
    """Links that are one body, mirrored; a link compared with itself would be no evidence."""
    group = tuple(_index(x, "link", links) for x in names) if isinstance(names, list) else ()
    if len(set(group)) < 2 or len(set(group)) < len(group):
        raise EvidenceError(f"{file}: arm.alike", repr(names), "lists of two or more different links")
    return group


def _index(name: object, kind: str, known: list[str]) -> int:
    if name not in known:
        raise UnknownNameError(kind, str(name), known)
    return known.index(str(name))


def _number(fields: Fields, table: PrintedTable) -> DerivedNumber:
    quantity = fields.choice("quantity", list(QUANTITIES))
    joint = _index(fields.text("joint"), f"joint of {table.name}", list(table.joints))
    factor = _factor(fields, QUANTITIES[quantity][table.kinds[joint] is JointKind.PRISMATIC])
    printed = evidence_number(fields.take("value", object), factor, fields.name_of("value"))
    fields.text("where")
    q = None if quantity == "worst inertia" else _pose(fields, table)
    fields.refuse_unknown()
    return DerivedNumber(quantity, joint, printed, q)  # type: ignore[arg-type] # one of QUANTITIES


def _place(fields: Fields, table: PrintedTable) -> FlangePlace:
    q, factor, name = _pose(fields, table), _factor(fields, "length"), fields.name_of("xyz")
    xyz = [evidence_number(x, factor, name) for x in fields.take("xyz", list)]
    if len(xyz) != 3:
        raise EvidenceError(name, f"{len(xyz)} entries", "3: x y z")
    fields.text("where")
    fields.refuse_unknown()
    return FlangePlace(q, np.array([x.value for x in xyz]), max(x.half for x in xyz))


def _pose(fields: Fields, table: PrintedTable) -> Array:
    unit = fields.choice("q_unit", units_of("angle"), default="deg")
    q = joint_array(fields.name_of("q"), fields.take("q", list), table.n)
    slides = [kind is JointKind.PRISMATIC for kind in table.kinds]
    return np.array([float(x) if s else to_si(float(x), unit) for x, s in zip(q, slides, strict=True)])


def _factor(fields: Fields, quantity: str) -> float:
    return UNITS[fields.choice("unit", units_of(quantity))][1]


def _tensors(fields: Fields) -> SecondTensors:
    about = fields.choice("about", ABOUT)
    products = fields.choice("products", (*PRODUCTS, "unknown"))
    fields.choice("unit", ("kg m^2",))
    fields.text("where")
    values = fields.take("values", list)
    fields.refuse_unknown()
    if not all(isinstance(row, list) for row in values):
        raise EvidenceError("tensors.values", "not a list of rows", "one row of xx yy zz xy xz yz per link")
    signs = PRODUCTS if products == "unknown" else (products,)
    return second_tensors(values, about, signs)  # type: ignore[arg-type] # both are checked words
