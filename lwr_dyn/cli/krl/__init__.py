"""`lwr-dyn krl`: one file a subcommand and one row in `SUBCOMMANDS` here; each is imported when it is used.

check    `lwr-dyn krl check`: the diagnostics of a program
diff     `lwr-dyn krl diff`: what two states of a program or a backup differ in
format   `lwr-dyn krl format`: files with their layout in order
options  The options that `krl check` and `krl run` share; `lwr-dyn new cell`, a commented cell file to start from
run      `lwr-dyn krl run`: cycle time, motions, speeds and torques of a program, as text and as one JSON object
server   `lwr-dyn krl server`: a language server for editors
write    `lwr-dyn krl write`: a program from a task file of points, a run, or a table of poses or axes
"""

import click

from lwr_dyn.cli.main import RegistryGroup
from lwr_dyn.foundation.registry import Registry, Row

_ABOUT = {
    "write:write": "A program from points, a run or a path; S and T are solved.",
    "check:check": "What is wrong or doubtful in a program; exit 1 on errors.",
    "run:run": "Run a program on a model: cycle time, motions, speeds, torques.",
    "diff:diff": "What two programs or backups differ in: points, values, logic.",
    "format:format_files": "Layout of files in order; what they mean stays.",
    "server:server": "A language server for editors.",
}
SUBCOMMANDS: Registry[click.Command] = Registry(
    "krl_command",
    {target.partition(":")[0]: Row(f"lwr_dyn.cli.krl.{target}", text, "krl") for target, text in _ABOUT.items()},
)


@click.group("krl", cls=RegistryGroup, registry=SUBCOMMANDS)
def command() -> None:
    """KUKA Robot Language: write a program, check it, run it on a robot's model."""
