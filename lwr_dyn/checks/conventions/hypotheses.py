"""Hypotheses about a whole table: one choice of conventions, with every body that each link can then be.

A printed column of vectors between neighbouring frames shows shifted rows and the DH convention, since neither depends
on q of a turning joint:

    standard  r_{i-1,i} in frame i    = (a_i,  d_i sin alpha_i, d_i cos alpha_i)
    modified  r_{i-1,i} in frame i-1  = (a_i, -d_i sin alpha_i, d_i cos alpha_i)

Repeated links are bodies of equal mass whose centres of mass are mirror images. A signed permutation P of the axes that
maps one centre to the other, P c_i = c_j, must map the tensors too, P I_i P^T = I_j. That ties together the signs of
the products of both links, their axes, and the point the tensors are about: moved by the wrong m c^2, bodies whose
centres differ a little no longer agree.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.checks.arm.model_laws import THICKNESS
from lwr_dyn.checks.conventions.evidence import Evidence, SecondTensors
from lwr_dyn.checks.conventions.printed_table import (
    TENSOR,
    CellChange,
    LinkOptions,
    PrintedTable,
    TableChoice,
    link_options,
)
from lwr_dyn.checks.conventions.search import DEVIATIONS, NumberRows, OptionSets, number_rows
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Chain, Convention, link_frames
from lwr_dyn.model.spatial import cos_sin, principal_moments

SHIFTS = (0, 1, -1, 2, -2)
"""Rows by which a column may belong lower than printed, the plainest first."""
HALF_UNIT_SLACK = 4.0
"""Half units by which a printed place may be missed: rounded lengths of a table add up."""


@dataclass(frozen=True, slots=True)
class FramesFinding:
    """Misses of one DH convention and row shift against what is printed of the frames."""

    convention: Convention
    shift: int
    rows_missed: int
    """Rows of the vector column that differ from the DH table's."""
    miss: float
    """Largest difference of any of them [m]."""
    place_miss: float
    """Largest distance between a printed place of the flange and the one computed [m]."""
    places_missed: int

    @property
    def missed(self) -> int:
        """What is printed of the frames and contradicts it: rows and places."""
        return self.rows_missed + self.places_missed


def frame_vectors(table: PrintedTable, convention: Convention) -> Array:
    """r_{i-1,i} of every row, (n, 3) [m]: standard in frame i, modified in frame i-1."""
    turn = 1.0 if convention is Convention.STANDARD else -1.0
    out = []
    for row in table.rows:
        c, s = cos_sin(row.alpha)
        out.append((row.a, turn * row.d * s, row.d * c))
    return np.array(out)


def other_ends(table: PrintedTable, convention: Convention) -> Array:
    """Where the other end of each link lies in its own frame, (n, 3) [m].

    Standard DH puts frame i at the far end of link i: the other end is the origin of frame i-1. Modified DH puts it
    at the near end: the other is the origin of frame i+1, for the last link the flange.
    """
    vectors = frame_vectors(table, convention)
    if convention is Convention.STANDARD:
        return -vectors
    return np.vstack([vectors[1:], table.flange.position])


def reaches(chain: Chain, link: int, com: Array) -> Array:
    """How far the mass of a link can lie from each of its possible coms (O, 3), (O,) [m].

    The farther of the link's two joints, and `THICKNESS` times the reach of the whole arm beyond it.
    """
    links = chain.links
    start = links[link].after.inverse().position
    end = links[link + 1].before.position if link + 1 < chain.n else chain.flange.position
    poses = [pose for x in links for pose in (x.before, x.after)]
    total = sum(float(np.linalg.norm(pose.position)) for pose in (*poses, chain.flange))
    spans = [np.linalg.norm(com - end_point, axis=-1) for end_point in (start, end)]
    reach: Array = np.maximum(*spans) + THICKNESS * total
    return reach


def frames_findings(table: PrintedTable, evidence: Evidence) -> tuple[FramesFinding, ...]:
    """Every pair of convention and row shift with its misses, the best first."""
    conventions = [c for c in Convention if evidence.convention in (None, c.value)]
    shifts = SHIFTS if table.origin is not None else (0,)
    findings = [_finding(table, evidence, c, s) for c in conventions for s in shifts]
    return tuple(sorted(findings, key=lambda f: (f.missed, abs(f.shift), f.miss)))


def _finding(table: PrintedTable, evidence: Evidence, convention: Convention, shift: int) -> FramesFinding:
    missed, miss = 0, 0.0
    if table.origin is not None:
        wanted = frame_vectors(table, convention)
        printed = shifted(table.origin, shift)
        gap = np.abs(printed - wanted).max(axis=-1)
        gap = gap[np.isfinite(gap)]
        missed, miss = int((gap > table.com_step).sum()), float(gap.max(initial=0.0))
    chain, far, places = table.chain(convention), 0.0, 0
    for place in evidence.places:
        *_, flange = link_frames(chain, np.asarray(place.q))
        distance = float(np.abs(flange[:3, 3] - place.xyz).max())
        far, places = max(far, distance), places + (distance > HALF_UNIT_SLACK * place.half)
    return FramesFinding(convention, shift, missed, miss, far, places)


def shifted(column: Array, shift: int) -> Array:
    """A column moved `shift` rows down, NaN in the rows left empty.

    >>> shifted(np.array([[1.0], [2.0], [3.0]]), 1)[:, 0]
    array([nan,  1.,  2.])
    """
    rows = np.arange(len(column)) - shift
    inside = (rows >= 0) & (rows < len(column))
    return np.where(inside[:, None], column[np.where(inside, rows, 0)], np.nan)


def with_rows_moved(table: PrintedTable, shift: int) -> PrintedTable:
    """The table with its vector column moved; rows that fall out of it fill blank centres of mass beside it."""
    if table.origin is None or shift == 0:
        return table
    spilled = table.origin[-shift:] if shift > 0 else table.origin[:-shift]
    blank = np.flatnonzero(np.isnan(table.com).any(axis=-1))
    com = table.com.copy()
    for row, value in zip(blank, spilled[: len(blank)], strict=False):
        com[row] = value
    return replace(table, origin=shifted(table.origin, shift), com=com)


FORGIVEN_MISS = 4.0
"""Standard deviations of the rounding of cells that explain a miss."""
MIRROR = 0.03
"""Share of its length by which the com of a repeated link may miss the mirror image of the other's."""

_PERMUTATIONS = np.array(
    [np.eye(3)[list(p)] * np.array(s)[:, None] for p in itertools.permutations(range(3))
     for s in itertools.product((1.0, -1.0), repeat=3)]
)  # fmt: skip
"""All 48 signed permutations."""


def alike_links(table: PrintedTable, com: Array) -> tuple[tuple[int, ...], ...]:
    """Groups of links of equal mass whose coms (n, 3) are one another's mirror images, two or more each."""
    groups: list[list[int]] = []
    for i in range(table.n):
        for group in groups:
            j = group[0]
            length = float(np.linalg.norm(com[j]))
            gap = np.abs(np.sort(np.abs(com[i])) - np.sort(np.abs(com[j]))).max()
            equal = abs(table.mass[i] - table.mass[j]) <= table.mass_step / 2
            if equal and length > 0.0 and gap <= MIRROR * length:
                group.append(i)
                break
        else:
            groups.append([i])
    return tuple(tuple(g) for g in groups if len(g) > 1)


def mirror_misses(a: LinkOptions, b: LinkOptions, of_a: Sequence[int], of_b: Sequence[int]) -> Array:
    """Smallest miss of P I_a P^T = I_b over all P that take com to com, (A, B), in units of the printed tensor.

    The whole tensor counts, about the centre of mass; infinite where no P fits the coms.
    """
    com_a, com_b = a.com[list(of_a)], b.com[list(of_b)]
    turned = np.einsum("pij,aj->pai", _PERMUTATIONS, com_a)
    gap = np.abs(turned[:, :, None, :] - com_b).max(axis=-1)
    allowed = gap <= MIRROR * np.linalg.norm(com_b, axis=-1) + 1e-12
    tensors = np.einsum("pij,ajk,plk->pail", _PERMUTATIONS, a.inertia_com[list(of_a)], _PERMUTATIONS)
    miss = np.abs(tensors[:, :, None] - b.inertia_com[list(of_b)]).max(axis=(-1, -2))
    least: Array = np.where(allowed, miss, np.inf).min(axis=0) / max(a.scale, b.scale)
    return least


def rounding_miss(table: PrintedTable, links: Sequence[LinkOptions], group: Sequence[int]) -> float:
    """The largest miss that rounding of the printed cells explains, in units of the printed tensor."""
    largest = max(links[i].scale for i in group)
    spread = max(links[i].deviation_com for i in group)
    return (table.inertia_step + FORGIVEN_MISS * spread) / largest


FORGIVEN = 4.0
"""Standard deviations of rounding by which a moment may miss its bound."""


@dataclass(frozen=True, slots=True, eq=False)
class TableHypothesis:
    """A table under one choice of conventions; sets of options are tuples with one entry per link."""

    table: PrintedTable
    choice: TableChoice
    options: tuple[LinkOptions, ...]
    feasible: OptionSets
    """Options that are bodies of a size that their links can hold."""
    possible: OptionSets
    """Options that are bodies of any size."""
    second: OptionSets
    """Options that give the second tensors; all where none are published."""
    alike: tuple[tuple[int, ...], ...]
    """Groups of repeated links."""
    rows: NumberRows
    shift: int = 0
    """Rows by which the column of vectors between frames was moved down."""
    cells: tuple[CellChange, ...] = ()
    """Cells that were changed before the table was read."""

    @property
    def everything(self) -> OptionSets:
        """Every option."""
        return tuple(tuple(range(len(options.choices))) for options in self.options)

    @property
    def sound(self) -> OptionSets:
        """The options that feasibility and the second tensors both leave."""
        pairs = zip(self.feasible, self.second, strict=True)
        return tuple(tuple(i for i in feasible if i in second) for feasible, second in pairs)

    def of_any_size(self) -> TableHypothesis:
        """The same with bodies of any size counted as feasible."""
        return replace(self, feasible=self.possible)

    def with_cell(self, cell: CellChange, evidence: Evidence) -> TableHypothesis:
        """The same of a table with one cell changed."""
        table = self.table.with_cell(cell.column, cell.link, cell.entry, cell.value)
        links = list(zip(self.options, self.feasible, self.possible, self.second, strict=True))
        links[cell.link] = _link(table, evidence, self.choice, cell.link)
        return _of_links(table, evidence, self.choice, links, self.rows, self.shift, (*self.cells, cell))


def table_hypotheses(
    table: PrintedTable, evidence: Evidence, conventions: Sequence[Convention], shift: int = 0
) -> tuple[TableHypothesis, ...]:
    """Every choice of conventions for a table under some DH conventions, the plainest first."""
    rows = {c: number_rows(table.chain(c), table, evidence.numbers) for c in conventions}
    choices = [
        TableChoice(c, about, com_from)
        for com_from in ("own frame", "other end") for c in conventions for about in ("com", "origin")
    ]  # fmt: skip
    out = []
    for choice in choices:
        links = [_link(table, evidence, choice, i) for i in range(table.n)]
        out.append(_of_links(table, evidence, choice, links, rows[choice.convention], shift))
    return tuple(out)


_Link = tuple[LinkOptions, tuple[int, ...], tuple[int, ...], tuple[int, ...]]
"""The options of one link, and those that are feasible, possible, and give the second tensor."""


def _link(table: PrintedTable, evidence: Evidence, choice: TableChoice, link: int) -> _Link:
    options = link_options(table, link, choice, other_ends(table, choice.convention)[link])
    within = shortfalls(options, reaches(table.chain(choice.convention), link, options.com)) <= 0.0
    feasible, possible = (tuple(np.flatnonzero(x.all(axis=-1)).tolist()) for x in (within, within[:, :2]))
    return options, feasible, possible, _matching(table, options, evidence.tensors, link)


def _of_links(
    table: PrintedTable, evidence: Evidence, choice: TableChoice, links: Sequence[_Link], rows: NumberRows,
    shift: int, cells: tuple[CellChange, ...] = (),
) -> TableHypothesis:  # fmt: skip
    options, feasible, possible, second = zip(*links, strict=True)
    alike = evidence.alike or alike_links(table, np.array([o.com[0] for o in options]))
    return TableHypothesis(table, choice, options, feasible, possible, second, alike, rows, shift, cells)


def _matching(table: PrintedTable, options: LinkOptions, tensors: SecondTensors | None, link: int) -> tuple[int, ...]:
    """Options whose tensor about the other point is the second one printed, to the digits of both."""
    if tensors is None:
        return tuple(range(len(options.choices)))
    about_com = np.stack([options.inertia_com[:, r, c] for r, c in TENSOR], axis=-1)
    ours, deviation = about_com, options.deviation_com
    if tensors.about == "origin":
        ours, deviation = options.parameters[:, 4:], float(options.deviation[-1])
    allowed = tensors.half[link] * (1.0 + 1e-6) + DEVIATIONS * deviation + table.inertia_step / 2
    signs = np.array([[1.0] * 3 + [-1.0 if products == "integral" else 1.0] * 3 for products in tensors.products])
    misses = np.abs(ours - (signs * tensors.values[link])[:, None]) / allowed
    matching = (np.nanmax(misses, axis=-1, initial=0.0) <= 1.0).any(axis=0)
    return tuple(np.flatnonzero(matching).tolist())


def shortfalls(options: LinkOptions, reach: Array) -> Array:
    """How far each option is from a body, (O, 3); none is above 0 for one that can exist.

    Smallest principal moment below 0, I3 - I1 - I2, and m (k^2 - reach^2) for the largest radius of gyration k; all in
    units of the largest printed entry, less the effect of rounding. `lwr_dyn.model.chain` checks one arm.
    """
    moments = principal_moments(options.inertia_com)
    slack = FORGIVEN * options.deviation_com
    low = -moments[:, 0] - slack
    triangle = moments[:, 2] - moments[:, 0] - moments[:, 1] - 2 * slack
    gyration = moments[:, 2] - options.mass * reach**2 - slack
    excess: Array = np.stack([low, triangle, gyration], axis=-1) / max(options.scale, 1e-300)
    return excess
