"""Options that had another name: an old one is answered with the new one, for this version."""

from collections.abc import Mapping

import click

from lwr_dyn.cli.help_text import command_path

RENAMED: Mapping[str, Mapping[str, str]] = {
    "compare": {"--processes": "--jobs"},
    **{
        f"identify {name}": {"--robot": f"the first argument: lwr-dyn identify {name} ROBOT LOG..."}
        for name in ("elastic", "friction", "motion", "payload", "table")
    },
    "sweep": {"--threads": "--jobs"},
    "tune": {"--threads": "--jobs"},
}
"""Command path -> old option -> what takes its place."""


def new_name(fault: click.ClickException) -> str | None:
    """The answer to an option that the command had once: what its name is now; None for any other fault."""
    if not isinstance(fault, click.NoSuchOption) or fault.ctx is None:
        return None
    now = RENAMED.get(command_path(fault.ctx), {}).get(fault.option_name)
    return None if now is None else f"{fault.option_name} is now {now}"
