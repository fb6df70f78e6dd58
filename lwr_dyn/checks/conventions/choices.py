"""The conventions that a table leaves open, and the bodies that follow from each choice.

Of the whole table: DH convention, the point the tensors are about, the end of the link that centres of mass are
measured from. Of each link: sign of the products, order of the axes (of the tensor, or of the whole row).
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from lwr_dyn.checks.conventions.printed_table import TENSOR, PrintedTable
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Body
from lwr_dyn.model.dh import Convention
from lwr_dyn.model.spatial import principal_moments

About = Literal["com", "origin"]
Products = Literal["tensor", "integral"]
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
        if self.column == "com":
            return f"c{self.link + 1}{'xyz'[self.entry]}"
        if self.column == "mass":
            return f"m{self.link + 1}"
        r, c = TENSOR[self.entry]
        return f"I{self.link + 1}{'xyz'[r]}{'xyz'[c]}"


@dataclass(frozen=True, slots=True)
class TableReading:
    """One reading of a table: its conventions, those of the links, rows moved, cells changed."""

    table: TableChoice
    links: tuple[LinkChoice, ...]
    shift: int = 0
    """Rows by which the column of vectors between frames belongs lower than printed."""
    cells: tuple[CellChange, ...] = field(default=())


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


def link_choices() -> tuple[LinkChoice, ...]:
    """Signs times orders of axes, the plainest first."""
    out = [LinkChoice(p, a, m) for m in ("tensor", "row") for a in AXES for p in ("tensor", "integral")]
    return tuple(c for c in out if c.moved or c.moves == "tensor")


CHOICES = link_choices()


def link_options(
    table: PrintedTable, link: int, choice: TableChoice, other_end: Array, choices: Sequence[LinkChoice] = CHOICES
) -> LinkOptions:
    """The distinct bodies of a link.

    Parameters
    ----------
    table : PrintedTable
    link : int
        Counted from 0.
    choice : TableChoice
    other_end : (3,) array
        The link's other end in its own frame [m], see `frames.other_ends`.
    choices : sequence of LinkChoice, optional
    """
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
    kept, members = _distinct(com, about_com, table)
    reach = float(np.linalg.norm(com, axis=-1).max())
    return LinkOptions(
        choices=tuple(tuple(choices[m] for m in group) for group in members), mass=mass, com=com[kept],
        inertia_com=about_com[kept], parameters=parameters[kept], scale=float(np.abs(tensor).max()),
        deviation=_deviation(table, mass, reach, choice.about == "com"),
        deviation_com=float(_deviation(table, mass, reach, choice.about == "origin")[-1]),
    )  # fmt: skip


def _distinct(com: Array, tensor: Array, table: PrintedTable) -> tuple[list[int], list[list[int]]]:
    """Options that differ by more than half a last digit, each with its equals."""
    flat = np.concatenate([com / table.com_step, tensor.reshape(len(com), 9) / table.inertia_step], axis=-1)
    kept: list[int] = []
    members: list[list[int]] = []
    for i, row in enumerate(flat):
        near = [k for k, j in enumerate(kept) if np.abs(flat[j] - row).max() <= 0.5]
        if near:
            members[near[0]].append(i)
        else:
            kept.append(i)
            members.append([i])
    return kept, members


def _deviation(table: PrintedTable, mass: float, reach: float, moved: bool) -> Array:
    """One standard deviation of m, m c and a tensor by rounding of the cells; of a tensor `moved` by m c^2 or not."""
    m, c, t = (UNIFORM * step for step in (table.mass_step, table.com_step, table.inertia_step))
    moment = np.hypot(mass * c, m * reach)
    tensor = np.sqrt(t**2 + (2 * mass * reach * c) ** 2 + (m * reach**2) ** 2) if moved else t
    return np.array([m, *[moment] * 3, *[tensor] * 6])
