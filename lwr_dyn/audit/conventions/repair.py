"""When no reading gives the published numbers: which single cell must be another number, and which?

The cell is fitted to the first number that fails, from the flange inward, and to nothing else; the numbers of the
joints before it then follow or do not, which is the proof.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.audit.conventions.candidates import fewest_exceptions
from lwr_dyn.audit.conventions.choices import CHOICES, CellChange, LinkChoice, link_options
from lwr_dyn.audit.conventions.evidence import Evidence
from lwr_dyn.audit.conventions.frames import other_ends
from lwr_dyn.audit.conventions.printed import TENSOR, PrintedTable
from lwr_dyn.audit.conventions.search import Fits, allowances, fit_numbers
from lwr_dyn.audit.conventions.worlds import World, changed_world

GRID = 401
"""Points at which the failing number is computed over a cell's range; its roots are then sharpened."""
MOST_PARTIAL = 8
"""Ways to read the links beyond the failing joint that are tried."""
MOST_BEYOND = 3
"""Options of a link beyond the failing one that are tried, of those that no number tells apart."""


@dataclass(frozen=True, slots=True)
class Repair:
    """A cell, the value fitted to one number, and how far the others followed."""

    cell: CellChange
    fitted_to: str
    low: float
    high: float
    """Range of the value that gives that number to its printed digits."""
    followed: int
    """Numbers of joints nearer the base that then come out, of `others`."""
    others: int
    repeats: str
    """A neighbouring cell of the same column that the printed one repeats, or nothing."""
    feasible: bool
    """Every link can be a body with it."""
    exceptions: int
    """Links that are then read otherwise than the rest, in the plainest reading that fits."""


def repairs(
    table: PrintedTable, evidence: Evidence, worlds: Sequence[World], fits: Sequence[Fits]
) -> tuple[Repair, ...]:
    """Single cells that let some reading give every number, the likeliest first.

    Those that need the fewest exceptions come first, then those whose printed value repeats a neighbour, then those
    that leave every link a body, then the sign that is printed, then the smallest change.
    """
    deepest = max(f.matched for f in fits)
    found: dict[tuple[str, float], Repair] = {}
    for w, fit in zip(worlds, fits, strict=True):
        if fit.matched < deepest or fit.boxes:
            continue
        for cell, low, high in _roots(table, w, fit):
            key = (cell.name, round(cell.value, 7))
            if key not in found:
                repair = _tried(table, evidence, w, fit, cell, low, high)
                if repair is not None:
                    found[key] = repair
    return tuple(sorted(found.values(), key=_likelihood))


def _likelihood(r: Repair) -> tuple[int, bool, bool, bool, float]:
    printed = r.cell.printed
    change = abs(r.cell.value - printed) / max(abs(printed), abs(r.cell.value))
    return (r.exceptions, not r.repeats, not r.feasible, r.cell.value * printed < 0.0, change)


def _tried(
    table: PrintedTable, evidence: Evidence, w: World, fit: Fits, cell: CellChange, low: float, high: float
) -> Repair | None:
    changed = changed_world(w, table.with_cell(cell.column, cell.link, cell.entry, cell.value), evidence, cell.link)
    again = fit_numbers(changed.rows, changed.options, changed.everything)
    if not again.boxes:
        return None
    name = sorted(evidence.numbers, key=lambda x: -x.joint)[fit.failed[0]].name
    sound = any(all(set(b) & set(f) for b, f in zip(box, changed.feasible, strict=True)) for box in again.boxes)
    return Repair(
        cell, name, low, high, len(evidence.numbers) - fit.matched - len(fit.failed),
        len(evidence.numbers) - fit.matched - len(fit.failed), repeated_neighbour(table, cell), sound,
        min(fewest_exceptions(changed, box) for box in again.boxes),
    )  # fmt: skip


def repeated_neighbour(table: PrintedTable, cell: CellChange) -> str:
    """A cell of a neighbouring row that prints the same digits in the same place, but for the last; or nothing."""
    if cell.column == "mass" or cell.printed == 0.0:
        return ""
    values = {"com": table.com, "inertia": np.stack([table.inertia[:, r, c] for r, c in TENSOR], axis=-1)}[cell.column]
    step = table.com_step if cell.column == "com" else table.inertia_step
    for j in (cell.link + 1, cell.link - 1):
        if 0 <= j < table.n and abs(values[j, cell.entry] - cell.printed) <= 10 * step:
            return CellChange(cell.column, j, cell.entry, 0.0, 0.0).name
    return ""


def _roots(table: PrintedTable, w: World, fit: Fits) -> Iterator[tuple[CellChange, float, float]]:
    """Every cell of the failing link and those beyond it, with the values that give the failing number."""
    number = fit.failed[0]
    joint = w.rows.joint[number]
    room = float(allowances(w.rows, w.options)[number])
    rows = w.rows.coefficients[w.rows.start[number] : w.rows.start[number + 1]]
    wanted = float(w.rows.value[number])
    here = w.options[joint].parameters
    adds = rows[:, joint] @ here.T
    _, distinct = np.unique(np.round(adds / room, 3), axis=1, return_index=True)
    for box in fit.partial[:MOST_PARTIAL]:
        beyond = np.array([w.options[joint + 1 + k].parameters[o[0]] for k, o in enumerate(box)]).reshape(-1, 10)
        terms = np.einsum("rlp,lp->rl", rows[:, joint + 1 :], beyond)
        for cell in _cells(joint):
            for choice in CHOICES:
                yield from _cell_roots(table, w, rows[:, joint], terms.sum(axis=1), wanted, room, cell, choice)
        for k, options in enumerate(box):
            rest = np.delete(terms, k, axis=1).sum(axis=1)
            choices = [w.options[joint + 1 + k].choices[o][0] for o in options[:MOST_BEYOND]]
            for o, choice, cell in itertools.product(distinct, choices, _cells(joint + 1 + k)):
                fixed = rest + adds[:, o]
                yield from _cell_roots(table, w, rows[:, joint + 1 + k], fixed, wanted, room, cell, choice)


def _cells(link: int) -> list[tuple[str, int, int]]:
    """Column, link and entry of every cell of a link."""
    return [*(("com", link, k) for k in range(3)), *(("inertia", link, k) for k in range(6)), ("mass", link, 0)]


def _cell_roots(
    table: PrintedTable, w: World, rows: Array, fixed: Array, wanted: float, room: float,
    cell: tuple[str, int, int], choice: LinkChoice,
) -> Iterator[tuple[CellChange, float, float]]:  # fmt: skip
    column, link, entry = cell
    low, high = _range(table, column, link, entry)
    nodes = np.array([low, (low + high) / 2, high])
    ends = other_ends(table, w.choice.convention)[link]
    samples = np.array(
        [link_options(table.with_cell(column, link, entry, x), link, w.choice, ends, (choice,)).parameters[0]
         for x in nodes]
    )  # fmt: skip
    bend = np.linalg.solve(np.vander(nodes, 3), samples)  # parameters are quadratic in any one cell

    def gap(x: Array) -> Array:
        found: Array = (fixed[:, None] + rows @ (np.vander(x, 3) @ bend).T).max(axis=0) - wanted
        return found

    x = np.linspace(low, high, GRID)
    value = gap(x)
    for k in np.flatnonzero(value[:-1] * value[1:] < 0.0):
        root, slope = _bisected(gap, float(x[k]), float(x[k + 1])), (value[k + 1] - value[k]) / (x[k + 1] - x[k])
        half = abs(room / slope)
        found = shortest_between(float(root - half), float(root + half))
        yield CellChange(column, link, entry, _printed(table, cell), found), float(root - half), float(root + half)


def shortest_between(low: float, high: float) -> float:
    """The number of fewest decimals in a range.

    >>> shortest_between(-0.02386, -0.02372)
    -0.0238
    """
    for digits in range(16):
        found = round((low + high) / 2, digits)
        if low <= found <= high:
            return found
    return (low + high) / 2


def _bisected(gap: Callable[[Array], Array], low: float, high: float) -> float:
    rising = gap(np.array([high]))[0] > 0.0
    for _ in range(50):
        middle = (low + high) / 2
        if (gap(np.array([middle]))[0] > 0.0) == rising:
            high = middle
        else:
            low = middle
    return float((low + high) / 2)


def _printed(table: PrintedTable, cell: tuple[str, int, int]) -> float:
    column, link, entry = cell
    if column == "com":
        return float(table.com[link, entry])
    if column == "mass":
        return float(table.mass[link])
    r, c = TENSOR[entry]
    return float(table.inertia[link, r, c])


def _range(table: PrintedTable, column: str, link: int, entry: int) -> tuple[float, float]:
    """Where a cell may lie: coms within twice the farthest, moments up to twice the largest, masses up to threefold."""
    if column == "com":
        far = 2.0 * float(np.abs(table.com).max())
        return -far, far
    if column == "mass":
        return 0.0, 3.0 * float(table.mass[link])
    largest = 2.0 * float(np.abs(table.inertia[link]).max())
    return (0.0 if entry < 3 else -largest), largest
