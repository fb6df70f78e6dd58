"""The command line as Markdown, made from click."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import click
from used_in import used_in

from lwr_dyn.cli.help_text import HELP_ALL, help_texts, with_help
from lwr_dyn.cli.main import COMMANDS, group

PAGE = "docs/reference/command_line.md"


def commands_text(root: Path) -> str:
    """A section for each command: usage, what it does, options, examples, where it is used."""
    context = click.Context(group, info_name="lwr-dyn")
    context.meta[HELP_ALL] = True
    parts = []
    for name in COMMANDS.names:
        for path, command, inner in walk(name, with_help(COMMANDS.load(name), name), context):
            parts.append(section(path, command, inner, root))
    return "\n\n".join(parts)


def walk(
    path: str, command: click.Command, parent: click.Context
) -> Iterator[tuple[str, click.Command, click.Context]]:
    """A command and all below it."""
    context = click.Context(command, info_name=path.split()[-1], parent=parent)
    yield path, command, context
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            if below is not None:
                yield from walk(f"{path} {name}", below, context)


def section(path: str, command: click.Command, context: click.Context, root: Path) -> str:
    """The Markdown of one command."""
    usage = " ".join(["lwr-dyn", path, *command.collect_usage_pieces(context)])
    lines = [f"{'##' if ' ' not in path else '###'} {path}", "", f"```text\n{usage}\n```", ""]
    lines += [paragraphs(command.help or ""), ""]
    lines += option_tables(command, context)
    if example := examples(path):
        lines += [f"```console\n{example}\n```", ""]
    lines.append(used_in(rf"lwr-dyn {path}\b", root, PAGE))
    return "\n".join(lines)


def paragraphs(text: str) -> str:
    """A help text as Markdown; words in capitals with underscores and angle brackets stay as they are."""
    text = text.replace("\b", "").split("\f")[0]
    return "\n\n".join(escaped(" ".join(part.split())) for part in re.split(r"\n\s*\n", text.strip()))


def escaped(text: str) -> str:
    """Text in which Markdown sees no markup, code marks apart."""
    return re.sub(r"([\\*_<>|\[\]$#])", r"\\\1", text) if "`" not in text else text.replace("|", "\\|")


class Recorder(click.HelpFormatter):
    """Keeps the groups of options that a help shows."""

    def __init__(self) -> None:
        super().__init__()
        self.groups: dict[str, list[tuple[str, str]]] = {}

    @contextmanager
    def section(self, name: str) -> Iterator[None]:
        """A group of options."""
        self.groups[name] = []
        yield

    def write_dl(self, rows: Sequence[tuple[str, str]], col_max: int = 30, col_spacing: int = 2) -> None:
        """The options of the group that has begun, without those that ask for help."""
        self.groups[list(self.groups)[-1]] += [row for row in rows if not {"--help", HELP_ALL} & {*row[0].split(", ")}]


def option_tables(command: click.Command, context: click.Context) -> list[str]:
    """The options, a table a group of the help."""
    recorder = Recorder()
    if isinstance(command, click.Group):
        return []
    command.format_options(context, recorder)
    lines = []
    for name, records in recorder.groups.items():
        if records:
            lines += [f"| {name} | meaning |", "|---|---|"]
            lines += [f"| {code(flag)} | {escaped(' '.join(text.split()))} |" for flag, text in records]
            lines.append("")
    return lines


def code(text: str) -> str:
    """Text as code inside a table."""
    return "`" + text.replace("|", "\\|") + "`"


def examples(path: str) -> str:
    """The commands of the help's examples, each run by a test."""
    shown = []
    for example in help_texts().get(path, {}).get("examples", ()):
        shown.append(f"$ {example['run']}" + (f"\n[{example['exit']}]" if "exit" in example else ""))
    return "\n".join(shown)
