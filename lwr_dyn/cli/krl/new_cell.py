"""`lwr-dyn new cell`: a commented cell file to start from."""

import click

from lwr_dyn.cli.new import new_file
from lwr_dyn.foundation.files import write_file
from lwr_dyn.krl.running.cell_file import new_cell_text


@click.command("cell")
@click.argument("file")
def command(file: str) -> None:
    """Write a cell file: the robot, inputs, states, tools, stubs; `krl check` and `krl run` take it with --cell."""
    path = new_file(file, ".toml")
    write_file(path, new_cell_text(file))
    click.echo(f"wrote {file}; next: edit it, then  lwr-dyn krl run PROGRAM.src --cell {file}")
