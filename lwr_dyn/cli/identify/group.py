"""`lwr-dyn identify`: parameters of an arm from its logs."""

import click

from lwr_dyn.cli.identify import elastic, friction, motion, payload, table
from lwr_dyn.cli.main import NamedGroup

SUBCOMMANDS = (friction.command, motion.command, payload.command, elastic.command, table.command)


@click.group("identify", cls=NamedGroup)
def command() -> None:
    """Parameters of an arm from its logs (.csv, .parquet, ROS 2 bags, runs of simulate in .npz).

    Columns: time, q1.., tau1.., and dq1.. where measured, each with its unit in brackets (q1 [deg]) or in SI;
    --columns maps other names; further columns are ignored. Exit 2 when a file or joint could not be used; the others
    are reported all the same.
    """


for each in SUBCOMMANDS:
    command.add_command(each)
