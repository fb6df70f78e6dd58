"""Evidence as data: a TOML file with what a source publishes beside its table, each number with its page.

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

from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.fields import Fields, parse_toml
from lwr_dyn.arms.papers.schema import ABOUT, PRODUCTS
from lwr_dyn.arms.papers.units import UNITS, to_si, units_of
from lwr_dyn.checks.conventions.evidence import (
    DerivedNumber,
    Evidence,
    EvidenceError,
    FlangePlace,
    SecondTensors,
    evidence_number,
    second_tensors,
)
from lwr_dyn.checks.conventions.printed_table import PrintedTable
from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.foundation.files import read_text
from lwr_dyn.model.dh import Convention, JointKind

QUANTITIES = {
    "inertia": ("inertia", "mass"), "worst inertia": ("inertia", "mass"), "gravity": ("torque", "force"),
}  # fmt: skip
"""Quantity of a derived number -> quantity of its unit at a turning joint, at a sliding one."""


def read_evidence(path: str | Path, table: PrintedTable) -> Evidence:
    """Evidence from a TOML file, for the arm of a table.

    Raises
    ------
    FileAccessError
        The file cannot be read.
    EvidenceError
        Broken TOML, an unknown or missing field, a number without digits.
    UnknownNameError
        A joint or link that the arm does not have.
    """
    return parse_evidence(read_text(path, "a readable .toml file"), Path(path).name, table)


def packaged_evidence(robot: str, table: PrintedTable) -> Evidence:
    """Evidence that comes with the package for a robot's name; empty where there is none."""
    place = resources.files("lwr_dyn.arms.papers").joinpath("evidence", f"{robot}.toml")
    return parse_evidence(place.read_text(encoding="utf-8"), place.name, table) if place.is_file() else Evidence()


def parse_evidence(text: str, file: str, table: PrintedTable) -> Evidence:
    """`read_evidence` on text; raises as it does."""
    top = Fields(parse_toml(text, file), file, "")
    top.take("robot", str, default="")
    numbers = [_number(x, file, f"number[{i}]", table) for i, x in enumerate(top.take("number", list, default=[]))]
    places = [_place(x, file, f"place[{i}]", table) for i, x in enumerate(top.take("place", list, default=[]))]
    tensors = top.take("tensors", dict, default=None)
    arm = Fields(top.take("arm", dict, default={}), file, "arm")
    convention = arm.take_one_of("convention", [c.value for c in Convention], default="")
    links = [f"link_{i + 1}" for i in range(table.n)]
    alike = tuple(_group(group, links, file) for group in arm.take("alike", list, default=[]))
    arm.refuse_unknown()
    top.refuse_unknown()
    second = None if tensors is None else _tensors(tensors, file)
    evidence = Evidence(tuple(numbers), second, tuple(places), alike, convention or None)
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


def _number(entry: Any, file: str, path: str, table: PrintedTable) -> DerivedNumber:
    fields = Fields(entry, file, path)
    quantity = fields.take_one_of("quantity", list(QUANTITIES))
    joint = _index(fields.take("joint", str), f"joint of {table.name}", list(table.joints))
    factor = _factor(fields, QUANTITIES[quantity][table.kinds[joint] is JointKind.PRISMATIC])
    printed = evidence_number(fields.take("value", object), factor, f"{path}.value")
    where = fields.take("where", str)
    q = None if quantity == "worst inertia" else _pose(fields, path, table)
    fields.refuse_unknown()
    return DerivedNumber(quantity, joint, printed, q, where)  # type: ignore[arg-type] # one of QUANTITIES


def _place(entry: Any, file: str, path: str, table: PrintedTable) -> FlangePlace:
    fields = Fields(entry, file, path)
    q, factor = _pose(fields, path, table), _factor(fields, "length")
    xyz = [evidence_number(x, factor, f"{path}.xyz") for x in fields.take("xyz", list)]
    if len(xyz) != 3:
        raise EvidenceError(f"{path}.xyz", f"{len(xyz)} entries", "3: x y z")
    where = fields.take("where", str)
    fields.refuse_unknown()
    return FlangePlace(q, np.array([x.value for x in xyz]), max(x.half for x in xyz), where)


def _pose(fields: Fields, path: str, table: PrintedTable) -> Array:
    unit = fields.take_one_of("q_unit", units_of("angle"), default="deg")
    q = joint_array(f"{path}.q", fields.take("q", list), table.n)
    slides = [kind is JointKind.PRISMATIC for kind in table.kinds]
    return np.array([float(x) if s else to_si(float(x), unit) for x, s in zip(q, slides, strict=True)])


def _factor(fields: Fields, quantity: str) -> float:
    return UNITS[fields.take_one_of("unit", units_of(quantity))][1]


def _tensors(entry: Any, file: str) -> SecondTensors:
    fields = Fields(entry, file, "tensors")
    about = fields.take_one_of("about", ABOUT)
    products = fields.take_one_of("products", (*PRODUCTS, "unknown"))
    fields.take_one_of("unit", ("kg m^2",))
    where, values = fields.take("where", str), fields.take("values", list)
    fields.refuse_unknown()
    if not all(isinstance(row, list) for row in values):
        raise EvidenceError("tensors.values", "not a list of rows", "one row of xx yy zz xy xz yz per link")
    signs = PRODUCTS if products == "unknown" else (products,)
    return second_tensors(values, about, signs, where)  # type: ignore[arg-type] # both are checked words
