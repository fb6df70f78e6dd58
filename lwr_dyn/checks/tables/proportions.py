"""Columns of one file that are proportional in most rows, the rows that break it, and rows that are shifted by one.

A broken row alone is no fault (joint 2 of an arm may have another range). It is a finding when one named fault, an
exchange of two cells or a power of ten, makes every row proportional again. Rows are shifted where two columns of a
file repeat each other's numbers only when one is moved up or down.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from lwr_dyn.checks.tables.formulas import exchanges
from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetColumn, SheetTable, TableError
from lwr_dyn.model.printed_number import ROUND, PrintedNumber

LEAST_ROWS = 3
"""Rows that have to agree before a ratio counts as constant."""
LEAST_SHARE = 0.6
"""Share of the rows that have to agree."""
SHARPEST = 0.03
"""A row takes part when its rounding leaves less than this share of the ratio open."""
LEAST_DISTINCT = 3
"""Different numbers among the agreeing rows: two constants are always proportional."""
MOST_BROKEN = 3
SAMPLE = 200
"""First rows of a long table in which a ratio has to show before all rows are examined."""
LARGEST_POWER = 6
Interval = tuple[float, float]
Place = tuple[int, int]
"""Column (0 or 1) and row of a cell of a pair."""


def ratio(a: PrintedNumber | None, b: PrintedNumber | None) -> Interval | None:
    """All values that a / b may have within their printed digits; None when that leaves too much open.

    >>> low, high = ratio(PrintedNumber("13.5", 13.5, 0.05), PrintedNumber("0.54", 0.54, 0.005))
    >>> round(low, 2), round(high, 2)
    (24.68, 25.32)
    """
    if a is None or b is None or abs(a.value) <= a.half or abs(b.value) <= b.half:
        return None
    middle = a.value / b.value
    spread = abs(middle) * (a.half / abs(a.value) + b.half / abs(b.value)) * (1.0 + ROUND)
    return (middle - spread, middle + spread) if spread <= SHARPEST * abs(middle) else None


@dataclass(frozen=True, slots=True)
class ColumnPair:
    """Two columns with as many rows, of one file."""

    tables: tuple[SheetTable, SheetTable]
    columns: tuple[SheetColumn, SheetColumn]

    @property
    def full_names(self) -> list[str]:
        """The columns with their tables."""
        return [f"{t.name}.{c.name}" for t, c in zip(self.tables, self.columns, strict=True)]

    @property
    def name(self) -> str:
        """ "a / b", with the tables where they differ."""
        same = self.tables[0].name == self.tables[1].name
        return " / ".join([c.name for c in self.columns] if same else self.full_names)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.columns[0].cells)

    def places(self, row: int) -> tuple[str, str]:
        """The two cells of a row in words."""
        a, b = (t.place(row, c.name) for t, c in zip(self.tables, self.columns, strict=True))
        return a, b

    def texts(self, row: int) -> tuple[str, str]:
        """The two cells of a row as printed."""
        return self.columns[0].cells[row], self.columns[1].cells[row]

    def ratio(self, row: int, changed: Mapping[Place, PrintedNumber] | None = None) -> Interval | None:
        """The ratio in a row, some cells changed."""
        new = changed or {}
        return ratio(*(new.get((side, row), self.columns[side].numbers[row]) for side in (0, 1)))


def column_pairs(sheet: Sheet) -> Iterator[ColumnPair]:
    """Every two numeric columns with the same number of rows."""
    columns = [(t, c) for t in sheet.tables for c in t.columns if c.numeric and len(c.cells) > LEAST_ROWS]
    for (s, a), (t, b) in itertools.combinations(columns, 2):
        if len(a.cells) == len(b.cells):
            yield ColumnPair((s, t), (a, b))


@dataclass(frozen=True, slots=True)
class ConstantRatio:
    """The ratio of a pair of columns is `value` in the rows `kept`, not in `broken`."""

    pair: ColumnPair
    value: Interval
    kept: tuple[int, ...]
    broken: tuple[int, ...]

    @property
    def middle(self) -> float:
        """The ratio."""
        return sum(self.value) / 2

    def holds(self, other: Interval | None) -> bool:
        """The ratio of a row can be this one."""
        return other is not None and other[0] <= self.value[1] and self.value[0] <= other[1]

    def numbers(self) -> dict[str, object]:
        """The ratio, in all rows too, as JSON values."""
        rows = [self.pair.ratio(i) for i in range(self.pair.rows)]
        middles = [None if r is None else sum(r) / 2 for r in rows]
        broken = [i + 1 for i in self.broken]
        return {"ratio": self.middle, "of": self.pair.name, "rows": middles, "broken": broken}


def constant_ratio(pair: ColumnPair) -> ConstantRatio | None:
    """The ratio that most rows share, if there is one, sharp, and not of two constants."""
    if pair.rows > 2 * SAMPLE and len(_most(_ratios(pair, SAMPLE))) < LEAST_SHARE * SAMPLE / 2:
        return None
    ratios = _ratios(pair, pair.rows)
    best = _most(ratios)
    distinct = min(len({n.digits.rstrip("0") for i in best if (n := c.numbers[i])}) for c in pair.columns)
    if len(best) < max(LEAST_ROWS, LEAST_SHARE * len(ratios)) or distinct < LEAST_DISTINCT:
        return None
    value = max(ratios[i][0] for i in best), min(ratios[i][1] for i in best)
    return ConstantRatio(pair, value, best, tuple(i for i in ratios if i not in best))


def _ratios(pair: ColumnPair, rows: int) -> dict[int, Interval]:
    """The ratios of the first rows, where they are sharp."""
    return {i: r for i in range(rows) if (r := pair.ratio(i))}


def _most(ratios: dict[int, Interval]) -> tuple[int, ...]:
    """The rows of the largest set of intervals that have a point in common."""
    ends = sorted([(low, 0) for low, _ in ratios.values()] + [(high, 1) for _, high in ratios.values()])
    depth, deepest, at = 0, 0, 0.0
    for x, closes in ends:
        depth += -1 if closes else 1
        if depth > deepest:
            deepest, at = depth, x
    return tuple(i for i, (low, high) in ratios.items() if low <= at <= high)


def proportions(sheet: Sheet) -> Iterator[Finding]:
    """Rules 3 and 4 without a formula: cells exchanged, or off by a power of ten, in a column that follows another."""
    seen: set[tuple[str, frozenset[str]]] = set()
    declared = {frozenset(names): text for text, names in _declared(sheet)}
    for pair in column_pairs(sheet):
        constant, text = constant_ratio(pair), declared.get(frozenset(pair.full_names), "")
        if constant is None or not 0 < len(constant.broken) <= (len(constant.kept) if text else MOST_BROKEN):
            continue
        findings = [*_exchanged(constant), *_power_of_ten(constant)]
        for finding in findings or (_broken(constant, text) if text else ()):
            key = finding.rule, frozenset(finding.cells)
            if key not in seen:
                seen.add(key)
                yield finding


def _declared(sheet: Sheet) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The declared ratios with the full names of their columns; raises `TableError` for unknown names."""
    full = {f"{t.name}.{c.name}" for t in sheet.tables for c in t.columns}
    for table in sheet.tables:
        for text in table.declared.ratios:
            names = tuple(n if n in full else f"{table.name}.{n}" for n in (x.strip() for x in text.split(" / ")))
            if len(names) != 2 or not set(names) <= full:
                raise TableError(sheet.file, f"{table.name}, ratio", repr(text), "COLUMN / COLUMN of this file")
            yield text, names


def _broken(constant: ConstantRatio, text: str) -> Iterator[Finding]:
    """Rows that break a ratio that the file declares, with no fault that explains them."""
    pair = constant.pair
    for row in constant.broken:
        ratio = sum(pair.ratio(row) or (0.0, 0.0)) / 2
        yield Finding(
            "ratio", "error", "certain", pair.places(row), ", ".join(pair.texts(row)),
            f"{pair.name} = {constant.middle:.6g}",
            f"{text} is {ratio:.6g} here and {constant.middle:.6g} in {len(constant.kept)} other rows",
            constant.numbers(),
        )  # fmt: skip


def _exchanged(constant: ConstantRatio) -> Iterator[Finding]:
    """Exchanges of two cells of the broken rows after which every row has the ratio."""
    pair, broken = constant.pair, constant.broken
    places = [(side, i) for i in broken for side in (0, 1)]
    numbers = {(side, i): n for side, i in places if (n := pair.columns[side].numbers[i])}
    fits = exchanges(numbers, lambda new: all(constant.holds(pair.ratio(i, new)) for i in broken))
    if not fits:
        return
    words = [tuple(pair.places(i)[side] for side, i in fit) for fit in fits]
    cells, (a, b) = words[0], (numbers[place].text for place in fits[0])
    others = "; or ".join(f"{x} with {y}" for x, y in words[1:])
    again = f" (so does exchanging {others})" if others else ""
    kept, rows = len(constant.kept), len(constant.kept) + len(broken)
    yield Finding(
        "swapped", "error", "certain" if len(fits) == 1 else "likely", cells, f"{a}, {b}", f"{b}, {a}",
        f"{cells[0]} prints {a} and {cells[1]} prints {b}: exchanged, {pair.name} is {constant.middle:.6g} "
        f"in every row as it is in {kept} of {rows} as printed{again}", constant.numbers(),
    )  # fmt: skip


def _power_of_ten(constant: ConstantRatio) -> Iterator[Finding]:
    """The one broken row has the ratio when one of its cells is multiplied by a power of ten."""
    pair, here = constant.pair, constant.pair.ratio(constant.broken[0])
    if len(constant.broken) != 1 or here is None:
        return
    cells, (a, b) = pair.places(constant.broken[0]), pair.texts(constant.broken[0])
    for k in (k for k in range(-LARGEST_POWER, LARGEST_POWER + 1) if k):
        low, high = sorted(x * 10.0**k for x in here)
        if constant.holds((low, high)):
            yield Finding(
                "power-of-ten", "error", "likely", cells, f"{a}, {b}", f"{a} times 1e{k}, or {b} times 1e{-k}",
                f"{cells[0]} prints {a} and {cells[1]} prints {b}: {pair.name} is {constant.middle:.6g} "
                f"in the other {len(constant.kept)} rows, here off by 1e{-k}", constant.numbers(),
            )  # fmt: skip


LEAST_MATCHES = 3
"""Different numbers other than 0 that have to repeat."""
SAME = 1e-9
Sizes = Sequence[float | None]


def column_sizes(sheet: Sheet) -> Iterator[tuple[str, str, Sizes]]:
    """Name, unit and sizes of every column, or vector of up to three columns: a turned frame hides no repeat."""
    for table in sheet.tables:
        groups: dict[str, list[SheetColumn]] = {}
        for column in table.columns:
            groups.setdefault(column.group or column.name, []).append(column)
        for name, columns in groups.items():
            if len(columns) <= 3 and all(c.numeric for c in columns):
                yield f"{table.name}.{name}", columns[0].unit, [_size(columns, i) for i in range(table.rows)]


def _size(columns: Sequence[SheetColumn], row: int) -> float | None:
    values = [n.value for c in columns if (n := c.numbers[row]) is not None]
    return float(sum(x * x for x in values) ** 0.5) if len(values) == len(columns) else None


def shifts(sheet: Sheet) -> Iterator[Finding]:
    """Rule 6: whole columns, or all rows of one from some row on, that fit another column one row up or down."""
    for (one, unit, a), (other, its, b) in itertools.combinations(column_sizes(sheet), 2):
        if unit == its and len(a) == len(b):
            yield from _shifted(one, other, a, b)


def _shifted(one: str, other: str, a: Sizes, b: Sizes) -> Iterator[Finding]:
    printed, expected = (", ".join("-" if x is None else f"{x:.6g}" for x in sizes) for sizes in (a, b))
    straight = [_same(x, y) for x, y in zip(a, b, strict=True)]
    for step, sense in ((1, "lower"), (-1, "higher")):
        first = None if all(straight) else _first_shifted(a, b, straight, step)
        if first is None:
            continue
        since = "" if first == 0 else f" from row {first + 1} on"
        yield Finding(
            "rows-shifted", "error", "likely", (one, other), printed, expected,
            f"{one}{since} repeats the sizes of {other} when each stands one row {sense}; as printed "
            f"{sum(straight)} of {len(a)} rows agree: one of the two is shifted",
            {"shift": step, "from_row": first + 1, one: list(a), other: list(b)},
        )  # fmt: skip
        return


def _first_shifted(a: Sizes, b: Sizes, straight: Sequence[bool], step: int) -> int | None:
    """The first row from which a, moved by `step` rows, is b; the rows before agree as they stand."""
    n = len(a)
    for first in range(n - LEAST_MATCHES):
        if first and not straight[first - 1]:
            return None
        source = range(first, n - 1) if step == 1 else range(max(first, 1), n)
        matched = [(a[i], b[i + step]) for i in source]
        distinct = {x for x, _ in matched if x}
        if all(_same(x, y) for x, y in matched) and len(distinct) >= LEAST_MATCHES and not all(straight[first:-1]):
            return first
    return None


def _same(x: float | None, y: float | None) -> bool:
    return x is not None and y is not None and abs(x - y) <= SAME * max(abs(x), abs(y))
