"""`lwr-dyn check`: every check of one robot's model and file; exit 1 when one fails."""

import sys
from typing import Any

import click

from lwr_dyn.arms.loading import xacro_arguments
from lwr_dyn.checks.arm.run_checks import CheckReport, check_arm
from lwr_dyn.checks.urdf.document import UrdfRecord
from lwr_dyn.cli.options import Loading, robot_options, show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import UrdfError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.progress import progress


@click.command("check")
@robot_options
@with_shared("--json as_json")
def command(robot: str, loading: Loading, as_json: bool) -> None:
    """Check a model: identities of the equations of motion, agreement of engines, feasibility; exit 1 if one fails.

    Of a .urdf or .xacro first each link, joint and shape as written (`lwr-dyn lint`), of any tree.
    """
    loaded, fault = None, None
    try:
        loaded = loading.arm_and_paper(robot)
    except UrdfError as refused:
        fault = refused
    written = None
    if ends_in(robot, ".urdf", ".xacro"):
        from lwr_dyn.checks.urdf.lint import lint_file  # not for a robot from a table

        given = xacro_arguments(loading.further["xacro_args"] or ())
        written = lint_file(robot, xacro_args=given, trust_xacro=loading.further["trust_xacro"])
    left: list[str] = []
    if not as_json and written:
        from lwr_dyn.checks.urdf.reports import report_text

        click.echo(report_text(written))
    if fault is not None:
        # a tree in which no chain is chosen, or whose chain moves as no arm does
        tree = fault.element in ("tip", "chain") or (fault.element.startswith("joint ") and "<" not in fault.element)
        if loading.tip is not None or loading.locks or written is None or not (tree or not written.holds()):
            raise fault
        left.append(f"laws and roads skipped: {fault}")
    with progress(f"checking {robot}"):
        report = None if loaded is None else check_arm(*loaded)
    holds = (written is None or written.holds()) and (report is None or report.holds)
    show(_document(report, robot, written, left, holds), as_json)
    sys.exit(0 if holds else 1)


def _document(report: CheckReport | None, robot: str, written: Any, left: list[str], holds: bool) -> Document:
    """The checks, and what stands in the file; without a report the file alone was judged."""
    found = CheckReport(robot, "", ()) if report is None else report
    as_written = "" if written is None or written.holds() else "; the file as written fails"
    further = f". Next: lwr-dyn urdf {robot} --out arm.urdf" if found.holds and written is None else ""
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
    records = [] if written is None else [x.record() for x in written.findings]
    findings = Fact("findings", records, "Faults of a URDF, each with its place.", kind=list[UrdfRecord])
    of_file = Section("", [findings], there=written is not None)
    return Document("", "", [checks, of_file], "lwr-dyn check", facts=facts, caveats=())
