"""What `--help` shows beside click's own text: options in groups, limits of files, and examples, of `help.toml`."""

import tomllib
from functools import cache, partial
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

import click

from lwr_dyn.foundation.errors import LwrDynError, UnknownNameError

ROBOT = "Robot, mount and tool"
"""Heading of the options that load a robot; the last one."""
ROBOT_OPTIONS = ("--robot", "--reading", "--tip", "--lock", "--mount", "--tool", "--xacro-arg")
FEW = 6
"""A command with no more options than this has them in one list."""


@cache
def help_texts() -> dict[str, Any]:
    """By command path, such as "krl check": `examples`, with their exit codes, `groups`, and `limits` in words.

    A group is a heading and the option with which it begins; it ends where the next one begins, so the options of a
    controller or a task stand in its group, whoever adds them.
    """
    return tomllib.loads((files("lwr_dyn.cli") / "help.toml").read_text(encoding="utf-8"))


def with_help(command: click.Command) -> click.Command:
    """The same command of any package, whose help shows groups and examples."""
    if not isinstance(command, click.Group):
        command.format_options = partial(_format_options, command)  # type: ignore[method-assign]
    command.format_epilog = partial(_format_examples, command)  # type: ignore[method-assign]
    return command


class NamedGroup(click.Group):
    """A group of commands: a misspelt one is answered with the name that it resembles."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command; raises `UnknownNameError`, but not while a shell completes a line."""
        try:
            if cmd_name in self.list_commands(ctx):
                return with_help(self.found(ctx, cmd_name))
            raise UnknownNameError("command", cmd_name, self.list_commands(ctx))
        except LwrDynError:
            if ctx.resilient_parsing:
                return None
            raise

    def found(self, ctx: click.Context, name: str) -> click.Command:
        """A command of `list_commands`."""
        return self.commands[name]


def schema_file(path: str) -> Traversable:
    """The JSON Schema of what a command, such as "krl check", prints with --json."""
    return files("lwr_dyn.cli") / "schemas" / f"{path.replace(' ', '-')}.json"


def _path(ctx: click.Context) -> str:
    return " ".join(ctx.command_path.split()[1:])


def _format_options(command: click.Command, ctx: click.Context, formatter: click.HelpFormatter) -> None:
    options = [param for param in command.get_params(ctx) if isinstance(param, click.Option)]
    starts = {option: heading for heading, option in help_texts().get(_path(ctx), {}).get("groups", {}).items()}
    groups: dict[str, list[tuple[str, str]]] = {heading: [] for heading in ("Options", *starts.values(), ROBOT)}
    heading = "Options"
    for option in options:
        heading = starts.get(option.opts[0], heading)
        own = ROBOT if len(options) > FEW and option.opts[0] in ROBOT_OPTIONS else heading
        record = option.get_help_record(ctx)
        if record is not None:
            groups[own].append(record)
    for title, records in groups.items():
        if records:
            with formatter.section(title):
                formatter.write_dl(records)


def _format_examples(command: click.Command, ctx: click.Context, formatter: click.HelpFormatter) -> None:
    type(command).format_epilog(command, ctx, formatter)
    texts, schema = help_texts().get(_path(ctx), {}), schema_file(_path(ctx))
    examples = texts.get("examples", ())
    if schema.is_file():
        formatter.write(f"\nSchema of --json: {schema}\n")
    if "limits" in texts:
        with formatter.section("Limits"):
            formatter.write_text(texts["limits"])
    if examples:
        with formatter.section("Examples"):
            for example in examples:
                code = f"   # exit code {example['exit']}" if "exit" in example else ""
                formatter.write(f"{'':>{formatter.current_indent}}$ {example['run']}{code}\n")
