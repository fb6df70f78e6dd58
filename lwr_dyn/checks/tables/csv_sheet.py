"""CSV with one heading line as a sheet; lines that begin with # declare formulas, units and roles."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass, field

from lwr_dyn.checks.tables.roles import TOTALS, name_in, role_of, unit_in, words_of
from lwr_dyn.checks.tables.sheet import Declared, Sentence, Sheet, SheetColumn, SheetTable, TableError

SEPARATORS = ",;\t|"
DECLARATIONS = ("title", "formula", "ratio", "joints", "total", "role")


@dataclass(slots=True)
class CsvDeclarations:
    """The # lines of a CSV text by their word."""

    lines: dict[str, list[str]] = field(default_factory=dict)

    def add(self, line: str) -> None:
        """Take a line "# WORD: text"; others are comments."""
        word, sign, rest = line.lstrip("# ").partition(":")
        if sign and word.strip().lower() in DECLARATIONS:
            self.lines.setdefault(word.strip().lower(), []).append(rest.strip())

    def texts(self, word: str) -> tuple[str, ...]:
        """The texts of a word, line by line."""
        return tuple(self.lines.get(word, []))

    def pairs(self, word: str) -> dict[str, str]:
        """Lines such as "mass = 14.4462" as a mapping."""
        split = [line.partition("=") for line in self.texts(word)]
        return {name_in(key.strip()): value.strip() for key, _, value in split}


def sheet_of_csv(text: str, file: str, name: str) -> Sheet:
    """The table of a CSV text.

    Parameters
    ----------
    text : str
        A heading line ("Joint, Mass [kg]"), then rows; separated by , ; tab or |. Lines "# formula: Kp = 25 * Kd",
        "# ratio: Kp / Kd", "# total: Mass = 14.4462", "# joints: revolute", "# role: a = mean" and "# title: ..."
        declare. A last row labelled "total" is taken as the sum.
    file, name : str
        Names of the file and the table in messages.

    Raises
    ------
    TableError
        No CSV, no rows, a row of another length, two columns of one name.
    """
    declared = CsvDeclarations()
    body: list[str] = []
    for line in text.splitlines():
        (declared.add if line.lstrip().startswith("#") else body.append)(line)
    headings, *cells = _rows(body, file)
    bare = [name_in(h) for h in headings]
    head = [name if bare.count(name) == 1 else heading for name, heading in zip(bare, headings, strict=True)]
    roles = declared.pairs("role")
    summed = _total_row(head, cells, roles)
    body_rows = cells[:-1] if summed else cells
    columns = tuple(
        SheetColumn(name, tuple(row[j] for row in body_rows), unit_in(heading))
        for j, (name, heading) in enumerate(zip(head, headings, strict=True))
    )
    sums = {h: cell for h, cell, c in zip(head, cells[-1], columns, strict=True) if summed and c.numeric}
    declarations = Declared(
        formulas=declared.texts("formula"), ratios=declared.texts("ratio"), totals={**sums, **declared.pairs("total")},
        roles=roles, joints=" ".join(declared.texts("joints")),
    )  # fmt: skip
    title = " ".join(declared.texts("title"))
    table = SheetTable(name, columns, where=title, declared=declarations)
    return Sheet(file, (table,), sentences=(Sentence("title", title),))


def _rows(lines: Sequence[str], file: str) -> list[list[str]]:
    """The heading line and the rows, all of one length."""
    try:
        stripped = [[c.strip() for c in row] for row in csv.reader(lines, delimiter=_separator(lines))]
    except csv.Error as fault:
        raise TableError(file, "table", str(fault), "CSV") from None
    rows = [row for row in stripped if any(row)]
    if len(rows) < 2:
        raise TableError(file, "table", f"{len(rows)} lines", "a heading line and at least one row")
    head = rows[0]
    for i, row in enumerate(rows[1:]):
        if len(row) != len(head):
            raise TableError(file, f"row {i + 1}", f"{len(row)} cells", f"{len(head)}, as the heading has")
    if len(set(head)) < len(head):
        double = next(h for h in head if head.count(h) > 1)
        raise TableError(file, "heading", f"{double!r} twice", "each column once")
    return rows


def _separator(lines: Sequence[str]) -> str:
    first = next((line for line in lines if line.strip()), "")
    return max(SEPARATORS, key=first.count)


def _total_row(head: Sequence[str], cells: Sequence[Sequence[str]], roles: dict[str, str]) -> bool:
    """The last row is labelled as the sum of the others."""
    labels = [j for j, h in enumerate(head) if role_of(h, roles) == "label"] or [0]
    return len(cells) > 2 and any(set(words_of(cells[-1][j])) & set(TOTALS) for j in labels)
