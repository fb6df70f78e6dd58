"""The solids of a drawn arm, and the bodies that follow from them when a source gives nothing but a total mass.

A file's `drawing.solids` lists cylinders per link, in the frame of that link's DH row (the base: frame 0). They are
what the viewer shows, and where a paper has no masses they carry the estimate:

    mass_i = total V_i / sum V,    com_i and tensor_i those of link i's cylinders at that one density

The base takes part in the sum. Cylinders that overlap count twice: joints, where drives sit, come out heavier. Whatever
the drawing, such tensors belong to a body (a density >= 0 exists), and a drawing that is its own mirror image gives
products of zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import PaperError
from lwr_dyn.model.chain import Body
from lwr_dyn.model.spatial import axis_to_z
from lwr_dyn.papers.fields import Fields, choice
from lwr_dyn.papers.schema import KINDS, Solid, Solids
from lwr_dyn.papers.units import UNITS, to_si, units_of

COLOURS = ("orange", "grey", "dark")
MASS_DIGITS, COM_DIGITS, INERTIA_DIGITS = 2, 4, 5
"""Decimals of an estimate in kg, m, kg m^2: as many as keep the smallest link's triangle inequality."""


def read_solids(table: Any, links: Sequence[str], file: str) -> Solids:
    """`drawing.solids` of a file: unit, where, kind and rows of link, from, to, radius, colour; raises `PaperError`."""
    name = "drawing.solids"
    fields = Fields(table, file, name)
    unit, where = fields.take("unit", str), fields.take("where", str)
    kind = choice(fields.take("kind", str), KINDS, file, f"{name}.kind")
    rows = fields.take("rows", list)
    fields.refuse_unknown()
    if unit not in UNITS or UNITS[unit][0] != "length":
        raise PaperError(file, f"{name}.unit", repr(unit), ", ".join(units_of("length")))
    cylinders = tuple(_solid(row, links, unit, file, f"{name}.rows[{i}]") for i, row in enumerate(rows))
    return Solids(cylinders, where, kind)


def _solid(row: Any, links: Sequence[str], unit: str, file: str, name: str) -> Solid:
    fields = Fields(row, file, name)
    link = choice(fields.take("link", str), links, file, f"{name}.link")
    start, end = (_point(fields.take(key, list), unit, file, f"{name}.{key}") for key in ("from", "to"))
    radius = fields.take("radius", object)
    if isinstance(radius, bool) or not isinstance(radius, int | float) or not 0.0 < radius < math.inf:
        raise PaperError(file, f"{name}.radius", repr(radius), "a number above 0")
    if start == end:
        raise PaperError(file, name, f"from and to are both {list(start)}", "a cylinder with a length")
    colour = choice(fields.take("colour", str), COLOURS, file, f"{name}.colour")
    fields.refuse_unknown()
    return Solid(link, start, end, to_si(float(radius), unit), colour)


def _point(cells: list[Any], unit: str, file: str, name: str) -> tuple[float, float, float]:
    good = all(isinstance(x, int | float) and not isinstance(x, bool) and math.isfinite(x) for x in cells)
    if len(cells) != 3 or not good:
        raise PaperError(file, name, repr(cells), "a list of 3 finite numbers")
    x, y, z = (to_si(float(cell), unit) for cell in cells)
    return x, y, z


def cylinder_body(solid: Solid, density: float) -> Body:
    """A full cylinder of one density [kg/m^3] in the frame its ends are given in.

    I = m r^2/2 about its axis, m (3 r^2 + l^2)/12 across.
    """
    start, end = np.array(solid.start), np.array(solid.end)
    length, radius = float(np.linalg.norm(end - start)), solid.radius
    mass = density * math.pi * radius**2 * length
    across = mass * (3.0 * radius**2 + length**2) / 12.0
    turn = axis_to_z(end - start)
    tensor = turn @ np.diag([across, across, mass * radius**2 / 2.0]) @ turn.T
    return Body(mass, (start + end) / 2.0, (tensor + tensor.T) / 2.0)


def estimated_bodies(solids: Solids, total: float) -> Mapping[str, Body]:
    """Link (the base included) -> its body when `total` [kg] is spread over all solids at one density, rounded.

    Masses are rounded to `MASS_DIGITS`; the base takes what rounding leaves, so that the sum stays the total.
    """
    unit: dict[str, Body] = {}
    for solid in solids.cylinders:
        unit[solid.link] = unit.get(solid.link, Body.nothing()) + cylinder_body(solid, 1.0)
    density = total / sum(body.mass for body in unit.values())
    bodies = {}
    for link, body in unit.items():
        mass, com = round(density * body.mass, MASS_DIGITS), _rounded(body.com, COM_DIGITS)
        bodies[link] = Body(mass, com, _rounded(density * body.inertia_com, INERTIA_DIGITS))
    moving = sum(body.mass for link, body in bodies.items() if link != "base")
    if "base" in bodies:
        base = bodies["base"]
        bodies["base"] = Body(round(total - moving, MASS_DIGITS), base.com, base.inertia_com)
    return bodies


def _rounded(values: Array, digits: int) -> Array:
    return np.round(values, digits) + 0.0
