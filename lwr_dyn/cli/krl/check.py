"""`lwr-dyn krl check`: the diagnostics of a program."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, TypedDict

import click

from lwr_dyn.cli.krl.options import SharedOptions, shared_options
from lwr_dyn.cli.options import show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.document import Document, Fact, Note, Part, Section
from lwr_dyn.foundation.errors import OptionError, PaperError
from lwr_dyn.foundation.progress import progress
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.krl.checks.static_checks import CheckedFile, check_project, totals
from lwr_dyn.krl.diagnostics import Diagnostic, DiagnosticRecord, SourcePosition, has_no_error, summary
from lwr_dyn.krl.names.known_names import known_names
from lwr_dyn.krl.project.program import load_project
from lwr_dyn.krl.running.program_run import check_program


@click.command("check")
@click.argument("file")
@shared_options
@click.option("--no-motion", is_flag=True, help="Language and types only.")
@with_shared("--json as_json")
def check(file: str, shared: SharedOptions, no_motion: bool, as_json: bool) -> None:
    """Diagnose FILE.src with the .dat beside it, or each file of a FOLDER; exit 1 when there is an error.

    The files of a folder, such as a backup, see one another's names as on a controller; their motions are not planned.
    """
    if Path(file).is_dir():
        if shared.included:
            raise OptionError("--with", "given with a folder", "nothing: a folder lends its own files")
        _check_folder(file, shared.names, as_json)
        return
    program = shared.program(file)
    unplanned: list[Diagnostic] = []
    with progress(f"checking {file}"):
        try:
            arm = None if no_motion else shared.arm(program, None)
        except PaperError as fault:
            if shared.names_robot:
                raise
            # the robot of a backup may be of another kind, such as a palletizer: its programs are KRL all the same
            arm, hint = None, "the language is; --robot or a cell file names another robot"
            position = SourcePosition(program.source.name, 1)
            unplanned += [Diagnostic(position, "note", "not-modelled", f"motions are not checked: {fault}", hint)]
        machine = None if arm is None else shared.machine(arm)
        diagnostics = (*unplanned, *check_program(program, arm, machine, shared.inputs, shared.cell))
    folder, whole = Path(file).parent, f"{file}: {summary(diagnostics)}"
    show(_document(file, folder, diagnostics, (), [Note(whole)]), as_json)
    sys.exit(0 if has_no_error(diagnostics) else 1)


def _check_folder(folder: str, names: tuple[str, ...], as_json: bool) -> None:
    with progress(f"checking {folder}"):
        files = check_project(load_project(folder).with_known(known_names(names)))
    diagnostics = [d for x in files for d in x.diagnostics]
    numbers = totals(files)
    counts = "{files} files, {lines} lines; {without_error} of {programs} programs without an error"
    rows = [(x.name, *x.counts.values()) for x in files if x.diagnostics]
    more: list[Part] = [
        Table("", [Heading("file"), *map(Heading, files[0].counts)], rows),
        Note(f"{folder}: {summary(diagnostics)}; {counts.format(**numbers)}"),
    ]
    show(_document(folder, Path(folder), diagnostics, files, more), as_json)
    sys.exit(0 if has_no_error(diagnostics) else 1)


class CheckedFileRecord(TypedDict):
    """A file of a folder with its counts."""

    file: str
    lines: int
    errors: int
    warnings: int
    notes: int


class TotalsRecord(TypedDict):
    """`totals`."""

    files: int
    lines: int
    programs: Annotated[int, "Files that are .src or .sub."]
    without_error: Annotated[int, "Programs of which no error is known."]
    errors: int
    warnings: int
    notes: int


def _document(
    file: str, folder: Path, found: Sequence[Diagnostic], files: Sequence[CheckedFile], more: Sequence[Part]
) -> Document:
    """A program or a folder; each diagnostic with a position that editors and terminals can open."""
    facts = [
        Fact("file", file, "The program or the folder."),
        Fact("holds", has_no_error(found), "Whether it holds; the exit code is 0 then."),
        Fact("diagnoses", [d.to_json() for d in found], "In the order of the lines.", kind=list[DiagnosticRecord]),
    ]  # fmt: skip
    of_folder = Section("", [
        Fact("files", [{"file": x.name, "lines": x.lines, **x.counts} for x in files],
             "Of a folder: each file with its counts.", kind=list[CheckedFileRecord]),
        Fact("totals", totals(files), "Of a folder; programs are .src and .sub files.", kind=TotalsRecord),
    ], there=bool(files))  # fmt: skip
    lines = [f"{folder}/{one}" if folder != Path() else str(one) for one in found]
    return Document("", "", [Section("", [Note(lines), *more]), of_folder], "lwr-dyn krl check", facts=facts)
