"""One way to read the whole table, with every body that each of its links may then be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.audit.conventions.choices import LinkOptions, TableChoice, link_options
from lwr_dyn.audit.conventions.contributions import Rows, number_rows
from lwr_dyn.audit.conventions.evidence import Evidence, SecondTensors
from lwr_dyn.audit.conventions.frames import other_ends, reaches
from lwr_dyn.audit.conventions.mirror import alike_links
from lwr_dyn.audit.conventions.physics import shortfalls
from lwr_dyn.audit.conventions.printed import TENSOR, PrintedTable
from lwr_dyn.audit.conventions.search import DEVIATIONS
from lwr_dyn.checks.feasibility import THICKNESS
from lwr_dyn.model.dh import Convention

Allowed = tuple[tuple[int, ...], ...]
"""Per link the options that a criterion leaves."""


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """A table choice, the options of its links, and what single criteria leave of them."""

    choice: TableChoice
    options: tuple[LinkOptions, ...]
    feasible: Allowed
    """Options that are bodies of a size that the link can hold."""
    possible: Allowed
    """Options that are bodies, of whatever size."""
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
        return tuple(tuple(i for i in a if i in b) for a, b in zip(self.feasible, self.second, strict=True))


def table_choices(conventions: Sequence[Convention]) -> tuple[TableChoice, ...]:
    """Every choice for the whole table under some DH conventions, the plainest first."""
    return tuple(
        TableChoice(c, about, com_from)
        for com_from in ("own frame", "other end") for c in conventions for about in ("com", "origin")
    )  # fmt: skip


def worlds(table: PrintedTable, evidence: Evidence, conventions: Sequence[Convention]) -> tuple[World, ...]:
    """Every table choice under some DH conventions."""
    rows = {c: number_rows(table.chain(c), table, evidence.numbers) for c in conventions}
    return tuple(_world(table, evidence, choice, rows[choice.convention]) for choice in table_choices(conventions))


def changed_world(before: World, table: PrintedTable, evidence: Evidence, link: int) -> World:
    """A world after cells of one link have changed."""
    found = _link(table, evidence, before.choice, link)
    options = _put(before.options, link, found.options)
    return replace(
        before, options=options, feasible=_put(before.feasible, link, found.feasible),
        possible=_put(before.possible, link, found.possible), second=_put(before.second, link, found.second),
        alike=_alike(table, evidence, options),
    )  # fmt: skip


T = TypeVar("T")


def _put(values: tuple[T, ...], link: int, value: T) -> tuple[T, ...]:
    return (*values[:link], value, *values[link + 1 :])


@dataclass(frozen=True, slots=True, eq=False)
class _Link:
    """What a world knows of one link."""

    options: LinkOptions
    feasible: tuple[int, ...]
    possible: tuple[int, ...]
    second: tuple[int, ...]


def _world(table: PrintedTable, evidence: Evidence, choice: TableChoice, rows: Rows) -> World:
    links = [_link(table, evidence, choice, i) for i in range(table.n)]
    options = tuple(x.options for x in links)
    return World(
        choice=choice, options=options, feasible=tuple(x.feasible for x in links),
        possible=tuple(x.possible for x in links), second=tuple(x.second for x in links),
        alike=_alike(table, evidence, options), rows=rows,
    )  # fmt: skip


def _link(table: PrintedTable, evidence: Evidence, choice: TableChoice, link: int) -> _Link:
    found = link_options(table, link, choice, other_ends(table, choice.convention)[link])
    short = shortfalls(found, reaches(table.chain(choice.convention), link, found.com, THICKNESS)) <= 0.0
    return _Link(
        options=found, feasible=_indices(short.all(axis=-1)), possible=_indices(short[:, :2].all(axis=-1)),
        second=_matching(table, found, evidence.tensors, link),
    )  # fmt: skip


def _indices(mask: ArrayLike) -> tuple[int, ...]:
    return tuple(int(k) for k in np.flatnonzero(np.asarray(mask)))


def _alike(table: PrintedTable, evidence: Evidence, options: Sequence[LinkOptions]) -> tuple[tuple[int, ...], ...]:
    return evidence.alike or alike_links(table, np.array([o.com[0] for o in options]))


def _matching(table: PrintedTable, options: LinkOptions, tensors: SecondTensors | None, link: int) -> tuple[int, ...]:
    """Options whose tensor about the other point is the second one printed, to the digits of both."""
    everything = tuple(range(len(options.choices)))
    if tensors is None:
        return everything
    about = np.stack([options.inertia_com[:, r, c] for r, c in TENSOR], axis=-1)
    ours, spread = about, options.deviation_com
    if tensors.about == "origin":
        ours, spread = options.parameters[:, 4:], float(options.deviation[-1])
    room = tensors.half[link] * (1.0 + 1e-6) + DEVIATIONS * spread + table.inertia_step / 2
    found = set()
    for products in tensors.products:
        sign = np.array([1.0] * 3 + [-1.0 if products == "integral" else 1.0] * 3)
        miss = np.abs(ours - sign * tensors.values[link]) / room
        found |= {i for i in everything if np.nanmax(miss[i], initial=0.0) <= 1.0}
    return tuple(sorted(found))
