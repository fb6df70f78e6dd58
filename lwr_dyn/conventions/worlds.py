"""One way to read the whole table, with every body that each of its links may then be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.feasibility import THICKNESS
from lwr_dyn.conventions.choices import LinkOptions, TableChoice, link_options
from lwr_dyn.conventions.contributions import Rows, number_rows
from lwr_dyn.conventions.evidence import Evidence, SecondTensors
from lwr_dyn.conventions.frames import other_ends, reaches
from lwr_dyn.conventions.mirror import alike_links
from lwr_dyn.conventions.physics import shortfalls
from lwr_dyn.conventions.printed import TENSOR, PrintedTable
from lwr_dyn.conventions.search import DEVIATIONS
from lwr_dyn.dh import Convention

Allowed = tuple[tuple[int, ...], ...]
"""Per link the options that a criterion leaves."""


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """A table choice, the options of its links, and what single criteria leave of them."""

    choice: TableChoice
    options: tuple[LinkOptions, ...]
    feasible: Allowed
    second: Allowed
    """What the second set of tensors leaves; every option where there is none."""
    alike: tuple[tuple[int, ...], ...]
    rows: Rows

    @property
    def everything(self) -> Allowed:
        """Every option."""
        return tuple(tuple(range(len(o.choices))) for o in self.options)

    @property
    def sound(self) -> Allowed:
        """What feasibility and the second tensors both leave."""
        return tuple(
            tuple(i for i in a if i in b) for a, b in zip(self.feasible, self.second, strict=True)
        )


def table_choices(conventions: Sequence[Convention]) -> tuple[TableChoice, ...]:
    """Every choice for the whole table under some DH conventions, the plainest first."""
    return tuple(
        TableChoice(c, about, com_from)
        for com_from in ("own frame", "other end") for c in conventions for about in ("com", "origin")
    )  # fmt: skip


def world(table: PrintedTable, evidence: Evidence, choice: TableChoice) -> World:
    """All that can be said of one table choice before links are combined."""
    chain, ends = table.chain(choice.convention), other_ends(table, choice.convention)
    options = tuple(link_options(table, i, choice, ends[i]) for i in range(table.n))
    feasible = []
    for i, found in enumerate(options):
        reach = reaches(chain, np.broadcast_to(found.com, (table.n, *found.com.shape)), THICKNESS)[i]
        feasible.append(tuple(int(k) for k in np.flatnonzero((shortfalls(found, reach) <= 0.0).all(axis=-1))))
    plain = np.array([o.com[0] for o in options])
    return World(
        choice=choice, options=options, feasible=tuple(feasible),
        second=tuple(_matching(table, o, evidence.tensors, i) for i, o in enumerate(options)),
        alike=evidence.alike or alike_links(table, plain), rows=number_rows(chain, table, evidence.numbers),
    )  # fmt: skip


def _matching(table: PrintedTable, options: LinkOptions, tensors: SecondTensors | None, link: int) -> tuple[int, ...]:
    """Options whose tensor about the other point is the second one printed, to the digits of both."""
    everything = tuple(range(len(options.choices)))
    if tensors is None:
        return everything
    about = np.stack([options.inertia_com[:, r, c] for r, c in TENSOR], axis=-1)
    ours, spread = (
        (options.parameters[:, 4:], options.deviation[-1]) if tensors.about == "origin" else (about, options.deviation_com)
    )
    room = tensors.half[link] * (1.0 + 1e-6) + DEVIATIONS * spread + table.inertia_step / 2
    found = set()
    for products in tensors.products:
        sign = np.array([1.0] * 3 + [-1.0 if products == "integral" else 1.0] * 3)
        miss = np.abs(ours - sign * tensors.values[link]) / room
        found |= {i for i in everything if np.nanmax(miss[i], initial=0.0) <= 1.0}
    return tuple(sorted(found))
