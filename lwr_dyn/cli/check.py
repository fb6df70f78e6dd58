"""`lwr-dyn check`: every check of one robot's model and file; exit 1 when one fails."""

import sys

import click

from lwr_dyn.checks.arm.run_checks import CheckReport, check_arm
from lwr_dyn.checks.urdf.document import UrdfRecord
from lwr_dyn.checks.urdf.lint import LintReport, lint_file
from lwr_dyn.checks.urdf.reports import report_text
from lwr_dyn.cli.options import given_xacro_args, load_robot_and_paper, robot_options, show
from lwr_dyn.foundation.document import Document, Fact, Note, Section
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
    written = [lint_file(robot, xacro_args=given_xacro_args())] if ends_in(robot, ".urdf", ".xacro") else []
    left: list[str] = []
    if not as_json and written:
        click.echo(report_text(written[0]))
    if fault is not None:
        judged = written and (_wants_a_chain(fault) or not all(part.holds() for part in written))
        if tip is not None or locks or not judged:
            raise fault
        left.append(f"laws and roads skipped: {fault}")
    with progress(f"checking {robot}"):
        report = None if loaded is None else check_arm(*loaded)
    holds = all(part.holds() for part in written) and (report is None or report.holds)
    show(_document(report, robot, written, left, holds), as_json)
    sys.exit(0 if holds else 1)


def _wants_a_chain(fault: UrdfError) -> bool:
    """Whether the file is a tree in which no chain is chosen, or whose chain moves as no arm does."""
    return fault.element in ("tip", "chain") or (fault.element.startswith("joint ") and "<" not in fault.element)


def _document(
    report: CheckReport | None, robot: str, written: list[LintReport], left: list[str], holds: bool
) -> Document:
    """The checks, and what stands in the file; without a report the file alone was judged."""
    found = CheckReport(robot, "", ()) if report is None else report
    urdf = ends_in(robot, ".urdf", ".xacro")
    as_written = "" if all(part.holds() for part in written) else "; the file as written fails"
    further = f". Next: lwr-dyn urdf {robot} --out arm.urdf" if found.holds and not urdf else ""
    facts = [
        Fact("robot", found.robot, "Name of the robot."),
        Fact("reading", found.reading if report else None, "Its reading; null of a file that is no arm.",
             kind=str | None),
    ]  # fmt: skip
    checks = Section("", [
        found.table(),
        Note(found.not_judged, key="not_judged", says="What no verdict is about, and why.", before="not judged: "),
        Note(left, key="notes"),
        Note(found.notes, key="notes", says="What could not be checked, and why.", before="note: "),
        Note(found.summary() + as_written + further, report is not None),
        Fact("holds", holds, "Whether all hold; the exit code is 0 then."),
    ])  # fmt: skip
    records = [x.record() for part in written for x in part.findings]
    findings = Fact("findings", records, "Faults of a URDF, each with its place.", kind=list[UrdfRecord])
    return Document("", "", [checks, Section("", [findings], there=bool(written))], "lwr-dyn check", facts=facts,
                    caveats=())  # fmt: skip
