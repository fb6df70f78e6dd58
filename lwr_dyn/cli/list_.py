"""`lwr-dyn list`: the robots, their readings, and where their numbers come from."""

from typing import Any

import click

from lwr_dyn.arms.papers.catalog import open_paper, robots
from lwr_dyn.cli.options import print_json
from lwr_dyn.foundation.tables import aligned


@click.command("list")
@click.argument("robot", required=False)
@click.option("--json", "as_json", is_flag=True, help="One JSON object with every column's page and kind.")
def command(robot: str | None, as_json: bool) -> None:
    """The robots and their readings; of one ROBOT (a name or a .toml) where its numbers come from.

    A reading is one way to understand the tables: as printed, as the authors computed, or as the arm most likely is.
    Unsure? Take the default.
    """
    entries = [_entry(name) for name in (robots() if robot is None else (robot,))]
    if as_json:
        print_json({"robots": entries})
        return
    if robot is None:
        rows = [(e["name"], str(e["joints"]), e["title"], ", ".join(e["readings"])) for e in entries]
        click.echo(aligned(rows, ("robot", "joints", "title", "readings (default first)")))
        click.echo(f"where its numbers come from: lwr-dyn list {entries[0]['name']}")
        return
    for e in entries:
        click.echo(f"{e['name']}: {e['document']['title']} ({e['document']['origin']})")
        for name, about in e["readings"].items():
            click.echo(f"  {name}: {about}")
        for name, column in e["columns"].items():
            click.echo(f"    {name:<20} {column['kind']:<10} {column['where']}")


def _entry(robot: str) -> dict[str, Any]:
    paper = open_paper(robot)
    return {
        "name": paper.name,
        "title": paper.title,
        "joints": paper.n,
        "document": dict(paper.document),
        "default_reading": paper.reading.name,
        "readings": {name: paper.readings[name].about for name in paper.reading_names},
        "errata": {e.id: {"where": e.where, "printed": e.printed, "read_as": e.read_as} for e in paper.errata},
        "columns": {
            name: {"kind": c.kind, "where": c.where, "unit": sorted(set(c.unit)), "note": c.note}
            for name, c in paper.columns.items()
        },
    }
