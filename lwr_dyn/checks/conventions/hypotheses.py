"""Hypotheses about a whole table: one choice of conventions, with every body that each link can then be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.checks.arm.feasibility import THICKNESS
from lwr_dyn.checks.conventions.choices import CellChange, LinkOptions, TableChoice, link_options
from lwr_dyn.checks.conventions.contributions import NumberRows, number_rows
from lwr_dyn.checks.conventions.evidence import Evidence, SecondTensors
from lwr_dyn.checks.conventions.frames import other_ends, reaches
from lwr_dyn.checks.conventions.mirror import alike_links
from lwr_dyn.checks.conventions.printed_table import TENSOR, PrintedTable
from lwr_dyn.checks.conventions.search import DEVIATIONS, OptionSets
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.dh import Convention
from lwr_dyn.model.spatial import principal_moments

FORGIVEN = 4.0
"""Standard deviations of rounding by which a moment may miss its bound."""


@dataclass(frozen=True, slots=True, eq=False)
class LinkHypothesis:
    """The options of one link, and the indices of those that each criterion leaves."""

    options: LinkOptions
    feasible: tuple[int, ...]
    """Bodies of a size that the link can hold."""
    possible: tuple[int, ...]
    """Bodies of any size."""
    second: tuple[int, ...]
    """Those that give the second tensors; all where none are published."""


@dataclass(frozen=True, slots=True, eq=False)
class TableHypothesis:
    """A table under one choice of conventions; sets of options are tuples with one entry per link."""

    table: PrintedTable
    choice: TableChoice
    links: tuple[LinkHypothesis, ...]
    alike: tuple[tuple[int, ...], ...]
    """Groups of repeated links."""
    rows: NumberRows
    shift: int = 0
    """Rows by which the column of vectors between frames was moved down."""
    cells: tuple[CellChange, ...] = ()
    """Cells that were changed before the table was read."""

    @property
    def options(self) -> tuple[LinkOptions, ...]:
        """The options of the links."""
        return tuple(link.options for link in self.links)

    @property
    def feasible(self) -> OptionSets:
        """The options that are bodies of a size that their links can hold."""
        return tuple(link.feasible for link in self.links)

    @property
    def second(self) -> OptionSets:
        """The options that give the second tensors."""
        return tuple(link.second for link in self.links)

    @property
    def everything(self) -> OptionSets:
        """Every option."""
        return tuple(tuple(range(len(link.options.choices))) for link in self.links)

    @property
    def sound(self) -> OptionSets:
        """The options that feasibility and the second tensors both leave."""
        return tuple(tuple(i for i in link.feasible if i in link.second) for link in self.links)

    def of_any_size(self) -> TableHypothesis:
        """The same with bodies of any size counted as feasible."""
        return replace(self, links=tuple(replace(link, feasible=link.possible) for link in self.links))

    def with_cell(self, cell: CellChange, evidence: Evidence) -> TableHypothesis:
        """The same of a table with one cell changed."""
        table = self.table.with_cell(cell.column, cell.link, cell.entry, cell.value)
        changed = _link_hypothesis(table, evidence, self.choice, cell.link)
        links = (*self.links[: cell.link], changed, *self.links[cell.link + 1 :])
        alike = _alike(table, evidence, links)
        return replace(self, table=table, links=links, alike=alike, cells=(*self.cells, cell))


def table_hypotheses(
    table: PrintedTable, evidence: Evidence, conventions: Sequence[Convention], shift: int = 0
) -> tuple[TableHypothesis, ...]:
    """Every choice of conventions for a table under some DH conventions, the plainest first."""
    rows = {c: number_rows(table.chain(c), table, evidence.numbers) for c in conventions}
    choices = [
        TableChoice(c, about, com_from)
        for com_from in ("own frame", "other end") for c in conventions for about in ("com", "origin")
    ]  # fmt: skip
    return tuple(_table_hypothesis(table, evidence, choice, rows[choice.convention], shift) for choice in choices)


def _table_hypothesis(
    table: PrintedTable, evidence: Evidence, choice: TableChoice, rows: NumberRows, shift: int
) -> TableHypothesis:
    links = tuple(_link_hypothesis(table, evidence, choice, i) for i in range(table.n))
    return TableHypothesis(table, choice, links, _alike(table, evidence, links), rows, shift)


def _link_hypothesis(table: PrintedTable, evidence: Evidence, choice: TableChoice, link: int) -> LinkHypothesis:
    options = link_options(table, link, choice, other_ends(table, choice.convention)[link])
    within = shortfalls(options, reaches(table.chain(choice.convention), link, options.com, THICKNESS)) <= 0.0
    return LinkHypothesis(
        options=options, feasible=_indices(within.all(axis=-1)), possible=_indices(within[:, :2].all(axis=-1)),
        second=_matching(table, options, evidence.tensors, link),
    )  # fmt: skip


def _indices(mask: ArrayLike) -> tuple[int, ...]:
    return tuple(int(k) for k in np.flatnonzero(np.asarray(mask)))


def _alike(table: PrintedTable, evidence: Evidence, links: Sequence[LinkHypothesis]) -> tuple[tuple[int, ...], ...]:
    return evidence.alike or alike_links(table, np.array([link.options.com[0] for link in links]))


def _matching(table: PrintedTable, options: LinkOptions, tensors: SecondTensors | None, link: int) -> tuple[int, ...]:
    """Options whose tensor about the other point is the second one printed, to the digits of both."""
    everything = tuple(range(len(options.choices)))
    if tensors is None:
        return everything
    about_com = np.stack([options.inertia_com[:, r, c] for r, c in TENSOR], axis=-1)
    ours, deviation = about_com, options.deviation_com
    if tensors.about == "origin":
        ours, deviation = options.parameters[:, 4:], float(options.deviation[-1])
    allowed = tensors.half[link] * (1.0 + 1e-6) + DEVIATIONS * deviation + table.inertia_step / 2
    matching = set()
    for products in tensors.products:
        sign = np.array([1.0] * 3 + [-1.0 if products == "integral" else 1.0] * 3)
        miss = np.abs(ours - sign * tensors.values[link]) / allowed
        matching |= {i for i in everything if np.nanmax(miss[i], initial=0.0) <= 1.0}
    return tuple(sorted(matching))


def shortfalls(options: LinkOptions, reach: Array) -> Array:
    """How far each option is from a body, (O, 3); none is above 0 for one that can exist.

    Smallest principal moment below 0, I3 - I1 - I2, and m (k^2 - reach^2) for the largest radius of gyration k; all in
    units of the largest printed entry, less the effect of rounding. `lwr_dyn.model.feasibility` checks one arm.
    """
    moments = principal_moments(options.inertia_com)
    slack = FORGIVEN * options.deviation_com
    low = -moments[:, 0] - slack
    triangle = moments[:, 2] - moments[:, 0] - moments[:, 1] - 2 * slack
    gyration = moments[:, 2] - options.mass * reach**2 - slack
    excess: Array = np.stack([low, triangle, gyration], axis=-1) / max(options.scale, 1e-300)
    return excess
