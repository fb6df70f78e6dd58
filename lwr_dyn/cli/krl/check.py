"""`lwr-dyn krl check`: the diagnostics of a program."""

import sys
from collections.abc import Iterable
from pathlib import Path

import click

from lwr_dyn.cli.krl.options import SharedOptions, shared_options
from lwr_dyn.cli.options import print_json
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.progress import progress
from lwr_dyn.foundation.tables import aligned
from lwr_dyn.krl.checks.static_checks import check_project, totals
from lwr_dyn.krl.diagnostics import Diagnostic, has_no_error, summary
from lwr_dyn.krl.names.known_names import known_names
from lwr_dyn.krl.project.program import load_project
from lwr_dyn.krl.running.program_run import check_program


@click.command("check")
@click.argument("file")
@shared_options
@click.option("--no-motion", is_flag=True, help="Language and types only.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
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
    with progress(f"checking {file}"):
        arm = None if no_motion else shared.arm(program)
        machine = None if arm is None else shared.machine(arm)
        diagnostics = check_program(program, arm, machine, shared.inputs, shared.cell)
    if as_json:
        print_json({"file": file, "holds": has_no_error(diagnostics), "diagnoses": [d.to_json() for d in diagnostics]})
    else:
        _print_all(Path(file).parent, diagnostics)
        click.echo(f"{file}: {summary(diagnostics)}")
    sys.exit(0 if has_no_error(diagnostics) else 1)


def _check_folder(folder: str, names: tuple[str, ...], as_json: bool) -> None:
    with progress(f"checking {folder}"):
        files = check_project(load_project(folder).with_known(known_names(names)))
    diagnostics = [d for x in files for d in x.diagnostics]
    numbers = totals(files)
    if as_json:
        of_files = [{"file": x.name, "lines": x.lines, **x.counts} for x in files]
        record = {"file": folder, "holds": has_no_error(diagnostics), "files": of_files, "totals": numbers}
        print_json({**record, "diagnoses": [d.to_json() for d in diagnostics]})
    else:
        _print_all(Path(folder), diagnostics)
        rows = [(x.name, *map(str, x.counts.values())) for x in files if x.diagnostics]
        if rows:
            click.echo(aligned(rows, ("file", *files[0].counts)))
        counts = "{files} files, {lines} lines; {without_error} of {programs} programs without an error"
        click.echo(f"{folder}: {summary(diagnostics)}; {counts.format(**numbers)}")
    sys.exit(0 if has_no_error(diagnostics) else 1)


def _print_all(folder: Path, diagnostics: Iterable[Diagnostic]) -> None:
    """Each with a position that editors and terminals can open."""
    for diagnostic in diagnostics:
        click.echo(f"{folder}/{diagnostic}" if folder != Path() else str(diagnostic))
