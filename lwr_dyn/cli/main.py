"""`lwr-dyn`: the subcommands, and how errors become one line and an exit code."""

import io
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import click
from click.shell_completion import CompletionItem

from lwr_dyn.cli.help_text import command_path, grouped, with_help
from lwr_dyn.cli.renamed import new_name
from lwr_dyn.foundation.errors import LwrDynError, MissingDataError, RatingWarning, UnknownNameError
from lwr_dyn.foundation.files import reason_of
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.foundation.tables import log_line
from lwr_dyn.foundation.version import VERSION


class NamedGroup(click.Group):
    """A group of commands: a misspelt one is answered with the name that it resembles."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command; raises `UnknownNameError`, but not while a shell completes a line."""
        try:
            if cmd_name in self.list_commands(ctx):
                return with_help(self.found(ctx, cmd_name), command_path(ctx, cmd_name))
            raise UnknownNameError("command", cmd_name, self.list_commands(ctx))
        except LwrDynError:
            if ctx.resilient_parsing:
                return None
            raise

    def found(self, ctx: click.Context, name: str) -> click.Command:
        """A command of `list_commands`."""
        return self.commands[name]


@contextmanager
def interruptible() -> Iterator[list[int]]:
    """Ctrl-C raises `KeyboardInterrupt`, again where a library has swallowed it; gives the signals so far.

    Where it is ignored, it stays ignored.
    """
    signals: list[int] = []

    def interrupt(number: int, _: object) -> None:
        signals.append(number)
        raise KeyboardInterrupt

    def unraisable(found: Any) -> None:
        if signals:
            threading.Timer(0.01, again).start()
        else:
            shown(found)

    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    if ignored or threading.current_thread() is not threading.main_thread():
        yield signals
        return
    again = partial(signal.raise_signal, signal.SIGINT)
    if hasattr(signal, "pthread_kill"):  # it also wakes this thread where it waits
        again = partial(signal.pthread_kill, threading.get_ident(), signal.SIGINT)
    before, shown = signal.signal(signal.SIGINT, interrupt), sys.unraisablehook
    sys.unraisablehook = unraisable
    try:
        yield signals
    finally:
        sys.unraisablehook = shown
        signal.signal(signal.SIGINT, before)


def _row(module: str, about: str, extra: str = "") -> Row:
    return Row(f"lwr_dyn.cli.{module}:command", about, extra)


COMMANDS: Registry[click.Command] = Registry(
    "command",
    {
        "list": _row("list_", "The robots, and where their numbers come from."),
        "new": _row("new", "A commented file to start from: arm, paper, controller, study."),
        "show": _row("show", "An arm in the browser: sliders, inertia, sources."),
        "urdf": _row("urdf", "A robot as URDF, with its sources beside it."),
        "dh": _row("dh", "Any arm as a DH table, or as a data file."),
        "parity": _row(
            "parity",
            "What other engines lose of a model file, and what restores it.",
            "parity",
        ),
        "check": _row("check", "A robot's model against the laws of mechanics."),
        "fk": _row("fk", "Pose of the flange; the DH matrices in symbols."),
        "gains": _row("gains", "Worst-case inertia of each joint, and gains from it."),
        "margins": _row("margins", "Margins of a sampled loop, over all poses."),
        "ik": _row("ik", "Joint positions for a pose of the flange: all solutions."),
        "kernels": _row("kernels", "Functions of an arm as C or JavaScript.", "batch"),
        "fmu": _row("fmu", "An arm or a control law as an FMU, for Simulink and others.", "batch"),
        "replay": _row("replay", "Runs in the browser: one file without network, or live."),
        "simulate": _row("simulate", "A task under a controller: errors, limits, audit."),
        "compare": _row("compare", "Controllers and plants, or run files, side by side."),
        "sweep": _row("sweep", "A study of many runs, its cost stated ahead.", "sweeps"),
        "tune": _row("tune", "Gains for a stated aim over a study.", "batch"),
        "identify": _row("identify.group", "Friction, inertia or a load, from logs of an arm that moved.", "plots"),
        "excite": _row(
            "identify.excite",
            "A motion that shows an arm's parameters best.",
            "batch",
        ),
        "rank": _row("rank", "Published sets of a robot on a log of the real one."),
        "origin": _row("origin", "Whose numbers a URDF has: which published set, and where they differ."),
        "lint": _row("lint", "Faults in URDFs and tables, with place and reason."),
        "krl": _row("krl.group", "Write, check and run KRL programs on a robot's model.", "krl"),
        "lsp": _row("lsp", "A language server for editors: KRL, URDF, xacro.", "krl"),
        "conventions": _row("conventions", "The possible conventions of a table that states none."),
        "sensitivity": _row("sensitivity", "One task under all readings of a paper's tables."),
        "reproduce": _row("reproduce", "Recompute what a paper prints.", "all"),
    },
)
"""Subcommands, imported when they are used; other packages can add rows."""

PIPE_CLOSED = 141
"""Exit code after a broken pipe (128 + SIGPIPE)."""


class RegistryGroup(NamedGroup):
    """A group whose commands are rows of a registry, imported when they are used: `--help` stays fast."""

    def __init__(self, *arguments: Any, registry: Registry[click.Command], **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.registry = registry

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of the rows."""
        return list(self.registry.names)

    def found(self, ctx: click.Context, name: str) -> click.Command:
        """The command from its module."""
        return self.registry.load(name)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Names and help lines, without importing a command."""
        names = [name for name in self.list_commands(ctx) if name.startswith(incomplete)]
        options = click.Command.shell_complete(self, ctx, incomplete)
        return [*(CompletionItem(name, help=self.registry[name].about) for name in names), *options]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The help lines in the groups of `help.toml`, without importing a command."""
        for heading, names in grouped(command_path(ctx), self.list_commands(ctx)).items():
            with formatter.section(heading):
                formatter.write_dl([(name, self.registry[name].about) for name in names])


@click.group(
    cls=RegistryGroup,
    registry=COMMANDS,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@click.version_option(VERSION, prog_name="lwr-dyn")
def group() -> None:
    """From a robot paper's tables to a URDF, the arm's equations of motion, controllers and a replay, all checked.

    ROBOT is a name from `lwr-dyn list`, or the path of your own .toml, .urdf, .xacro or .xml (MJCF) file.
    """


with_help(group, "")


def main(arguments: list[str] | None = None) -> None:
    """Run the command: exit code 0 done, 1 a check fails, 2 bad input, 130 stopped, with one line on stderr."""
    for stream in (sys.stdout, sys.stderr):  # a name that the terminal cannot show is written as \\u7a7a
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    with warnings.catch_warnings(), interruptible() as interrupts:
        warnings.simplefilter("always", RatingWarning)
        warnings.showwarning = _warner()
        try:
            code = group.main(args=arguments, prog_name="lwr-dyn", standalone_mode=False)
        except BaseException as error:
            code = _code_of(error, bool(interrupts))
    sys.exit(code if isinstance(code, int) else 0)


def _code_of(error: BaseException, interrupted: bool) -> object:
    """The exit code of an error, printed in one line; raises it again when it is a fault of this package."""
    if isinstance(error, LwrDynError):
        return print_error(f"{error}{_with_masses(error)}", error.exit_code)
    if isinstance(error, click.exceptions.NoArgsIsHelpError):
        click.echo(error.ctx.get_help() if error.ctx else "", err=True)
        return 2
    if isinstance(error, click.ClickException):
        return print_error(new_name(error) or error.format_message(), 2)
    if isinstance(error, SystemExit):
        # click ends with 1 when a pipe is closed, but 1 means "the check fails" here
        return PIPE_CLOSED if type(sys.stdout).__name__.endswith("PacifyFlushWrapper") else error.code
    if interrupted or isinstance(error, KeyboardInterrupt | click.Abort):  # a library may make another error of Ctrl-C
        return print_error("stopped", 130)
    if isinstance(error, OSError):
        where, kind = ("stdout", "an output") if error.filename is None else (error.filename, "a file")
        return print_error(f"{where}: {reason_of(error)}; allowed: {kind} that can be read or written", 2)
    raise error


def _with_masses(error: LwrDynError) -> str:
    """The robots to take instead, where one without masses was given."""
    if not (isinstance(error, MissingDataError) and error.missing == "masses and inertias"):
        return ""
    from lwr_dyn.arms.papers.catalog import open_paper, robots  # not for --help: it loads NumPy

    if error.arm not in robots():
        return ""
    known = [name for name in robots() if "inertial.mass" in open_paper(name).columns]
    return f"; robots with masses: {', '.join(known)}"


def _warner() -> Callable[..., None]:
    """A function that prints each warning once, in one line."""
    printed: set[str] = set()

    def warn(message: Warning | str, *_: object, **__: object) -> None:
        line = " ".join(str(message).split())
        if line not in printed:
            click.echo(f"lwr-dyn: warning: {line}", err=True)
        printed.add(line)

    return warn


def print_error(message: str, code: int) -> int:
    """One line on stderr; returns the exit code."""
    click.echo(log_line(f"lwr-dyn: {' '.join(message.split())}"), err=True)
    return code
