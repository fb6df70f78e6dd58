"""`lwr-dyn check`: every check of one robot's model; exit 1 when one fails."""

import sys

import click

from lwr_dyn.checks.run_checks import check_arm
from lwr_dyn.checks.verdict import CheckReport
from lwr_dyn.cli.options import load_robot_and_paper, print_json, robot_options


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


def _print_json(report: CheckReport) -> None:
    record = {"robot": report.robot, "reading": report.reading, "holds": report.holds}
    print_json(
        {
            **record,
            "verdicts": report.table().record(),
            "not_judged": list(report.not_judged),
            "notes": list(report.notes),
        }
    )


def _print_table(report: CheckReport) -> None:
    click.echo(report.table().text())
    for line in report.not_judged:
        click.echo(f"not judged: {line}")
    for note in report.notes:
        click.echo(f"note: {note}")
    click.echo(report.summary())
