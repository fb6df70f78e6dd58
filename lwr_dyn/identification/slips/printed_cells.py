"""The inertial cells of a table as its source prints them, and the parameters of the torques that they stand for.

    pi_i = (m, m c, I_o),   I_o = I about the link's frame, or I + m (|c|^2 1 - c c^T) where I is printed about the com

Products of inertia may be printed with either sign; a rotor counts as `rotor_factor` times its printed cell.

Which of the cells a motion can show (none at all, only with others, alone) geometry decides, not a log. How far an arm
may be from a table that has no slip is a covariance of its parameters about the table's, that of the kinds of
`bodies.link_spreads`: delta of shapes, in the log-det metric (which holds masses and tensors to it too), of tensors and
rotors, half of it of masses alone, and centres off by delta of 5 cm, whatever the link's thickness.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arms.papers.assembly import OWN_AXES, arm_from_paper
from lwr_dyn.arms.papers.schema import Paper, to_si
from lwr_dyn.dynamics.regressor import ROW_BY_ROW
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.bodies.link_spreads import Scales, covariances, link_spreads
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.inertial_parameters import inertial_parameters, pseudo_inertias

QUANTITIES = ("m", "cx", "cy", "cz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz", "rotor")
"""The cells of a link: mass, centre of mass, tensor row by row, rotor."""
MASS, COM, TENSOR, ROTOR = 0, slice(1, 4), slice(4, 10), 10
DIAGONAL, PRODUCTS = (4, 7, 9), (5, 6, 8)
COLUMNS = {"mass": slice(MASS, MASS + 1), "com": COM, "tensor": TENSOR, "rotor": slice(ROTOR, ROTOR + 1)}
_OTHER_SIGN = np.array([1.0, -1.0, -1.0, 1.0, -1.0, 1.0])
_SI_UNITS = ("kg", *["m"] * 3, *["kg m^2"] * 7)


class Cell(NamedTuple):
    """One cell: link from 0, index in `QUANTITIES`."""

    link: int
    quantity: int

    @property
    def column(self) -> str:
        """Its kind, one of `COLUMNS`."""
        return next(name for name, part in COLUMNS.items() if part.start <= self.quantity < part.stop)

    @property
    def name(self) -> str:
        """As the paper's errata name it.

        >>> Cell(4, 3).name, Cell(5, 4).name, Cell(0, 10).name
        ('c5z', 'I6xx', 'rotor1')
        """
        quantity = QUANTITIES[self.quantity]
        if self.quantity in (MASS, ROTOR):
            return f"{quantity}{self.link + 1}"
        return f"{quantity[0]}{self.link + 1}{quantity[1:]}"


@dataclass(frozen=True, slots=True, eq=False)
class PrintedCells:
    """The table of one arm; arrays have a row a link.

    Parameters
    ----------
    values : (n, 11) array
        Order of `QUANTITIES` [SI]; 0 where not `known`.
    known : (n, 11) bool array
        Whether the source prints the cell.
    open_parameters : (n, 11) bool array
        Which of the ten inertial parameters about the frame and the armature the source leaves open: a log is free in
        them.
    about_origin, integral : (n,) bool array
        Whether the tensor is about the frame's origin, and its products are +integrals.
    rotor_factor : (n,) array
        Armature of the joint per unit of the rotor's cell: the gear ratio squared, or 1.
    units : tuple of tuple of str
        (n, 11), as printed.
    """

    values: Array
    known: NDArray[np.bool_]
    open_parameters: NDArray[np.bool_]
    about_origin: NDArray[np.bool_]
    integral: NDArray[np.bool_]
    rotor_factor: Array
    units: tuple[tuple[str, ...], ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "rotor_factor")

    @property
    def n(self) -> int:
        """Number of links."""
        return len(self.values)

    @property
    def cells(self) -> tuple[Cell, ...]:
        """Those that the source prints, row by row."""
        return tuple(Cell(int(i), int(k)) for i, k in zip(*np.nonzero(self.known), strict=True))

    def value(self, cell: Cell) -> float:
        """In SI."""
        return float(self.values[cell])

    def shown(self, cell: Cell, value: float | None = None) -> str:
        """A value of a cell, its own if not given, in the printed unit."""
        unit = self.units[cell.link][cell.quantity]
        number = (self.value(cell) if value is None else value) / to_si(1.0, unit)
        return f"{number:.6g}" if unit == "1" else f"{number:.6g} {unit}"

    def typical_sizes(self, cells: Sequence[Cell]) -> Array:
        """Root mean square of the printed numbers of each cell's kind, (cells,) [SI]."""
        parts = {c.column: COLUMNS[c.column] for c in cells}
        known = {name: self.values[:, part][self.known[:, part]] for name, part in parts.items()}
        sizes = {name: float(np.sqrt(np.mean(np.square(x)))) or 1.0 for name, x in known.items()}
        return np.array([sizes[c.column] for c in cells])

    def with_values(self, values: Array) -> "PrintedCells":
        """The table with other cells (n, 11) [SI]."""
        return replace(self, values=values)

    def with_cell(self, cell: Cell, value: float) -> "PrintedCells":
        """The table with another value [SI] in one cell."""
        values = self.values.copy()
        values[cell] = value
        return self.with_values(values)

    def parameters(self) -> Array:
        """The ten inertial parameters of each link about its frame, then the armatures, (11 n,) [SI]."""
        return np.asarray(stacked_parameters((self,))[0])

    def derivatives(self, cells: Sequence[Cell]) -> Array:
        """d parameters / d cell, (11 n, cells): exact, as the parameters are at most quadratic in a cell."""
        sizes = np.array([max(abs(self.value(c)), 1e-3) for c in cells])
        steps = np.zeros((len(cells), *self.values.shape))
        for k, cell in enumerate(cells):
            steps[(k, *cell)] = sizes[k]
        of = (self.about_origin, self.integral, self.rotor_factor)
        up, down = (_parameters(self.values + sign * steps, *of) for sign in (1.0, -1.0))
        return np.asarray(((up - down) / (2.0 * sizes[:, None])).T)

    def changed_links(self, other: "PrintedCells") -> NDArray[np.intp]:
        """The links whose numbers, or their meaning, differ from those of another table of the arm."""
        same = (self.values == other.values).all(axis=1)
        same &= (self.about_origin == other.about_origin) & (self.integral == other.integral)
        return np.flatnonzero(~same)

    def pseudo_inertias(self) -> Array:
        """P (n, 4, 4) of each link about its frame [SI]."""
        return pseudo_inertias(self.parameters()[: 10 * self.n].reshape(self.n, 10))


def stacked_parameters(tables: Sequence[PrintedCells]) -> Array:
    """`PrintedCells.parameters` of tables of one arm, (tables, 11 n)."""
    values, origin, integral = (
        np.array([getattr(t, x) for t in tables]) for x in ("values", "about_origin", "integral")
    )
    return _parameters(values, origin, integral, tables[0].rotor_factor)


def _parameters(values: Array, about_origin: NDArray[np.bool_], integral: NDArray[np.bool_], factor: Array) -> Array:
    """(..., 11 n) of cells (..., n, 11)."""
    m, (x, y, z) = values[..., MASS], np.moveaxis(values[..., COM], -1, 0)
    mx, my, mz = m * x, m * y, m * z
    steiner = np.stack([my * y + mz * z, -mx * y, -mx * z, mx * x + mz * z, -my * z, mx * x + my * y], axis=-1)
    tensor = values[..., TENSOR] * np.where(integral[..., None], _OTHER_SIGN, 1.0)
    tensor += np.where(about_origin[..., None], 0.0, steiner)
    ten = np.concatenate([np.stack([m, mx, my, mz], axis=-1), tensor], axis=-1)
    return np.concatenate([ten.reshape(*values.shape[:-2], -1), factor * values[..., ROTOR]], axis=-1)


def printed_cells(source: Paper | Arm) -> PrintedCells:
    """The cells of a paper under its reading; of an arm without a paper: its bodies in their links' frames.

    Raises
    ------
    OptionError
        The source gives no inertia for some link.
    """
    arm = arm_from_paper(source) if isinstance(source, Paper) else source
    bodies = [link.body for link in arm.chain.links if link.body is not None]
    if len(bodies) < arm.n:
        raise OptionError("table", f"{arm.name} gives no mass, centre and tensor of every link", "an arm with masses")
    opened = np.zeros((arm.n, len(QUANTITIES)), dtype=bool)
    for i, link in enumerate(arm.chain.links):
        opened[i, list(bodies[i].unknown)] = True
        opened[i, ROTOR] = link.rotor is None
    if isinstance(source, Paper) and not any(name in source.columns for name in OWN_AXES):
        return _of_paper(source, opened)
    return _of_arm(arm, opened)


def _of_arm(arm: Arm, opened: NDArray[np.bool_]) -> PrintedCells:
    rows, factors = [], []
    for link in arm.chain.links:
        body, rotor = link.body, link.rotor
        assert body is not None
        rows.append([body.mass, *body.com, *_row_by_row(body.inertia_com), 0.0 if rotor is None else rotor.inertia])
        factors.append(1.0 if rotor is None else rotor.gear_ratio**2)
    values = np.array(rows)
    known = np.ones(values.shape, dtype=bool)
    known[:, ROTOR] = ~opened[:, ROTOR]
    for i in np.flatnonzero(opened[:, :ROTOR].any(axis=1)):
        known[i, :ROTOR] = False  # what a partly known body stands on is not said
    no = np.zeros(arm.n, dtype=bool)
    return PrintedCells(values, known, opened, no, no, np.array(factors), (_SI_UNITS,) * arm.n)


def _of_paper(paper: Paper, opened: NDArray[np.bool_]) -> PrintedCells:
    n = paper.n
    mass, com, inertia = (paper.columns[f"inertial.{name}"] for name in ("mass", "com", "inertia"))
    reflected = "rotors.armature" in paper.columns
    rotor = paper.columns.get("rotors.armature" if reflected else "rotors.inertia")
    ratio = paper.columns.get("rotors.gear_ratio")
    rotors = np.full(n, np.nan) if rotor is None or (ratio is None and not reflected) else rotor.si()
    factor = np.ones(n) if reflected or ratio is None else ratio.si() ** 2
    tensor = [_row_by_row(np.asarray(t)) for t in inertia.si()]
    values = np.column_stack([mass.si(), com.si(), np.array(tensor), rotors])
    known = ~np.isnan(values) & ~np.isnan(factor)[:, None]
    units = tuple(
        (mass.unit[i], *[com.unit[i]] * 3, *[inertia.unit[i]] * 6, "kg m^2" if rotor is None else rotor.unit[i])
        for i in range(n)
    )
    integral = np.array([p == "integral" for p in paper.inertia_products], dtype=bool)
    origin = np.full(n, paper.inertia_about == "origin")
    return PrintedCells(np.where(known, values, 0.0), known, opened, origin, integral, np.nan_to_num(factor), units)


def _row_by_row(tensor: Array) -> Sequence[float]:
    return [float(tensor[a, b]) for a, b in ROW_BY_ROW]


def link_discrepancies(table: PrintedCells, deviation: float, links: Sequence[int]) -> Array:
    """Covariance of the ten parameters and the armature of some links about the table's, (links, 11, 11) [SI].

    Where a table's body cannot be (a slip can do that), the magnitudes of its pseudo-inertia's eigenvalues are taken; a
    link without a mass has none.

    Parameters
    ----------
    deviation : float
        Share by which an arm may be off a right table of it.
    links : sequence of int
        From 0.
    """
    chosen = np.asarray(links, dtype=np.intp)
    P = table.pseudo_inertias()[chosen]
    values, vectors = np.linalg.eigh(P)
    if (values < 0.0).any():
        P = np.einsum("nij,nj,nkj->nik", vectors, np.abs(values), vectors)
    out = np.zeros((len(chosen), 11, 11))
    heavy = np.flatnonzero(P[:, 3, 3] > 0.0)
    scales = Scales.of_deviation(deviation)
    if heavy.size:
        out[heavy, :10, :10] = covariances(link_spreads(inertial_parameters(P[heavy])), scales)
    out[:, 10, 10] = (deviation * table.parameters()[10 * table.n + chosen]) ** 2
    return out


NOTHING = 1e-9
"""Share of the largest change of a base parameter below which there is none."""
ALONG = 1e-9
"""Two changes of the base parameters with 1 - |cosine| below this are one."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownCells:
    """The cells of a table by what the torques of any motion can tell of them."""

    hidden: tuple[Cell, ...]
    """Shown by no motion."""
    together: tuple[tuple[Cell, ...], ...]
    """Cells with one effect: a change of one is a change of another."""
    alone: tuple[Cell, ...]

    @property
    def visible(self) -> tuple[Cell, ...]:
        """Those that some motion shows, in the order of the table."""
        return tuple(sorted((*self.alone, *(c for group in self.together for c in group))))

    def like(self, cell: Cell) -> tuple[Cell, ...]:
        """The cells that cannot be distinguished from this one, itself among them."""
        return next((group for group in self.together if cell in group), (cell,))


def shown_cells(information: Information, table: PrintedCells) -> ShownCells:
    """The cells of a table, sorted by what the base parameters of the geometry see of them.

    Effects are per typical size of each cell, on base parameters in units of their own size.
    """
    grouping = information.base.grouping[:, information.columns.table_indices]
    effect = grouping @ (table.derivatives(table.cells) * table.typical_sizes(table.cells))
    scale = np.abs(effect).max(axis=1)
    effect = effect[scale > 0.0] / scale[scale > 0.0, None]
    lengths = np.linalg.norm(effect, axis=0)
    seen = lengths > NOTHING * lengths.max(initial=0.0)
    unit = effect[:, seen] / lengths[seen]
    alike = 1.0 - np.abs(unit.T @ unit) < ALONG
    cells, left = [c for c, s in zip(table.cells, seen, strict=True) if s], np.arange(np.count_nonzero(seen))
    groups: list[tuple[Cell, ...]] = []
    while left.size:
        with_first = alike[left[0], left]
        groups.append(tuple(cells[j] for j in left[with_first]))
        left = left[~with_first]
    return ShownCells(
        hidden=tuple(c for c, s in zip(table.cells, seen, strict=True) if not s),
        together=tuple(g for g in groups if len(g) > 1),
        alone=tuple(g[0] for g in groups if len(g) == 1),
    )
