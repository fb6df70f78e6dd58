"""`lwr-dyn lint`: faults in tables of numbers that need no model to be seen; exit 1 when there are some."""

import sys
from collections.abc import Sequence
from pathlib import Path

import click

from lwr_dyn.audit.lint.rules import lint, sheet_of_file, sheets_of_robot
from lwr_dyn.audit.lint.sheet import Finding, Sheet
from lwr_dyn.cli.options import print_json
from lwr_dyn.errors import UnknownNameError
from lwr_dyn.papers.catalog import robots


@click.command("lint")
@click.argument("files", nargs=-1, required=True, metavar="FILE|ROBOT...")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(files: tuple[str, ...], as_json: bool) -> None:
    """Find faults in .toml and .csv files of numbers, or in all that is printed of a robot; exit 1 when there are some.

    Means outside their extremes, cells or columns exchanged, powers of ten, copied neighbours, shifted rows, sums that
    do not add up, tensors that are not symmetric, units of another quantity, arithmetic that is wrong.
    """
    sheets = [sheet for name in dict.fromkeys(files) for sheet in _sheets(name)]
    findings = [finding for sheet in sheets for finding in lint(sheet)]
    counted = [f for f in findings if f.counts]
    if as_json:
        print_json({"files": list(files), "findings": [f.record() for f in findings], "holds": not counted})
    else:
        for finding in findings:
            click.echo(finding.line())
        click.echo(_summary(counted, len(findings) - len(counted), sheets))
    sys.exit(1 if counted else 0)


def _sheets(name: str) -> tuple[Sheet, ...]:
    """A file; or of a robot, its data file and the printed results of its paper."""
    if Path(name).suffix.lower() in (".toml", ".csv") or "/" in name:
        return (sheet_of_file(name),)
    if name not in robots():
        raise UnknownNameError("robot", name, (*robots(), "a path to a .toml or .csv file"))
    return sheets_of_robot(name)


def _summary(counted: Sequence[Finding], notes: int, sheets: Sequence[Sheet]) -> str:
    known = sum(bool(f.known) for f in counted)
    total = sum(map(_numbers, sheets))
    errata = f", {known} of them known as errata" if known else ""
    return f"{total} numbers looked at: {len(counted)} found{errata}" + (f"; {notes} notes" if notes else "")


def _numbers(sheet: Sheet) -> int:
    """How many cells print a number: with none, nothing was examined."""
    columns = [c for table in sheet.tables for c in (*table.columns, *table.values.values())]
    return sum(n is not None for column in columns for n in column.numbers)
