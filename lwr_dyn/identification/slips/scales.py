"""A column of a whole table that is off by one common factor: an arm that is heavier than the one its table is of."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array
from lwr_dyn.identification.slips.printed_cells import COM, MASS, TENSOR, PrintedCells, stacked_parameters
from lwr_dyn.identification.slips.repairs import Repair

SCALE = "common factor"
"""The kind of these repairs: the factor is the log's."""
SCALES = {"all masses": (MASS,), "all centres of mass": (*range(11)[COM],), "all tensors": (*range(11)[TENSOR],),
          "all masses and tensors": (MASS, *range(11)[TENSOR])}  # fmt: skip
SPREAD = 0.3
"""Standard deviation of a common factor about 1, before the log is seen."""
_STEP = 1e-3


def scale_repair(table: PrintedCells, name: str, factor: float) -> Repair:
    """The cells of `SCALES[name]` of all links times a factor."""
    cells = tuple(c for c in table.cells if c.quantity in SCALES[name])
    again = partial(scale_repair, name=name, factor=factor)
    changed = table.with_values(np.where(scaled_cells(name, table), factor, 1.0) * table.values)
    return Repair(SCALE, cells, f"{name} times {factor:.4g}", changed, again)


def scale_of(repair: Repair) -> str:
    """The name in `SCALES` of such a repair."""
    return repair.text.rsplit(" times ", 1)[0]


def factor_of(name: str, table: PrintedCells, printed: PrintedCells) -> float:
    """The factor between two tables; cells that were repaired besides do not count."""
    cells = scaled_cells(name, printed) & (printed.values != 0.0)
    return float(np.median(table.values[cells] / printed.values[cells]))


def scale_slope(name: str, table: PrintedCells) -> Array:
    """d parameters / d factor at 1, (11 n,)."""
    cells = scaled_cells(name, table)
    tables = [table.with_values(np.where(cells, 1.0 + step, 1.0) * table.values) for step in (_STEP, -_STEP)]
    up, down = stacked_parameters(tables)
    return np.asarray((up - down) / (2.0 * _STEP))


def scaled_cells(name: str, table: PrintedCells) -> NDArray[np.bool_]:
    """(n, 11) which cells have the factor."""
    return table.known & np.isin(np.arange(11), SCALES[name])


def names_of(table: PrintedCells) -> Iterator[str]:
    """Factors that change something in a table."""
    return (name for name in SCALES if (table.values[scaled_cells(name, table)] != 0.0).any())
