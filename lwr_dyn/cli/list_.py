"""`lwr-dyn list`: the robots, their readings, and where their numbers come from."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, TypedDict

import click

from lwr_dyn.arms.papers.catalog import open_paper, robots
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.cli.options import show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.document import Document, Note, Section
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.caveats import Caveats


@click.command("list")
@click.argument("robot", required=False)
@with_shared("--json as_json", " with every column's page and kind")
def command(robot: str | None, as_json: bool) -> None:
    """The robots and their readings; of one ROBOT (a name or a .toml) where its numbers come from.

    A reading is one way to understand the tables: as printed, as the authors computed, or as the arm most likely is.
    Unsure? Take the default.
    """
    show(_document([open_paper(name) for name in (robots() if robot is None else (robot,))], robot is None), as_json)


class ListedErratum(TypedDict):
    """A slip of the print."""

    where: Annotated[str, "Page, table or equation."]
    printed: str
    read_as: str


class ColumnRecord(TypedDict):
    """A column of the tables."""

    kind: Annotated[str, "printed, computed, datasheet, fitted, estimated or assumed."]
    where: Annotated[str, "Page, table or equation."]
    unit: Annotated[list[str], "Units of its cells."]
    note: str


COLUMNS = (
    Heading("robot", key="name"), Heading("joints", key="joints", says="How many."), Heading("title", key="title"),
    Heading("", key="document", says="Who published it, when and where.", kind=dict),
    Heading("", key="default_reading", says="The arm most likely."),
    Heading("readings (default first)", "", ", ".join, "readings", "Reading -> what it is.", dict[str, str]),
    Heading("", key="errata", says="Slips of the print that are proven or read otherwise.",
            kind=dict[str, ListedErratum]),
    Heading("", key="columns", says="Each column of the tables: page, kind and unit.", kind=dict[str, ColumnRecord]),
)  # fmt: skip


def _document(papers: Sequence[Paper], brief: bool) -> Document:
    """A row a robot; or all of one, column by column."""
    table = Table("", COLUMNS, [_row(paper) for paper in papers], key="robots", says="One a robot.", when=brief)
    next_one = Note(f"where its numbers come from: lwr-dyn list {papers[0].name}", brief)
    return Document("", "", [Section("", [table, next_one, Note([*_details(papers[0])], not brief)])], "lwr-dyn list")


def _row(paper: Paper) -> tuple[Any, ...]:
    readings = {name: paper.readings[name].about for name in paper.reading_names}
    errata = {e.id: {"where": e.where, "printed": e.printed, "read_as": e.read_as} for e in paper.errata}
    columns = {
        name: {"kind": c.kind, "where": c.where, "unit": sorted(set(c.unit)), "note": c.note}
        for name, c in paper.columns.items()
    }
    document = dict(paper.document)
    return paper.name, paper.n, paper.title, document, paper.reading.name, readings, errata, columns


def _details(paper: Paper) -> Iterator[str]:
    origin = paper.document.get("origin")
    yield f"{paper.name}: {paper.document['title']}" + (f" ({origin})" if origin else "")
    for name in paper.reading_names:
        yield f"  {name}: " + "; ".join(filter(None, (paper.readings[name].about, _left(paper, name))))
    for name, column in paper.columns.items():
        yield f"    {name:<20} {column.kind:<10} {column.where}"


def _left(paper: Paper, reading: str) -> str:
    """The proven errors that a reading leaves in place, in words."""
    return Caveats(paper.left_in_place(reading)).of_reading
