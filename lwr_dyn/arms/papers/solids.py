"""The solids of a drawn arm, and the bodies estimated from them where a source gives only a total mass.

A file's `drawing.solids` lists cylinders per link, in the frame of that link's DH row (the base: frame 0). The viewer
draws them, and where a paper has no masses the estimate is

    mass_i = total V_i / sum V,    com_i and tensor_i those of link i's cylinders at that one density

The base is part of the sum. Cylinders that overlap count twice, so joints, where the drives are, are denser. Such
tensors are always physical, and a drawing with mirror symmetry gives products of zero.
"""

import math
from collections.abc import Sequence

import numpy as np

from lwr_dyn.arms.papers.schema import KINDS, UNITS, Solids, to_si, units_of
from lwr_dyn.foundation.fields import Fields
from lwr_dyn.model.chain import Body
from lwr_dyn.model.file_layout import DrawnCylinder
from lwr_dyn.model.spatial import axis_to_z

COLOURS = ("orange", "grey", "dark")
MASS_DIGITS, COM_DIGITS, INERTIA_DIGITS = 2, 4, 5
"""Decimals of an estimate in a data file, in kg, m, kg m^2: enough for the smallest link's triangle inequality."""


def read_solids(fields: Fields, links: Sequence[str]) -> Solids:
    """`drawing.solids` of a file: unit, where, kind and rows of link, from, to, radius, colour; raises `PaperError`."""
    unit, where = fields.text("unit"), fields.text("where")
    kind, rows = fields.choice("kind", KINDS), fields.tables("rows")
    fields.refuse_unknown()
    if unit not in UNITS or UNITS[unit][0] != "length":
        raise fields.refuse("unit", repr(unit), ", ".join(units_of("length")))
    return Solids(tuple(_solid(row, links, unit) for row in rows), where, kind)


def _solid(fields: Fields, links: Sequence[str], unit: str) -> DrawnCylinder:
    link = fields.choice("link", links)
    start, end = (tuple(to_si(x, unit) for x in fields.row(key, 3)) for key in ("from", "to"))
    radius = fields.number("radius", above=0.0)
    if start == end:
        raise fields.refuse("", f"from and to are both {list(start)}", "a cylinder with a length")
    colour = fields.choice("colour", COLOURS)
    fields.refuse_unknown()
    return DrawnCylinder(link, start, end, to_si(radius, unit), colour)  # type: ignore[arg-type] # three numbers each


def cylinder_body(cylinder: DrawnCylinder, density: float) -> Body:
    """A solid cylinder of one density [kg/m^3] in the frame of its ends.

    I = m r^2/2 about its axis, m (3 r^2 + l^2)/12 across.
    """
    start, end = np.array(cylinder.start), np.array(cylinder.end)
    length, radius = float(np.linalg.norm(end - start)), cylinder.radius
    mass = density * math.pi * radius**2 * length
    across = mass * (3.0 * radius**2 + length**2) / 12.0
    turn = axis_to_z(end - start)
    tensor = turn @ np.diag([across, across, mass * radius**2 / 2.0]) @ turn.T
    return Body(mass, (start + end) / 2.0, (tensor + tensor.T) / 2.0)


def solid_bodies(solids: Solids, total: float) -> dict[str, Body]:
    """Link (the base included) -> its body when `total` [kg] is spread over all solids at one density."""
    unit: dict[str, Body] = {}
    for cylinder in solids.cylinders:
        unit[cylinder.link] = unit.get(cylinder.link, Body.massless()) + cylinder_body(cylinder, 1.0)
    density = total / sum(body.mass for body in unit.values())
    return {link: Body(density * body.mass, body.com, density * body.inertia_com) for link, body in unit.items()}
