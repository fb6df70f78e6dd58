"""What `lwr-dyn lint` does with URDFs: the files of folders, the reports, their outputs."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import click

from lwr_dyn.checks.urdf.lint import LintReport, lint_file
from lwr_dyn.checks.urdf.report_text import report_text, summary
from lwr_dyn.checks.urdf.sarif import annotations, sarif_record
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.foundation.files import check_writable, ends_in, write_file
from lwr_dyn.foundation.tables import json_text

ENDINGS = (".urdf", ".xacro")
IN_FOLDERS = ("*.urdf", "*.urdf.xacro")
"""Names that are looked for in folders; other `.xacro` files are macros without a robot."""


def is_urdf(name: str) -> bool:
    """Whether a name on the command line is a URDF, a xacro or a folder of these."""
    return ends_in(name, *ENDINGS) or ("\0" not in name and Path(name).is_dir())


def urdf_files(names: Iterable[str]) -> Iterator[str]:
    """The files that are meant: of a folder, all below it, in order.

    Raises
    ------
    OptionError
        A folder without a URDF.
    """
    for name in names:
        if not Path(name).is_dir():
            yield name
            continue
        found = sorted(str(path) for pattern in IN_FOLDERS for path in Path(name).rglob(pattern) if path.is_file())
        if not found:
            raise OptionError(name, "no .urdf or .urdf.xacro file below it", "a folder with some")
        yield from found


def judge_all(
    names: Sequence[str],
    ignore: Collection[str],
    sarif: str | None,
    say: Callable[[str], None],
    xacro_args: Mapping[str, str] | None = None,
) -> tuple[LintReport, ...]:
    """The reports of all files; writes them as SARIF.

    A xacro in a folder is passed over, with one line, where xacro is not installed.

    Raises
    ------
    FileAccessError, MissingPackageError, OptionError, UnknownNameError
        A file that cannot be read or written, xacro is needed, an empty folder, a code that does not exist.
    """
    if sarif is not None:
        check_writable(sarif)
    reports = []
    for file in dict.fromkeys(urdf_files(names)):
        try:
            reports.append(lint_file(file, ignore, xacro_args))
        except MissingPackageError as fault:
            if file in names:
                raise
            say(f"{file} passed over: {fault}")
    if sarif is not None:
        write_file(sarif, json_text(sarif_record(reports)) + "\n")
    return tuple(reports)


def print_reports(reports: Sequence[LintReport], everything: bool, github: bool) -> None:
    """The reports as text, or as annotations of GitHub's workflow log."""
    if github:
        for line in annotations(reports):
            click.echo(line)
    else:
        for report in reports:
            click.echo(report_text(report, everything))
    if github or len(reports) > 1:
        click.echo(summary(reports))
