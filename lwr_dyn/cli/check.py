"""`lwr-dyn check`: every check of one robot's model and file; exit 1 when one fails."""

import sys
from typing import Any

import click

from lwr_dyn.checks.arm.run_checks import check_arm
from lwr_dyn.checks.arm.verdict import CheckReport, FileVerdict
from lwr_dyn.checks.urdf.reports import file_verdict
from lwr_dyn.cli.options import given_xacro_args, load_robot_and_paper, print_json, robot_options
from lwr_dyn.foundation.errors import UrdfError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.progress import progress


@click.command("check")
@robot_options
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(robot: str, reading: str | None, tip: str | None, locks: tuple[str, ...], as_json: bool) -> None:
    """Check a model: identities of the equations of motion, agreement of engines, feasibility; exit 1 if one fails.

    Of a .urdf or .xacro first each link, joint and shape as written (`lwr-dyn lint`), of any tree.
    """
    loaded, fault = None, None
    try:
        loaded = load_robot_and_paper(robot, reading, tip, locks)
    except UrdfError as refused:
        fault = refused
    written = [file_verdict(robot, given_xacro_args())] if ends_in(robot, ".urdf", ".xacro") else []
    left: list[str] = []
    if not as_json and written:
        click.echo(written[0].text)
    if fault is not None:
        judged = written and (_wants_a_chain(fault) or not all(part.holds for part in written))
        if tip is not None or locks or not judged:
            raise fault
        left.append(f"laws and roads skipped: {fault}")
    with progress(f"checking {robot}"):
        report = None if loaded is None else check_arm(*loaded)
    holds = all(part.holds for part in written) and (report is None or report.holds)
    if as_json:
        print_json(_record(report, robot, written, left) | {"holds": holds})
    else:
        click.echo(left[-1]) if report is None else _print_table(report, robot, written)
    sys.exit(0 if holds else 1)


def _wants_a_chain(fault: UrdfError) -> bool:
    """Whether the file is a tree in which no chain is chosen, or whose chain moves as no arm does."""
    return fault.element in ("tip", "chain") or (fault.element.startswith("joint ") and "<" not in fault.element)


def _record(report: CheckReport | None, robot: str, written: list[FileVerdict], left: list[str]) -> dict[str, Any]:
    record: dict[str, Any] = {"robot": robot, "reading": None, "verdicts": [], "not_judged": [], "notes": left}
    if report is not None:
        record |= {"robot": report.robot, "reading": report.reading, "verdicts": report.table().record()}
        record |= {"not_judged": list(report.not_judged), "notes": [*left, *report.notes]}
    return record | ({"findings": [x for part in written for x in part.records]} if written else {})


def _print_table(report: CheckReport, robot: str, written: list[FileVerdict]) -> None:
    click.echo(report.table().text())
    for line in report.not_judged:
        click.echo(f"not judged: {line}")
    for note in report.notes:
        click.echo(f"note: {note}")
    as_written = "" if all(part.holds for part in written) else "; the file as written fails"
    further = (
        f". Next: lwr-dyn urdf {robot} --out arm.urdf" if report.holds and not ends_in(robot, ".urdf", ".xacro") else ""
    )
    click.echo(report.summary() + as_written + further)
