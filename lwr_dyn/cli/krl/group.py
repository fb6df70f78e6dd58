"""The group `lwr-dyn krl`: a new subcommand is one file here and one row in it; each is imported when it is used."""

import click

from lwr_dyn.cli.main import RegistryGroup
from lwr_dyn.foundation.registry import Registry, Row

SUBCOMMANDS: Registry[click.Command] = Registry(
    "krl_command",
    {
        "write": Row(
            "lwr_dyn.cli.krl.write:write", "A program from points, a run or a path; S and T are solved.", extra="krl"
        ),
        "check": Row(
            "lwr_dyn.cli.krl.check:check", "What is wrong or doubtful in a program; exit 1 on errors.", extra="krl"
        ),
        "run": Row(
            "lwr_dyn.cli.krl.run:run", "Run a program on a model: cycle time, motions, speeds, torques.", extra="krl"
        ),
        "diff": Row(
            "lwr_dyn.cli.krl.diff:diff", "What two programs or backups differ in: points, values, logic.", extra="krl"
        ),
        "format": Row(
            "lwr_dyn.cli.krl.format:format_files", "Layout of files in order; what they mean stays.", extra="krl"
        ),
        "server": Row("lwr_dyn.cli.krl.server:server", "A language server for editors.", extra="krl"),
    },
)


@click.group("krl", cls=RegistryGroup, registry=SUBCOMMANDS)
def command() -> None:
    """KUKA Robot Language: write a program, check it, run it on a robot's model."""
