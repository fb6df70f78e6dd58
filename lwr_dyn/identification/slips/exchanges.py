"""Cells that changed places: components, axes, moments of one link; cells, rows and bodies of neighbouring links."""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import combinations

from lwr_dyn.identification.slips.printed_cells import (
    COM,
    DIAGONAL,
    PRODUCTS,
    QUANTITIES,
    ROTOR,
    TENSOR,
    Cell,
    PrintedCells,
)
from lwr_dyn.identification.slips.repairs import AXES, COLUMNS, EXCHANGE, ROWS, Repair

_AXES = "xyz"
_PLACE = {(0, 0): 4, (0, 1): 5, (0, 2): 6, (1, 1): 7, (1, 2): 8, (2, 2): 9}
_ROWS = {"com": COM, "tensor": TENSOR, "row": slice(0, ROTOR)}
APART = 2
"""Rows that a cell may have slipped."""
Place = tuple[int, int]
Move = tuple[list[tuple[Place, Place]], str, str]


def exchanges(table: PrintedCells) -> Iterator[Repair]:
    """Every exchange of two places, or of two sets of places, that hold different numbers."""
    for places, text, kind in _permutations(table.n):
        if all(table.known[source] for source, _ in places):
            repair = _exchanged(table, places, text, kind)
            if repair.cells:
                yield repair
    for link in range(table.n):
        for axis in range(3):
            for sign in (1.0, -1.0):
                repair = _turned(table, link, axis, sign)
                if len(repair.cells) > 1:
                    yield repair


def _exchanged(table: PrintedCells, places: Sequence[tuple[Place, Place]], text: str, kind: str) -> Repair:
    values = table.values.copy()
    for source, target in places:
        values[target] = table.values[source]
    changed = tuple(Cell(*p) for p, _ in places if values[p] != table.values[p])
    again = partial(_exchanged, places=places, text=text, kind=kind)
    return Repair(kind, changed, text, table.with_values(values), again)


def _turned(table: PrintedCells, link: int, axis: int, sign: float) -> Repair:
    """The centre of mass of a link turned by 90 deg about an axis: its frame was another."""
    a, b = 1 + (axis + 1) % 3, 1 + (axis + 2) % 3
    values = table.values.copy()
    values[link, a], values[link, b] = -sign * table.values[link, b], sign * table.values[link, a]
    changed = tuple(Cell(link, k) for k in (a, b) if table.known[link, k] and values[link, k] != table.values[link, k])
    text = f"com of link {link + 1} turned by {90.0 * sign:+.0f} deg about {_AXES[axis]}"
    return Repair(EXCHANGE, changed, text, table.with_values(values), partial(_turned, link=link, axis=axis, sign=sign))


def _permutations(n: int) -> Iterator[Move]:
    """(from, to) of every place that moves, what is said of it, its kind."""
    for i in range(n):
        for a, b in combinations(range(3), 2):
            yield from _within(i, a, b)
        for j, k in (*combinations(DIAGONAL, 2), *combinations(PRODUCTS, 2)):
            yield _swap([(i, j)], [(i, k)], f"{Cell(i, j).name} and {Cell(i, k).name} exchanged", EXCHANGE)
    for i, j in combinations(range(n), 2):
        yield from _between(i, j)
    for name, part in COLUMNS.items():
        for step in (1, -1):
            rows = [((i, k), ((i + step) % n, k)) for i in range(n) for k in range(len(QUANTITIES))[part]]
            yield rows, f"{name}: every row belongs one {'lower' if step == 1 else 'higher'}", ROWS


def _between(i: int, j: int) -> Iterator[Move]:
    """The same cell of two links, the same part of two neighbours."""
    if j - i <= APART:
        for k in range(len(QUANTITIES)):
            yield _swap([(i, k)], [(j, k)], f"{Cell(i, k).name} and {Cell(j, k).name} exchanged", EXCHANGE)
    if j - i == 1:
        for name, part in _ROWS.items():
            here, there = ([(link, k) for k in range(len(QUANTITIES))[part]] for link in (i, j))
            yield _swap(here, there, f"{name} of links {i + 1} and {j + 1} exchanged", ROWS)


def _within(i: int, a: int, b: int) -> Iterator[Move]:
    """Two axes of one link: of its centre of mass, of its tensor, of both."""
    com = ([(i, 1 + a)], [(i, 1 + b)])
    third = 3 - a - b
    tensor = (
        [(i, _PLACE[a, a]), (i, _PLACE[min(a, third), max(a, third)])],
        [(i, _PLACE[b, b]), (i, _PLACE[min(b, third), max(b, third)])],
    )
    axes = f"{_AXES[a]} and {_AXES[b]}"
    yield _swap(*com, f"{Cell(*com[0][0]).name} and {Cell(*com[1][0]).name} exchanged", EXCHANGE)
    yield _swap(*tensor, f"axes {axes} of the tensor of link {i + 1} exchanged", AXES)
    yield _swap([*com[0], *tensor[0]], [*com[1], *tensor[1]], f"axes {axes} of link {i + 1} exchanged", AXES)


def _swap(here: Sequence[Place], there: Sequence[Place], text: str, kind: str) -> Move:
    return [*zip(here, there, strict=True), *zip(there, here, strict=True)], text, kind
