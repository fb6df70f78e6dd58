"""`lwr-dyn check`: every check of one robot's model; exit 1 when one fails."""

from __future__ import annotations

import sys

import click

from lwr_dyn.checks.report import check_arm
from lwr_dyn.checks.verdict import Report
from lwr_dyn.cli.options import load_robot_and_paper, print_json, robot_options
from lwr_dyn.tables import aligned


@click.command("check")
@robot_options
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(robot: str, reading: str | None, tip: str | None, locks: tuple[str, ...], as_json: bool) -> None:
    """Check a model: identities of the equations of motion, agreement of engines, feasibility; exit 1 if one fails."""
    report = check_arm(*load_robot_and_paper(robot, reading, tip, locks))
    if as_json:
        _print_json(report)
    else:
        _print_table(report)
    sys.exit(0 if report.holds else 1)


def _print_json(report: Report) -> None:
    rows = [
        {"name": v.name, "value": v.value, "bound": v.bound, "tolerance": v.tolerance, "unit": v.unit, "holds": v.holds}
        for v in report.verdicts
    ]
    record = {"robot": report.robot, "reading": report.reading, "holds": report.holds}
    print_json({**record, "verdicts": rows, "notes": list(report.notes)})


def _print_table(report: Report) -> None:
    rows = [(v.name, f"{v.value:.3g}", f"{v.bound} {v.tolerance:.3g}", v.unit, v.word) for v in report.verdicts]
    click.echo(f"{report.robot}, reading {report.reading}")
    click.echo(aligned(rows, ("check", "value", "allowed", "unit", "verdict")))
    for note in report.notes:
        click.echo(f"note: {note}")
    failed = sum(not v.holds for v in report.verdicts)
    click.echo(f"{len(rows) - failed} hold, {failed} fail")
