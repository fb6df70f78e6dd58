"""The group `lwr-dyn krl`: a new subcommand is one file here and one row in it."""

import click

from lwr_dyn.cli.help_text import NamedGroup
from lwr_dyn.krl.command.check import check
from lwr_dyn.krl.command.run import run
from lwr_dyn.krl.command.write import write


@click.group("krl", cls=NamedGroup)
def command() -> None:
    """KUKA Robot Language: write a program, check it, run it on a robot's model."""


for subcommand in (write, check, run):
    command.add_command(subcommand)
