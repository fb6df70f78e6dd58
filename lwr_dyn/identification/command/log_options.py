"""What the subcommands of `lwr-dyn identify` share: options of logs, logs from files, faults and the exit code."""

import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import click

from lwr_dyn.errors import LwrDynError
from lwr_dyn.identification.logs.joint_log import JointLog, read_log
from lwr_dyn.model.arm import Arm

F = TypeVar("F", bound=Callable[..., Any])


def log_options(command: F) -> F:
    """LOG..., --reading, --units and --json."""
    for option in (
        click.option("--json", "as_json", is_flag=True, help="One JSON object."),
        click.option("--units", help="Units of columns that declare none, such as time=ms,q=deg,tau=mN m."),
        click.option("--reading", help="Reading of --robot; its default if not given."),
        click.argument("logs", nargs=-1, required=True, metavar="LOG..."),
    ):
        command = option(command)
    return command


def readable_logs(
    paths: Iterable[str], units: Mapping[str, str], arm: Arm | None
) -> tuple[list[JointLog], list[LwrDynError]]:
    """The logs of the files that can be used, and a fault for each other one."""
    usable: list[JointLog] = []
    faults: list[LwrDynError] = []
    for path in paths:
        try:
            usable.append(read_log(path, units, arm))
        except LwrDynError as fault:
            faults.append(fault)
    return usable, faults


def warn(lines: Iterable[str]) -> None:
    """A line each on the error stream."""
    for line in lines:
        click.echo(f"lwr-dyn: warning: {' '.join(line.split())}", err=True)


def end(faults: Iterable[LwrDynError]) -> None:
    """Exit 0, or 2 with a line on the error stream for each fault."""
    several = list(faults)
    for fault in several:
        click.echo(f"lwr-dyn: {' '.join(str(fault).split())}", err=True)
    sys.exit(2 if several else 0)
