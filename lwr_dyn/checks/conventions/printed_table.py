"""A table as its source prints it: cells in SI units, blanks as NaN, the last printed digit of each column.

The file's errata, readings, DH convention, `about` and `products` are left out: they are what is sought.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper, require_plain_dh
from lwr_dyn.arms.papers.schema import UNKNOWN, Paper
from lwr_dyn.arms.papers.units import to_si
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import Chain, ChainLink
from lwr_dyn.model.dh import Convention, DHRow, JointKind
from lwr_dyn.model.spatial import Pose

BLANK = "-"
"""A cell that the source leaves empty."""


@dataclass(frozen=True, slots=True, eq=False)
class PrintedTable:
    """The tables of an arm as printed, n links; a step is the unit of a column's last printed digit."""

    name: str
    joints: tuple[str, ...]
    rows: tuple[DHRow, ...]
    """alpha, a, d, theta offset, sign, of either DH convention."""
    kinds: tuple[JointKind, ...]
    mass: Array
    """(n,) [kg]"""
    com: Array
    """(n, 3) [m], NaN where blank."""
    inertia: Array
    """(n, 3, 3) [kg m^2], about a point, with axes and signs of products that are not known."""
    mass_step: float
    com_step: float
    inertia_step: float
    origin: Array | None = None
    """(n, 3) [m]: vectors between neighbouring frames that stand beside the table, if any."""
    armature: Array | None = None
    """(n,) rotor inertia as the joint feels it [kg m^2]."""
    lower: Array | None = None
    upper: Array | None = None
    """(n,) joint box in the DH coordinate [rad or m]."""
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    flange: Pose = Pose.identity()  # noqa: RUF009 # read-only

    @property
    def n(self) -> int:
        """Number of links."""
        return len(self.joints)

    def chain(self, convention: Convention) -> Chain:
        """The frames alone, without bodies, under one DH convention."""
        links = []
        for i, row in enumerate(self.rows):
            before, after = row.fixed_poses(convention)
            links.append(ChainLink(self.joints[i], f"link_{i + 1}", self.kinds[i], before, after))
        return Chain(tuple(links), self.flange, np.array(self.gravity))

    def cell(self, column: str, link: int, index: int) -> float:
        """One cell of `com` (index 0 to 2), `inertia` (0 to 5, see `TENSOR`) or `mass`."""
        if column == "inertia":
            return float(self.inertia[link][TENSOR[index]])
        return float(self.com[link, index] if column == "com" else self.mass[link])

    def with_cell(self, column: str, link: int, index: int, value: float) -> PrintedTable:
        """The table with one cell changed, see `cell`."""
        values = getattr(self, column).copy()
        if column == "inertia":
            r, c = TENSOR[index]
            values[link, r, c] = values[link, c, r] = value
        elif column == "com":
            values[link, index] = value
        else:
            values[link] = value
        return replace(self, **{column: values})


TENSOR = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Order of the six entries of a symmetric tensor: xx, yy, zz, xy, xz, yz."""


def printed_table(paper: Paper) -> PrintedTable:
    """The printed cells of a paper's tables.

    Raises
    ------
    MissingDataError
        The file has no masses and inertias to read.
    """
    printed = paper.printed
    if "inertial" not in printed:
        raise MissingDataError(paper.name, "masses and inertias", "a reading of its inertial table")
    mass, com, inertia = (printed["inertial"][name] for name in ("mass", "com", "inertia"))
    origin = printed.get("frames", {}).get("origin")
    arm = arm_from_paper(paper)
    x, y, z = arm.chain.gravity.tolist()
    return PrintedTable(
        name=paper.name, joints=paper.joints, rows=printed_rows(paper), kinds=paper.kinds,
        mass=_cells(mass, ()), com=_cells(com, (3,)), inertia=_cells(inertia, (3, 3)),
        mass_step=finest_digit(mass), com_step=finest_digit(com), inertia_step=finest_digit(inertia),
        origin=None if origin is None else _cells(origin, (3,)), armature=_armature(printed.get("rotors", {})),
        lower=arm.lower if "limits.lower" in paper.columns else None,
        upper=arm.upper if "limits.upper" in paper.columns else None,
        gravity=(x, y, z), flange=arm.chain.flange,
    )  # fmt: skip


def printed_rows(paper: Paper) -> tuple[DHRow, ...]:
    """The DH table as printed, without the errata of any reading."""
    require_plain_dh(paper, "conventions")
    n, table = paper.n, paper.printed["dh"]
    names = ("alpha", "a", "d", "theta_offset")
    alpha, a, d, theta = (_cells(table[x], ()) if x in table else np.zeros(n) for x in names)
    sign = _cells(table["sign"], ()) if "sign" in table else np.ones(n)
    return tuple(
        DHRow(float(alpha[i]), float(a[i]), float(d[i]), float(theta[i]), -1 if sign[i] < 0 else 1) for i in range(n)
    )


def _cells(column: Mapping[str, Any], shape: tuple[int, ...]) -> Array:
    """A column as printed [SI], (n, *shape), NaN where a row is blank or known in part."""
    rows, unit = column["values"], column["unit"]
    units = unit if isinstance(unit, list) else [unit] * len(rows)
    out = np.full((len(rows), *shape), np.nan)
    for i, (row, u) in enumerate(zip(rows, units, strict=True)):
        if row != BLANK and UNKNOWN not in np.array(row, dtype=object).ravel():
            out[i] = np.vectorize(lambda x, u=u: to_si(float(x), u), otypes=[float])(np.array(row, dtype=float))
    return out


def finest_digit(table: Mapping[str, Any]) -> float:
    """The unit of the last printed digit of a column [SI]: the finest that any of its cells shows.

    >>> finest_digit({"values": [0.25, 0.1234], "unit": "m"})
    0.0001
    """
    cells = [
        x for row in table["values"] if row != BLANK for x in np.ravel(np.array(row, dtype=object)) if x != UNKNOWN
    ]
    exponents = [Decimal(repr(x)).normalize().as_tuple().exponent for x in cells]
    finest = min([e for e in exponents if isinstance(e, int)], default=0)
    unit = table["unit"][0] if isinstance(table["unit"], list) else table["unit"]
    return to_si(float(Decimal(1).scaleb(finest)), unit)


def _armature(rotors: Mapping[str, Any]) -> Array | None:
    if "armature" in rotors:
        return _cells(rotors["armature"], ())
    if "gear_ratio" in rotors and "inertia" in rotors:
        armature: Array = _cells(rotors["gear_ratio"], ()) ** 2 * _cells(rotors["inertia"], ())
        return armature
    return None
