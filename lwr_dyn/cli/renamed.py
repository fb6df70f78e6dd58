"""Options that had another name: an old one is answered with the new one, for this version."""

from collections.abc import Mapping

import click

from lwr_dyn.cli.help_text import command_path

_EFFORT = {"--effort-share": "--torque-share"}


def _of_logs(name: str) -> dict[str, str]:
    return {"--robot": f"the first argument: lwr-dyn identify {name} ROBOT LOG..."}


RENAMED: Mapping[str, Mapping[str, str]] = {
    "compare": {"--friction": "--friction-share", "--processes": "--jobs", "--save": "--out", **_EFFORT},
    "excite": {"--speed": "--joint-speed"},
    "identify elastic": _of_logs("elastic"),
    "identify friction": _of_logs("friction"),
    "identify motion": {"--friction": "--fit-friction", **_of_logs("motion")},
    "identify payload": {"--friction": "--fit-friction", **_of_logs("payload")},
    "identify table": _of_logs("table"),
    "kernels": {"--friction": "--own-friction, without a value"},
    "krl write": {
        "--angle-tolerance": "--angle-tolerance-deg", "--base": "--base-data", "--tolerance": "--tolerance-mm",
    },
    "margins": _EFFORT,
    "parity": {"--engine": "--only"},
    "replay": {"--beside": "--side-by-side"},
    "simulate": _EFFORT,
    "sweep": {"--threads": "--jobs"},
    "tune": {"--check": "--check-runs", "--controller": "--law", "--threads": "--jobs"},
}  # fmt: skip
"""Command path -> old option -> what takes its place."""


def new_name(fault: click.ClickException) -> str | None:
    """The answer to an option that the command had once: what its name is now; None for any other fault."""
    if not isinstance(fault, click.NoSuchOption) or fault.ctx is None:
        return None
    now = RENAMED.get(command_path(fault.ctx), {}).get(fault.option_name)
    return None if now is None else f"{fault.option_name} is now {now}"
