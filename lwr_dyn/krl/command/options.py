"""The options that `krl check` and `krl run` share."""

from typing import Any

import click

SHARED_OPTIONS = (
    click.option("--robot", default="kr30ha", show_default=True, help="A robot with KUKA's axes."),
    click.option("--with", "included", multiple=True, help="A file to include: $config.dat, another .src."),
    click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="An input or variable: $IN[3]=TRUE."),
    click.option("--ramp", default=0.4, show_default=True, help="Assumed: seconds to rated speed."),
    click.option("--steps", default=200_000, show_default=True, help="Statements executed at most."),
    click.option("--seconds", default=3600.0, show_default=True, help="Simulated time at most."),
)


def shared_options(command: Any) -> Any:
    """Add them to a subcommand."""
    for option in reversed(SHARED_OPTIONS):
        command = option(command)
    return command
