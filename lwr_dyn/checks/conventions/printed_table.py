"""A table as its source prints it, the conventions that it leaves open, and the bodies that follow from each choice.

Cells are in SI units, blanks NaN, and the last printed digit of each column is known. The file's errata, readings, DH
convention, `about` and `products` are left out: they are what is sought. Open for the whole table: DH convention, the
point the tensors are about, the end of the link that centres of mass are measured from; for each link: sign of the
products, order of the axes (of the tensor, or of the whole row).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any, Literal

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper, require_plain_dh
from lwr_dyn.arms.papers.schema import UNKNOWN, Paper, to_si
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import Body, Chain, ChainLink, Convention, DHRow, JointKind
from lwr_dyn.model.spatial import Pose, from_rpy, principal_moments

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
        return float(getattr(self, column)[_place(column, link, index)])

    def with_cell(self, column: str, link: int, index: int, value: float) -> PrintedTable:
        """The table with one cell changed, see `cell`."""
        values, (_, *entry) = getattr(self, column).copy(), _place(column, link, index)
        values[link, *entry] = values[link, *reversed(entry)] = value
        return replace(self, **{column: values})


def _place(column: str, link: int, index: int) -> tuple[int, ...]:
    """Where a cell stands in its array."""
    return {"mass": (link,), "com": (link, index), "inertia": (link, *TENSOR[index])}[column]


TENSOR = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Order of the six entries of a symmetric tensor: xx, yy, zz, xy, xz, yz."""


def printed_table(paper: Paper) -> PrintedTable:
    """The printed cells of a paper's tables; raises `MissingDataError` where it has no masses and inertias to read."""
    printed = paper.printed
    if "inertial" not in printed:
        raise MissingDataError(paper.name, "masses and inertias", "a reading of its inertial table")
    mass, com, inertia = (printed["inertial"][name] for name in ("mass", "com", "inertia"))
    origin = printed.get("frames", {}).get("origin")
    arm = arm_from_paper(paper)
    x, y, z = arm.chain.gravity.tolist()
    return PrintedTable(
        name=paper.name, joints=paper.joints, rows=printed_rows(paper), kinds=paper.kinds,
        mass=_cells(mass, ()), com=_cells(com, (3,)), inertia=_tensors(inertia, printed["inertial"].get("rpy")),
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


def _tensors(column: Mapping[str, Any], own_axes: Mapping[str, Any] | None) -> Array:
    """The tensors as printed, (n, 3, 3), brought from their own axes to those of the frames where these are stated."""
    tensors = _cells(column, (3, 3))
    if own_axes is None:
        return tensors
    turns = np.array([from_rpy(rpy) for rpy in _cells(own_axes, (3,))])
    return np.asarray(turns @ tensors @ turns.swapaxes(1, 2))


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


About = Literal["com", "origin"]
Products = Literal["tensor", "integral"]
PRODUCTS: tuple[Products, ...] = ("tensor", "integral")
ComFrom = Literal["own frame", "other end"]
AXES = tuple("".join(p) for p in itertools.permutations("xyz"))
"""Orders of the axes: under "xzy" the entries printed as y belong to z, and those printed as z to y."""
_OFF = ~np.eye(3, dtype=bool)
UNIFORM = 1.0 / np.sqrt(12.0)
"""Standard deviation of a rounding, in units of the last digit."""


@dataclass(frozen=True, slots=True)
class TableChoice:
    """Conventions of the whole table."""

    convention: Convention
    about: About
    com_from: ComFrom = "own frame"


@dataclass(frozen=True, slots=True)
class LinkChoice:
    """Conventions of the row of one link."""

    products: Products = "tensor"
    axes: str = "xyz"
    moves: Literal["tensor", "row"] = "tensor"
    """The order of the axes holds for the tensor alone, or for the whole row with the centre of mass."""

    @property
    def moved(self) -> bool:
        """The axes are in another order than printed."""
        return self.axes != "xyz"


_LETTERS = {"mass": "m", "com": "c", "inertia": "I"}


@dataclass(frozen=True, slots=True)
class CellChange:
    """One cell with another value than printed: column, link (from 0), entry, printed value, value that fits."""

    column: str
    link: int
    entry: int
    printed: float
    value: float

    @property
    def name(self) -> str:
        """Such as "c5z", "I2yy", "m3"."""
        _, *entry = _place(self.column, self.link, self.entry)
        return f"{_LETTERS[self.column]}{self.link + 1}{''.join('xyz'[k] for k in entry)}"


@dataclass(frozen=True, slots=True)
class TableReading:
    """One reading of a table: its conventions, those of the links, rows moved, cells changed."""

    table: TableChoice
    links: tuple[LinkChoice, ...]
    shift: int = 0
    """Rows by which the column of vectors between frames belongs lower than printed."""
    cells: tuple[CellChange, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class LinkOptions:
    """Every distinct body that one link can be under one table choice, O of them."""

    choices: tuple[tuple[LinkChoice, ...], ...]
    """Per option the choices that give this same body to the printed digits, the plainest first."""
    mass: float
    com: Array
    """(O, 3) [m]"""
    inertia_com: Array
    """(O, 3, 3) [kg m^2]"""
    parameters: Array
    """(O, 10): m, m c, tensor about the origin (xx yy zz xy xz yz); B and g are linear in them."""
    deviation: Array
    """(10,) one standard deviation of the parameters by rounding of the printed cells."""
    deviation_com: float
    """The same of an entry of the tensor about the com."""
    scale: float
    """Largest printed entry of the tensor [kg m^2]."""

    @property
    def log_inertia_volume(self) -> Array:
        """log det of the second moments of mass about the com, (O,): flat and thin for a wrong sign or point.

        Sigma = tr(I)/2 E - I; larger is more plausible, -inf where no body is. The determinant is the part of that of
        the pseudo-inertia which a sign can change (Wensing, Kim, Slotine, "Linear matrix inequalities for physically
        consistent inertial parameter identification", 2018, eq. 16).
        """
        trace = np.trace(self.inertia_com, axis1=-2, axis2=-1)
        second = trace[:, None] / 2 - principal_moments(self.inertia_com)
        good = (second > 0.0).all(axis=-1)
        volume: Array = np.where(good, np.log(np.where(good[:, None], second, 1.0)).sum(axis=-1), -np.inf)
        return volume

    def body(self, option: int) -> Body:
        """The body of one option."""
        return Body(self.mass, self.com[option], self.inertia_com[option])


def moved_axes(axes: str) -> list[int]:
    """Indices of the printed entries: entry k of the true vector is entry [k] of the printed one.

    >>> moved_axes("xzy")
    [0, 2, 1]
    """
    return ["xyz".index(a) for a in axes]


CHOICES = tuple(
    LinkChoice(p, a, m) for m in ("tensor", "row") for a in AXES for p in PRODUCTS if m == "tensor" or a != AXES[0]
)
"""Signs times orders of axes, the plainest first."""


def link_options(
    table: PrintedTable, link: int, choice: TableChoice, other_end: Array, choices: Sequence[LinkChoice] = CHOICES
) -> LinkOptions:
    """The distinct bodies of a link (from 0); `other_end` (3,) [m] is that of `hypotheses.other_ends`."""
    mass, tensor = float(table.mass[link]), table.inertia[link]
    shift = other_end if choice.com_from == "other end" else np.zeros(3)
    orders = [moved_axes(c.axes) for c in choices]
    plain = table.com[link]
    rows = [plain[o] if c.moves == "row" else plain for c, o in zip(choices, orders, strict=True)]
    com = np.array(rows) + shift
    signs = [np.where(_OFF, -1.0, 1.0) if c.products == "integral" else np.ones((3, 3)) for c in choices]
    given = np.array([(tensor * s)[np.ix_(o, o)] for s, o in zip(signs, orders, strict=True)])
    far = mass * (np.einsum("oi,oi->o", com, com)[:, None, None] * np.eye(3) - com[:, :, None] * com[:, None, :])
    about_com = given - far if choice.about == "origin" else given
    about_origin = given if choice.about == "origin" else given + far
    six = np.stack([about_origin[:, r, c] for r, c in TENSOR], axis=-1)
    parameters = np.concatenate([np.full((len(com), 1), mass), mass * com, six], axis=-1)
    members = _distinct(com, about_com, table)
    kept = list(members)
    reach = float(np.linalg.norm(com, axis=-1).max())
    return LinkOptions(
        choices=tuple(tuple(choices[m] for m in group) for group in members.values()), mass=mass, com=com[kept],
        inertia_com=about_com[kept], parameters=parameters[kept], scale=float(np.abs(tensor).max()),
        deviation=_deviation(table, mass, reach, choice.about == "com"),
        deviation_com=float(_deviation(table, mass, reach, choice.about == "origin")[-1]),
    )  # fmt: skip


def _distinct(com: Array, tensor: Array, table: PrintedTable) -> dict[int, list[int]]:
    """Options that differ by more than half a last digit -> all that equal it, itself first."""
    flat = np.concatenate([com / table.com_step, tensor.reshape(len(com), 9) / table.inertia_step], axis=-1)
    members: dict[int, list[int]] = {}
    for i, row in enumerate(flat):
        near = next((k for k in members if np.abs(flat[k] - row).max() <= 0.5), i)
        members.setdefault(near, []).append(i)
    return members


def _deviation(table: PrintedTable, mass: float, reach: float, moved: bool) -> Array:
    """One standard deviation of m, m c and a tensor by rounding of the cells; of a tensor `moved` by m c^2 or not."""
    m, c, t = (UNIFORM * step for step in (table.mass_step, table.com_step, table.inertia_step))
    moment = np.hypot(mass * c, m * reach)
    tensor = np.sqrt(t**2 + (2 * mass * reach * c) ** 2 + (m * reach**2) ** 2) if moved else t
    return np.array([m, *[moment] * 3, *[tensor] * 6])
