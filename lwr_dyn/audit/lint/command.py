"""`lwr-dyn lint`: slips in tables of numbers that show without a model; exit 1 when something is found."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import click

from lwr_dyn.audit.lint.examine import lint, sheet_of_file, sheets_of_robot
from lwr_dyn.audit.lint.finding import Finding
from lwr_dyn.audit.lint.sheet import Sheet
from lwr_dyn.cli.options import print_json
from lwr_dyn.errors import UnknownNameError
from lwr_dyn.papers.catalog import robots


@click.command("lint")
@click.argument("files", nargs=-1, required=True, metavar="FILE|ROBOT...")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(files: tuple[str, ...], as_json: bool) -> None:
    """Look for slips in .toml and .csv files of numbers, or in all that is printed of a robot; exit 1 when some show.

    Means outside their extremes, cells or columns exchanged, powers of ten, copied neighbours, shifted rows, sums that
    do not add up, tensors that are not symmetric, units of another quantity, arithmetic that is wrong.
    """
    sheets = [sheet for name in dict.fromkeys(files) for sheet in _sheets(name)]
    found = [finding for sheet in sheets for finding in lint(sheet)]
    counted = [f for f in found if f.counts]
    if as_json:
        print_json({"files": list(files), "findings": [f.record() for f in found], "holds": not counted})
    else:
        for finding in found:
            click.echo(finding.line())
        click.echo(_summary(counted, len(found) - len(counted), sheets))
    sys.exit(1 if counted else 0)


def _sheets(name: str) -> tuple[Sheet, ...]:
    """A file, or everything that comes with the package about a robot."""
    if Path(name).suffix.lower() in (".toml", ".csv") or "/" in name:
        return (sheet_of_file(name),)
    if name not in robots():
        raise UnknownNameError("robot", name, (*robots(), "a path to a .toml or .csv file"))
    return sheets_of_robot(name)


def _summary(counted: Sequence[Finding], notes: int, sheets: Sequence[Sheet]) -> str:
    known = sum(bool(f.known) for f in counted)
    said = f", {known} of them known as errata" if known else ""
    looked = f"{sum(map(_numbers, sheets))} numbers looked at: "
    return looked + f"{len(counted)} found{said}" + (f"; {notes} notes" if notes else "")


def _numbers(sheet: Sheet) -> int:
    """How many cells print a number: where none does, nothing was looked at."""
    columns = [c for table in sheet.tables for c in (*table.columns, *table.values.values())]
    return sum(n is not None for column in columns for n in column.numbers)
