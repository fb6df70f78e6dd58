"""The group `lwr-dyn krl`: a new subcommand is one file here and one row in it; each is imported when it is used."""

import click

from lwr_dyn.cli.main import RegistryGroup
from lwr_dyn.foundation.registry import Registry, Row

_ABOUT = {
    "write:write": "A program from points, a run or a path; S and T are solved.",
    "check:check": "What is wrong or doubtful in a program; exit 1 on errors.",
    "run:run": "Run a program on a model: cycle time, motions, speeds, torques.",
    "diff:diff": "What two programs or backups differ in: points, values, logic.",
    "format:format_files": "Layout of files in order; what they mean stays.",
}
SUBCOMMANDS: Registry[click.Command] = Registry(
    "krl_command",
    {target.partition(":")[0]: Row(f"lwr_dyn.cli.krl.{target}", text, "krl") for target, text in _ABOUT.items()}
    | {"server": Row("lwr_dyn.cli.lsp:command", "A language server for editors: lwr-dyn lsp.", "krl")},
)


@click.group("krl", cls=RegistryGroup, registry=SUBCOMMANDS)
def command() -> None:
    """KUKA Robot Language: write a program, check it, run it on a robot's model."""
