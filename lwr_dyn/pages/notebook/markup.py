"""Small HTML for a cell of a notebook: readable without a style sheet, everything escaped."""

from html import escape

from lwr_dyn.foundation.tables import Table

ROWS = 12
"""Rows of a table that are shown; a line says how many are left out."""
_SOFT = "color:var(--soft,inherit)"
_LINE = 160
"""Letters of a line that are shown."""


def line(text: str, mark: str = "div") -> str:
    """A line of text, cut where it is long.

    >>> line("a < b")
    '<div>a &lt; b</div>'
    """
    shown = text if len(text) <= _LINE else f"{text[: _LINE - 4]} ..."
    return f"<{mark}>{escape(shown)}</{mark}>"


def table_html(table: Table) -> str:
    """A table with its title and its note; its first column names the rows."""
    head = "".join(f'<th scope="col">{escape(h.title)}</th>' for h in table.columns)
    rows = "".join(_row(cells) for cells in table.cells[:ROWS])
    left = len(table.cells) - ROWS
    notes = [f"and {left} more"] if left > 0 else []
    notes += [table.note] if table.note else []
    caption = f'<caption style="text-align:left">{escape(table.title)}</caption>' if table.title else ""
    body = f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    return body + "".join(f'<div style="{_SOFT}">{escape(note)}</div>' for note in notes)


def _row(cells: tuple[str, ...]) -> str:
    first, *rest = (escape(cell) for cell in cells)
    return f'<tr><th scope="row">{first}</th>{"".join(f"<td>{cell}</td>" for cell in rest)}</tr>'
