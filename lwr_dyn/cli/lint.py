"""`lwr-dyn lint`: faults in URDFs and in tables of numbers that show in the file.

Exit 1 for errors, for warnings in tables and, with `--strict`, in URDFs.
"""

import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click

from lwr_dyn.arms.loading import xacro_arguments
from lwr_dyn.arms.papers.catalog import robots
from lwr_dyn.checks.tables.robot_checks import holds_a_robot, robot_findings
from lwr_dyn.checks.tables.rules import LARGEST, lint, sheet_of_file, sheets_of_robot
from lwr_dyn.checks.tables.sheet import Finding, Sheet, SheetRecord
from lwr_dyn.checks.urdf.document import UrdfRecord
from lwr_dyn.checks.urdf.lint import explanation
from lwr_dyn.checks.urdf.reports import is_urdf, judge_all, print_reports
from lwr_dyn.cli.options import show, trust_option
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.document import Document, Fact, Section
from lwr_dyn.foundation.errors import FileAccessError, OptionError, UnknownNameError
from lwr_dyn.foundation.files import ends_in, read_text
from lwr_dyn.foundation.tables import log_line

_OF_URDFS = {
    "sarif": "--sarif",
    "github": "--github",
    "ignore": "--ignore",
    "strict": "--strict",
    "everything": "--all",
    "require_meshes": "--require-meshes",
    "xacro_args": "--xacro-arg",
    "trust_xacro": "--trust-xacro",
}


def _explain(context: click.Context, _: click.Parameter, code: str | None) -> None:
    """Print what a rule looks at, and end."""
    if code is not None:
        click.echo(explanation(code))
        context.exit()


@click.command("lint")
@click.argument("files", nargs=-1, required=True, metavar="FILE|FOLDER|ROBOT...")
@with_shared("--json as_json")
@click.option("--sarif", metavar="FILE", help="URDF: also write the findings as SARIF 2.1.0, for code scanning.")
@click.option("--github", is_flag=True, help="URDF: findings as annotations of GitHub's workflow log.")
@click.option("--ignore", multiple=True, metavar="CODE", help="URDF: leave out the findings of a rule.")
@click.option("--strict", is_flag=True, help="URDF: exit 1 on warnings too.")
@click.option("--require-meshes", is_flag=True, help="URDF: a mesh that is not there, or cannot be read, is an error.")
@click.option(
    "--xacro-arg", "xacro_args", multiple=True, metavar="NAME:=VALUE", help="Argument of a .xacro. Repeatable."
)
@trust_option
@click.option("--all", "everything", is_flag=True, help="URDF: print all findings of a group.")
@click.option(
    "--explain", metavar="CODE", callback=_explain, expose_value=False, is_eager=True,
    help="What a rule of URDFs looks at, and why; needs no file.",
)  # fmt: skip
def command(files: tuple[str, ...], as_json: bool, **of_urdfs: Any) -> None:
    """Find faults in URDF and xacro files, or in tables of numbers (.toml, .csv, a robot).

    Exit code 1 for an error, and for a warning in a table or, with --strict, in a URDF; 0 for notes; 2 for a file that
    cannot be read.

    In a URDF, each link, joint and shape as written: format, tree, limits, axes, units, masses, centres and inertias
    against the hulls of the shapes, efforts against weights. A comment `lwr-dyn: ignore CODE` before an element leaves
    out findings in it; before <robot>, in the whole file. A folder stands for the .urdf and .urdf.xacro files below it.
    No code of a .xacro runs: what its expressions hold beyond numbers, names and listed functions is refused.

    In tables: means outside their extremes, cells or columns exchanged, powers of ten, copied neighbours, shifted rows,
    sums that do not add up, tensors that are not symmetric, units of another quantity, arithmetic that is wrong. In
    a robot's data file also what `lwr-dyn check` refuses, and checks that fail.
    """
    urdfs = [name for name in files if is_urdf(name)]
    if not urdfs:
        for name in (name for name in _OF_URDFS if of_urdfs[name]):
            raise OptionError(_OF_URDFS[name], "would do nothing here", "with a .urdf, a .xacro or a folder of these")
    sheets = [sheet for name in dict.fromkeys(files) if name not in urdfs for sheet in _sheets(name)]
    findings = [finding for sheet in sheets for finding in lint(sheet)]
    arms = [name for name in dict.fromkeys(files) if name not in urdfs and _is_robot(name)]
    findings += [finding for name in arms for finding in robot_findings(name)]
    say, given = partial(click.echo, err=True), xacro_arguments(of_urdfs["xacro_args"])
    options = (of_urdfs[name] for name in ("trust_xacro", "require_meshes"))
    reports = judge_all(urdfs, of_urdfs["ignore"], of_urdfs["sarif"], say, given, *options)
    counted = [f for f in findings if f.counts]
    holds = not counted and all(report.holds(of_urdfs["strict"]) for report in reports)
    if as_json:
        records = [f.record() for f in findings] + [f.record() for report in reports for f in report.findings]
        show(_document(files, records, holds, {report.file: list(report.remarks) for report in reports}), as_json)
    else:
        print_reports(reports, of_urdfs["everything"], of_urdfs["github"])
        for finding in findings:
            click.echo(log_line(finding.line()))
        if sheets:
            click.echo(_summary(counted, len(findings) - len(counted), sheets))
    sys.exit(0 if holds else 1)


def _document(files: Sequence[str], records: list[Any], holds: bool, remarks: Mapping[str, list[str]]) -> Document:
    """For programs; people get each finding where it stands."""
    return Document("", "", [Section("", [
        Fact("files", list(files), "As given."),
        Fact("findings", records, "Faults, each with its place.", kind=list[SheetRecord | UrdfRecord]),
        Fact("holds", holds, "Whether it holds; the exit code is 0 then."),
    ]), Section("", [
        Fact("not_judged", remarks, "Of URDFs: file -> what no verdict is about, and why.", kind=dict[str, list[str]]),
    ], there=bool(remarks))], "lwr-dyn lint")  # fmt: skip


def _sheets(name: str) -> tuple[Sheet, ...]:
    """A file; or of a robot, its data file and the printed results of its paper."""
    if ends_in(name, ".xml"):
        raise FileAccessError(name, "MJCF, which has no rules here", f"`lwr-dyn check {name}`, or lint of its .urdf")
    if Path(name).suffix.lower() in (".toml", ".csv") or "/" in name:
        return (sheet_of_file(name),)
    if name not in robots():
        raise UnknownNameError("robot", name, (*robots(), "a path to a .urdf, .xacro, .toml or .csv file"))
    return sheets_of_robot(name)


def _is_robot(name: str) -> bool:
    """Whether a name on the command line is a robot, or a robot's data file."""
    if name in robots():
        return True
    return ends_in(name, ".toml") and holds_a_robot(read_text(name, "a .toml file", "utf-8-sig", LARGEST), name)


def _summary(counted: Sequence[Finding], notes: int, sheets: Sequence[Sheet]) -> str:
    """How many cells print a number (with none, nothing was examined), and what is wrong with them."""
    columns = [c for s in sheets for table in s.tables for c in (*table.columns, *table.values.values())]
    total = sum(n is not None for column in columns for n in column.numbers)
    known = sum(bool(f.known) for f in counted)
    errata = f", {known} of them known as errata" if known else ""
    return f"{total} numbers looked at: {len(counted)} found{errata}" + (
        f"; {notes} note{'s' * (notes > 1)}" if notes else ""
    )
