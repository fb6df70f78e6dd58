"""`lwr-dyn krl check`: the diagnostics of a program."""

import sys
from pathlib import Path

import click

from lwr_dyn.cli.options import print_json
from lwr_dyn.front import load
from lwr_dyn.krl.command.options import shared_options
from lwr_dyn.krl.diagnostics import has_no_error, summary
from lwr_dyn.krl.project.program import load_program
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.evaluate import input_values
from lwr_dyn.krl.running.run import check_program
from lwr_dyn.progress import progress


@click.command("check")
@click.argument("file")
@shared_options
@click.option("--no-motion", is_flag=True, help="Language and types only.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def check(file: str, robot: str, included: tuple[str, ...], settings: tuple[str, ...], ramp: float, steps: int,
          seconds: float, no_motion: bool, as_json: bool) -> None:  # fmt: skip
    """Diagnose FILE.src with the .dat beside it; exit 1 when there is an error."""
    program = load_program(file, included)
    machine = MachineData(ramp=ramp, steps=steps, seconds=seconds)
    with progress(f"checking {file}"):
        diagnostics = check_program(program, None if no_motion else load(robot), machine, input_values(settings))
    if as_json:
        print_json({"file": file, "holds": has_no_error(diagnostics), "diagnoses": [d.to_json() for d in diagnostics]})
    else:
        folder = Path(file).parent
        for diagnostic in diagnostics:  # a position that editors and terminals can open
            click.echo(f"{folder}/{diagnostic}" if folder != Path() else str(diagnostic))
        click.echo(f"{file}: {summary(diagnostics)}")
    sys.exit(0 if has_no_error(diagnostics) else 1)
