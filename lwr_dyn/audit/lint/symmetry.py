"""Matrices that have to be symmetric, or are but for one entry, and are not."""

from __future__ import annotations

from collections.abc import Iterator

from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.sheet import Matrix, Sheet
from lwr_dyn.papers.printed_number import PrintedNumber, printed_number

Opposite = tuple[int, int, PrintedNumber, PrintedNumber]


def symmetry(sheet: Sheet) -> Iterator[Finding]:
    """Rule 8: entries (i, j) and (j, i) that print different numbers."""
    for matrix in sheet.matrices:
        pairs = list(_pairs(matrix))
        off = [p for p in pairs if not _agree(p[2], p[3])]
        meant = matrix.symmetric or _nearly(pairs, off)
        for i, j, a, b in off if meant else []:
            cells = f"{matrix.name}[{i + 1},{j + 1}]", f"{matrix.name}[{j + 1},{i + 1}]"
            how = _how(a, b)
            yield Finding(
                "not-symmetric", "error" if matrix.symmetric else "warning",
                "certain" if matrix.symmetric else "possible", sheet.file, cells[0], cells, f"{a.text}, {b.text}",
                f"{a.text} or {b.text} in both", f"({i + 1},{j + 1}) prints {a.text} and ({j + 1},{i + 1}) prints "
                f"{b.text} in a matrix that {'has to be' if matrix.symmetric else 'else is'} symmetric{how}",
                {"difference": a.value - b.value},
            )  # fmt: skip


def _pairs(matrix: Matrix) -> Iterator[Opposite]:
    size = len(matrix.cells)
    for i in range(size):
        for j in range(i + 1, size):
            a, b = printed_number(matrix.cells[i][j]), printed_number(matrix.cells[j][i])
            if a is not None and b is not None:
                yield i, j, a, b


def _agree(a: PrintedNumber, b: PrintedNumber) -> bool:
    return a.value == b.value or abs(a.value - b.value) < max(a.half, b.half) * (a.half != b.half)


def _nearly(pairs: list[Opposite], off: list[Opposite]) -> bool:
    """At least three opposite pairs of numbers other than nought and one agree, and one does not."""
    told = [p for p in pairs if p not in off and len(p[2].digits.rstrip("0")) >= 3]
    return len(off) == 1 and len(told) >= 3


def _how(a: PrintedNumber, b: PrintedNumber) -> str:
    if a.value == -b.value:
        return ": their signs differ"
    larger, smaller = max(abs(a.value), abs(b.value)), min(abs(a.value), abs(b.value))
    power = next((k for k in range(1, 10) if smaller and abs(larger / smaller / 10**k - 1) < 1e-9), 0)
    return f": they differ by 1e{power}" if power else ""
