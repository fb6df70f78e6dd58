"""What `--help` shows: commands and options in groups, limits of files, examples; and all options with `--help-all`.

`help.toml` has what click does not know. A command with many options shows in full those that most people need
(`short`), and the names of the others.
"""

import tomllib
from collections.abc import Iterable, Mapping
from functools import cache, partial
from importlib.resources import files
from importlib.resources.abc import Traversable
from textwrap import fill
from typing import Any

import click

ROBOT = "Robot, mount and tool"
"""Heading of the options that load a robot; the last one."""

ROBOT_OPTIONS = (
    "--robot", "--reading", "--tip", "--lock", "--mount", "--tool", "--rotor", "--xacro-arg", "--trust-xacro",
)  # fmt: skip

FEW = 6
"""A command with no more options than this has them in one list."""

FURTHER = "Further commands"
"""Heading of commands that other packages add."""

HELP_ALL = "--help-all"


@cache
def help_texts() -> dict[str, Any]:
    """By command path, such as "krl check": `examples`, with their exit codes, `groups`, `short`, `limits` in words.

    A group of options is a heading and the option with which it begins; it ends where the next one begins, so the
    options of a controller or a task stand in its group, whoever adds them. A group of commands (`commands`) is a
    heading and their names.
    """
    return tomllib.loads((files("lwr_dyn.cli") / "help.toml").read_text(encoding="utf-8"))


def command_path(ctx: click.Context, *more: str) -> str:
    """Path of a command without the program's name, such as "krl check"."""
    return " ".join([*ctx.command_path.split()[1:], *more])


def schema_file(path: str) -> Traversable:
    """The JSON Schema of what a command, such as "krl check", prints with --json."""
    return files("lwr_dyn.cli") / "schemas" / f"{path.replace(' ', '-')}.json"


def grouped(path: str, names: Iterable[str]) -> Mapping[str, list[str]]:
    """Heading -> the commands under it; those that no heading names come last."""
    groups = help_texts().get(path, {}).get("commands", {})
    there = list(names)
    out = {heading: [name for name in listed if name in there] for heading, listed in groups.items()}
    out[FURTHER if groups else "Commands"] = [name for name in there if not any(name in x for x in groups.values())]
    return {heading: listed for heading, listed in out.items() if listed}


def with_help(command: click.Command, path: str) -> click.Command:
    """The same command of any package, whose help shows groups and examples; `path` as of `command_path`."""
    if not isinstance(command, click.Group):
        command.format_options = partial(_format_options, command)  # type: ignore[method-assign]
    if "short" in help_texts().get(path, {}) and not any(HELP_ALL in param.opts for param in command.params):
        words = "This help, with a sentence on every option."
        command.params.append(click.Option(
            [HELP_ALL], is_flag=True, is_eager=True, expose_value=False, callback=_show_all, help=words
        ))  # fmt: skip
    command.format_epilog = partial(_format_examples, command)  # type: ignore[method-assign]
    return command


def _show_all(ctx: click.Context, _: click.Parameter, is_asked: bool) -> None:
    if is_asked:
        ctx.meta[HELP_ALL] = True
        click.echo(ctx.get_help(), color=ctx.color)
        ctx.exit()


def _format_options(command: click.Command, ctx: click.Context, formatter: click.HelpFormatter) -> None:
    text = help_texts().get(command_path(ctx), {})
    options = [param for param in command.get_params(ctx) if isinstance(param, click.Option) and not param.hidden]
    starts = {option: heading for heading, option in text.get("groups", {}).items()}
    groups: dict[str, list[click.Option]] = {heading: [] for heading in ("Options", *starts.values(), ROBOT)}
    heading = "Options"
    for option in options:
        heading = starts.get(option.opts[0], heading)
        groups[ROBOT if len(options) > FEW and option.opts[0] in ROBOT_OPTIONS else heading].append(option)
    if "short" in text and HELP_ALL not in ctx.meta:
        shown = [option for option in options if option.opts[0] in (*text["short"], HELP_ALL)]
        _write(formatter, "Options", shown, ctx)
        _write_names(formatter, groups, shown)
    else:
        for title, each in groups.items():
            _write(formatter, title, each, ctx)


def _write(formatter: click.HelpFormatter, title: str, options: Iterable[click.Option], ctx: click.Context) -> None:
    """A group of options in full."""
    records = [record for option in options if (record := option.get_help_record(ctx)) is not None]
    if records:
        with formatter.section(title):
            formatter.write_dl(records)


def _write_names(
    formatter: click.HelpFormatter, groups: Mapping[str, list[click.Option]], shown: Iterable[click.Option]
) -> None:
    """The names of all other options, group by group."""
    left = {
        title: [x.opts[0] for x in each if x not in shown and "--help" not in x.opts] for title, each in groups.items()
    }
    with formatter.section(f"More options ({HELP_ALL} explains them)"):
        for title, names in left.items():
            if names:
                indent = " " * formatter.current_indent
                text = f"{indent}{title}: {' '.join(names)}"
                wrapped = fill(text, formatter.width, subsequent_indent=f"{indent}  ", break_on_hyphens=False)
                formatter.write(f"{wrapped}\n")


def _format_examples(command: click.Command, ctx: click.Context, formatter: click.HelpFormatter) -> None:
    path = command_path(ctx)
    type(command).format_epilog(command, ctx, formatter)
    texts, schema = help_texts().get(path, {}), schema_file(path)
    examples = texts.get("examples", ())
    if schema.is_file():
        formatter.write(f"\nSchema of --json: {schema}\n")
    if "limits" in texts:
        with formatter.section("Limits"):
            formatter.write_text(texts["limits"])
    if examples:
        with formatter.section("Examples" if len(examples) > 1 else "Example"):
            for example in examples:
                code = f"   # exit code {example['exit']}" if "exit" in example else ""
                formatter.write(f"{'':>{formatter.current_indent}}$ {example['run']}{code}\n")
