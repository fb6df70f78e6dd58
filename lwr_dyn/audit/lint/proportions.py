"""Columns of one file that are proportional in most rows, and the rows that break it.

A broken row alone says nothing (joint 2 of an arm may have another range). It is a finding when one named slip, a swap
of two cells or a power of ten, makes every row proportional again.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.sheet import Column, Sheet, Table, TableError
from lwr_dyn.papers.printed_number import ROUND, PrintedNumber

LEAST_ROWS = 3
"""Rows that have to agree before a ratio counts as one."""
LEAST_SHARE = 0.6
"""Share of the rows that have to agree."""
SHARPEST = 0.03
"""A row takes part when its rounding leaves less than this of the ratio open."""
LEAST_DISTINCT = 3
"""Different numbers among the agreeing rows: two constants are always proportional."""
MOST_BROKEN = 3
SAMPLE = 200
"""First rows of a long table in which a ratio has to show before all rows are looked at."""
Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Pair:
    """Two columns with as many rows, of one file."""

    tables: tuple[Table, Table]
    columns: tuple[Column, Column]

    def place(self, side: int, row: int) -> str:
        """A cell in words."""
        return self.tables[side].place(row, self.columns[side].name)

    def number(self, side: int, row: int) -> PrintedNumber | None:
        """What the cell prints."""
        return self.columns[side].numbers[row]


def ratio(a: PrintedNumber | None, b: PrintedNumber | None) -> Interval | None:
    """All values that a / b may have within their printed digits; nothing when that leaves too much open.

    >>> low, high = ratio(*(PrintedNumber(t, v, h) for t, v, h in (("13.5", 13.5, 0.05), ("0.54", 0.54, 0.005))))
    >>> round(low, 2), round(high, 2)
    (24.68, 25.32)
    """
    if a is None or b is None or abs(a.value) <= a.half or abs(b.value) <= b.half:
        return None
    middle = a.value / b.value
    spread = abs(middle) * (a.half / abs(a.value) + b.half / abs(b.value)) * (1.0 + ROUND)
    return (middle - spread, middle + spread) if spread <= SHARPEST * abs(middle) else None


def pairs(sheet: Sheet) -> Iterator[Pair]:
    """Every two numeric columns with the same number of rows."""
    columns = [(t, c) for t in sheet.tables for c in t.columns if c.numeric and len(c.cells) > LEAST_ROWS]
    for (s, a), (t, b) in itertools.combinations(columns, 2):
        if len(a.cells) == len(b.cells):
            yield Pair((s, t), (a, b))


@dataclass(frozen=True, slots=True)
class Law:
    """a / b = `value` in the rows `kept`, not in `broken`."""

    value: Interval
    kept: tuple[int, ...]
    broken: tuple[int, ...]

    @property
    def middle(self) -> float:
        """The ratio."""
        return sum(self.value) / 2

    def holds(self, found: Interval | None) -> bool:
        """This ratio is the same one."""
        return found is not None and found[0] <= self.value[1] and self.value[0] <= found[1]


def law_of(pair: Pair) -> Law | None:
    """The ratio on which most rows agree, if it is there, sharp, and no accident of constants."""
    rows = len(pair.columns[0].cells)
    if rows > 2 * SAMPLE and len(_most(_ratios(pair, SAMPLE))) < LEAST_SHARE * SAMPLE / 2:
        return None
    found = _ratios(pair, rows)
    if len(found) < LEAST_ROWS:
        return None
    best = _most(found)
    if len(best) < max(LEAST_ROWS, LEAST_SHARE * len(found)) or not _tells(pair, best):
        return None
    value = max(found[i][0] for i in best), min(found[i][1] for i in best)
    return Law(value, best, tuple(i for i in found if i not in best))


def _ratios(pair: Pair, rows: int) -> dict[int, Interval]:
    """The ratios of the first rows, where they are sharp."""
    return {i: r for i in range(rows) if (r := ratio(pair.number(0, i), pair.number(1, i)))}


def _most(found: dict[int, Interval]) -> tuple[int, ...]:
    """The rows of the largest set of intervals that have a point in common."""
    ends = sorted([(low, 0) for low, _ in found.values()] + [(high, 1) for _, high in found.values()])
    depth, deepest, at = 0, 0, 0.0
    for x, closes in ends:
        depth += -1 if closes else 1
        if depth > deepest:
            deepest, at = depth, x
    return tuple(i for i, (low, high) in found.items() if low <= at <= high)


def _tells(pair: Pair, rows: Sequence[int]) -> bool:
    texts = [{n.digits.rstrip("0") for i in rows if (n := pair.number(side, i))} for side in (0, 1)]
    return min(len(t) for t in texts) >= LEAST_DISTINCT


def proportions(sheet: Sheet) -> Iterator[Finding]:
    """Rules 3 and 4 without a formula: cells exchanged, or off by a power of ten, in a column that follows another."""
    seen: set[tuple[str, frozenset[str]]] = set()
    declared = {frozenset(names): text for text, names in _declared(sheet)}
    for pair in pairs(sheet):
        law, text = law_of(pair), declared.get(frozenset(_full_names(pair)), "")
        if law is None or not 0 < len(law.broken) <= (len(law.kept) if text else MOST_BROKEN):
            continue
        findings = [*_swaps(sheet.file, pair, law), *_powers(sheet.file, pair, law)]
        for finding in findings or (_broken(sheet.file, pair, law, text) if text else ()):
            key = finding.rule, frozenset(finding.cells)
            if key not in seen:
                seen.add(key)
                yield finding


def _full_names(pair: Pair) -> tuple[str, ...]:
    return tuple(f"{t.name}.{c.name}" for t, c in zip(pair.tables, pair.columns, strict=True))


def _declared(sheet: Sheet) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The declared ratios with the full names of their columns; raises `TableError` for one that names none."""
    full = {f"{t.name}.{c.name}" for t in sheet.tables for c in t.columns}
    for table in sheet.tables:
        for text in table.declared.ratios:
            names = tuple(n if n in full else f"{table.name}.{n}" for n in (x.strip() for x in text.split(" / ")))
            if len(names) != 2 or not set(names) <= full:
                raise TableError(sheet.file, f"{table.name}, ratio", repr(text), "COLUMN / COLUMN of this file")
            yield text, names


def _broken(file: str, pair: Pair, law: Law, text: str) -> Iterator[Finding]:
    """Rows that break a ratio that the file declares, with no slip that explains them."""
    for row in law.broken:
        cells = tuple(pair.place(side, row) for side in (0, 1))
        printed = ", ".join(pair.columns[side].cells[row] for side in (0, 1))
        found = ratio(pair.number(0, row), pair.number(1, row)) or (0.0, 0.0)
        yield Finding(
            "ratio", "error", "certain", file, cells[0], cells, printed, f"{_names(pair)} = {law.middle:.6g}",
            f"{text} is {sum(found) / 2:.6g} here and {law.middle:.6g} in {len(law.kept)} other rows",
            _numbers(pair, law),
        )  # fmt: skip


def _swaps(file: str, pair: Pair, law: Law) -> Iterator[Finding]:
    """Exchanges of two cells of the broken rows after which every row obeys the law."""
    places = [(side, i) for i in law.broken for side in (0, 1)]
    fits = [
        (one, other)
        for one, other in itertools.combinations(places, 2)
        if all(law.holds(_ratio_swapped(pair, i, one, other)) for i in law.broken)
    ]
    if not fits:
        return
    one, other = fits[0]
    a, b = pair.number(*one), pair.number(*other)
    if a is None or b is None:
        return
    cells = tuple(pair.place(*cell) for cell in (one, other))
    others = [f"{pair.place(*x)} with {pair.place(*y)}" for x, y in fits[1:]]
    said = f"{cells[0]} prints {a.text} and {cells[1]} prints {b.text}"
    again = f" (so does exchanging {'; or '.join(others)})" if others else ""
    yield Finding(
        "swapped", "error", "certain" if len(fits) == 1 else "likely", file, cells[0], cells, f"{a.text}, {b.text}",
        f"{b.text}, {a.text}", f"{said}: exchanged, {_names(pair)} is {law.middle:.6g} in every row as it is in "
        f"{len(law.kept)} of {len(law.kept) + len(law.broken)} as printed{again}", _numbers(pair, law),
    )  # fmt: skip


def _ratio_swapped(pair: Pair, row: int, one: tuple[int, int], other: tuple[int, int]) -> Interval | None:
    to = {one: other, other: one}
    return ratio(*(pair.number(*to.get((side, row), (side, row))) for side in (0, 1)))


def _powers(file: str, pair: Pair, law: Law) -> Iterator[Finding]:
    if len(law.broken) != 1:
        return
    (row,) = law.broken
    found = ratio(pair.number(0, row), pair.number(1, row))
    for k in (k for k in range(-6, 7) if k and found):
        if found and law.holds((min(x * 10.0**k for x in found), max(x * 10.0**k for x in found))):
            cells = tuple(pair.place(side, row) for side in (0, 1))
            texts = [pair.columns[side].cells[row] for side in (0, 1)]
            yield Finding(
                "power-of-ten", "error", "likely", file, cells[0], cells, ", ".join(texts),
                f"{texts[0]} times 1e{k}, or {texts[1]} times 1e{-k}",
                f"{cells[0]} prints {texts[0]} and {cells[1]} prints {texts[1]}: {_names(pair)} is {law.middle:.6g} "
                f"in the other {len(law.kept)} rows, here off by 1e{-k}", _numbers(pair, law),
            )  # fmt: skip


def _names(pair: Pair) -> str:
    same = pair.tables[0].name == pair.tables[1].name
    a, b = (c.name if same else f"{t.name}.{c.name}" for t, c in zip(pair.tables, pair.columns, strict=True))
    return f"{a} / {b}"


def _numbers(pair: Pair, law: Law) -> dict[str, object]:
    rows = [ratio(pair.number(0, i), pair.number(1, i)) for i in range(len(pair.columns[0].cells))]
    middles = [None if r is None else sum(r) / 2 for r in rows]
    return {"ratio": law.middle, "of": _names(pair), "rows": middles, "broken": [i + 1 for i in law.broken]}
