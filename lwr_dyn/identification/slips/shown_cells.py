"""Which cells of a table a motion can show: none at all, only with others, or alone. Geometry decides, not the log."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.slips.hypotheses import typical_size
from lwr_dyn.identification.slips.printed_cells import Cell, PrintedCells

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
    """The cells of a table, sorted by what the base parameters of the geometry see of them."""
    columns, n = information.columns, table.n
    own = np.concatenate([np.arange(10 * n), np.asarray(columns.rotor_indices, dtype=np.intp)])
    effect = _in_sizes(information.base.grouping[:, own], table)
    lengths = np.linalg.norm(effect, axis=0)
    seen = lengths > NOTHING * lengths.max(initial=0.0)
    unit = effect[:, seen] / lengths[seen]
    cosine = np.abs(unit.T @ unit)
    cells = [c for c, s in zip(table.cells, seen, strict=True) if s]
    groups: list[tuple[Cell, ...]] = []
    left = list(range(len(cells)))
    while left:
        group = [j for j in left if 1.0 - cosine[left[0], j] < ALONG]
        groups.append(tuple(cells[j] for j in group))
        left = [j for j in left if j not in group]
    return ShownCells(
        hidden=tuple(c for c, s in zip(table.cells, seen, strict=True) if not s),
        together=tuple(g for g in groups if len(g) > 1),
        alone=tuple(g[0] for g in groups if len(g) == 1),
    )


def _in_sizes(grouping: Array, table: PrintedCells) -> Array:
    """Change of the base parameters per typical size of each cell, the parameters in units of their own size."""
    changes = table.derivatives(table.cells) * np.array([typical_size(table, c) for c in table.cells])
    effect = grouping @ changes
    scale = np.abs(effect).max(axis=1)
    return np.asarray(effect[scale > 0.0] / scale[scale > 0.0, None])
