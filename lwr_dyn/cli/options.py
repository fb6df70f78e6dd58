"""Parts of several subcommands: the ROBOT argument with its options, lists of numbers, JSON output, options of rows.

All options of a registry's rows are accepted on the command line; those of other rows than the chosen one are refused.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any

import click
import numpy as np
from click.core import ParameterSource
from click.shell_completion import CompletionItem

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.arms.papers.catalog import robots
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.arrays import number_of
from lwr_dyn.foundation.document import Document
from lwr_dyn.foundation.errors import LwrDynError, OptionError, did_you_mean
from lwr_dyn.foundation.registry import REQUIRED, Option, Quantity, Registry, options_of
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.model.arm import Arm, caveats_of, si_value
from lwr_dyn.model.caveats import ABSENT_ROTORS, ALL, DYNAMICS, ROTOR_OPTION


class OneOf(click.Choice):  # type: ignore[type-arg] # generic only since click 8.2
    """One of some names; a misspelt one is answered with the name that it resembles."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The name."""
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter as fault:
            hint = did_you_mean(str(value), [str(name) for name in self.choices])
            raise click.BadParameter(f"{fault.message.rstrip('.')}{hint}.", ctx, param) from None


class Separated(click.ParamType):  # type: ignore[type-arg] # generic only since click 8.4
    """Parts separated by commas, `--q-deg -90,0` or `--q-deg=-90,0`; `read` raises `ValueError` for what are none."""

    def __init__(self, name: str, read: Callable[[str], Any], words: str) -> None:
        self.name, self.read, self.words = name, read, words

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The value."""
        if not isinstance(value, str):
            return value
        try:
            return self.read(value)
        except ValueError:
            self.fail(f"{value!r} is not {self.words}", param, ctx)


def _named(text: str) -> dict[str, float]:
    pairs = [part.split("=") for part in text.split(",")]
    return {name.strip(): number_of(number) for name, number in pairs}


NUMBERS = Separated(
    "numbers", lambda text: tuple(map(number_of, text.split(","))),
    "a list of numbers; allowed: numbers separated by commas, such as -90,0",
)  # fmt: skip
NAMED_AXES = Separated("name=value,...", _named, "a list of axes; allowed: NAME=DEG separated by commas, A1=10,A2=-90")
"""Joints by name; those not named are 0."""


def option(
    names: str, text: str, kind: Any = bool, default: Any = None, *, metavar: str | None = None, multiple: bool = False
) -> click.Option:
    """One option of click's `names` in one text; a flag without a `kind`. The help shows its default, if any."""
    if kind is bool:
        return click.Option(names.split(), is_flag=True, help=text)
    settings: dict[str, Any] = {"default": default, "show_default": default is not None, "multiple": multiple}
    return click.Option(names.split(), type=kind, metavar=metavar, help=text, **settings)


NO_CODE = option("--no-code", "Refuse controllers in Python files, which would run.")


def check_code(controllers: Iterable[str], no_code: bool, typed: bool = True) -> None:
    """With --no-code raise `OptionError` for Python files among controllers; say on stderr which run if not typed."""
    from lwr_dyn.control.controllers import code_files, refuse_code

    for path in code_files(controllers):
        if no_code:
            refuse_code(path, "--no-code")
        if not typed:
            click.echo(f"runs the Python file {path}, which the study names", err=True)


TASK_HELP = "What the arm does; if not given, ist where the arm can follow it, else move, which suits any arm."
ELASTIC_HELP = "Elastic joints: the largest stiffness, N m/rad, or `file` for the arm's own."


@dataclass(frozen=True, slots=True)
class Loading:
    """The options with which ROBOT is loaded; `further` has those of --mount, --tool, --rotor, xacro."""

    reading: str | None = None
    tip: str | None = None
    locks: tuple[str, ...] = ()
    further: Mapping[str, Any] = field(default_factory=dict)

    @property
    def options(self) -> dict[str, Any]:
        """By the names that `lwr_dyn.load` has for them; raises `OptionError` for a lock of another form."""
        return {"reading": self.reading, "tip": self.tip, "lock": dict(map(_lock, self.locks)), **self.further}

    def arm(self, robot: str, used: Collection[str] | None = DYNAMICS) -> Arm:
        """The arm, with its notes on stderr; raises as `lwr_dyn.load`.

        What must be known before those of its numbers that are `used` is the first line of what `show` prints;
        None for nothing.
        """
        arm, _ = self.arm_and_paper(robot, used)
        for note in arm.notes:
            click.echo(f"note: {note}", err=True)
        return arm

    def arm_and_paper(self, robot: str, used: Collection[str] | None = DYNAMICS) -> tuple[Arm, Paper | None]:
        """The arm and its paper (None for a `.urdf`); raises as `lwr_dyn.load`."""
        arm, paper = load_with_paper(robot, **self.options)
        return (arm if used is None else stands_on(arm, used)), paper

    def refuse_changes(self, allowed: str, mount: bool = False) -> None:
        """Raise `OptionError` for --lock, --tool, --rotor, and --mount unless it is allowed: they change the arm."""
        given = {"lock": self.locks, **self.further} | ({"mount": None} if mount else {})
        for name in (name for name in ("lock", "mount", "tool", "rotor") if given.get(name)):
            raise OptionError(f"--{name}", "given, which changes the arm", allowed)


_ARMS = "lwr_dyn.arms"
"""Where click's context keeps what is to be said of the arms."""


def _robots(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    names = [CompletionItem(name) for name in robots() if name.startswith(begun)]
    return names or [CompletionItem(begun, type="file")]


REPEATED = (
    ("--xacro-arg", "xacro_args", "NAME:=VALUE", "Argument of a .xacro."),
    (
        "--rotor",
        "rotor",
        "JOINT=VALUE|FILE.toml",
        "Rotor inertia as the joint feels it, kg m^2, in place of the file's.",
    ),
    ("--tool", "tool", "KEY=NUMBERS|FILE.toml", "On the flange: xyz, rpy_deg, mass, com, inertia; m, kg."),
    ("--mount", "mount", "PLACE|KEY=NUMBERS|FILE.toml", "Base on floor, wall, ceiling; xyz in m, rpy_deg."),
)
"""Options of loading that can be given several times: `--mount ceiling --mount xyz=0,0,2.5`."""


trust_option = click.option(
    "--trust-xacro", is_flag=True, help="Run all expressions of a .xacro as Python: none of its code runs otherwise."
)


tip_option = click.option("--tip", help="Last link of the chain (of a .urdf); that of the obvious arm if not given.")


def robot_options(command: Callable[..., None]) -> Callable[..., None]:
    """ROBOT, and as one `loading` all options that load it."""
    return click.argument("robot", shell_complete=_robots)(loading_options(command))


def loading_options(command: Callable[..., None]) -> Callable[..., None]:
    """As one `loading` all options that load a robot: of a .urdf --tip, of a .xacro --xacro-arg and --trust-xacro."""

    @wraps(command)
    def with_loading(reading: str | None, tip: str | None, locks: tuple[str, ...], **given: Any) -> None:
        repeated = {name for _, name, *_ in REPEATED}
        further = {name: given.pop(name) or None for name in [*given] if name in repeated}
        further["trust_xacro"] = given.pop("trust_xacro", False)
        command(loading=Loading(reading, tip, locks, further), **given)

    for option in (
        trust_option,
        *(click.option(*names, multiple=True, metavar=metavar, help=f"{text} Repeatable.")
          for *names, metavar, text in REPEATED),
        click.option("--lock", "locks", multiple=True, metavar="JOINT=VALUE", help="Hold a joint, rad or m."),
        tip_option,
        click.option("--reading", help="How to read the tables; the paper's default if not given."),
    ):  # fmt: skip
        with_loading = option(with_loading)
    return with_loading


def stands_on(arm: Arm, used: Collection[str] = DYNAMICS, remedy: str = ROTOR_OPTION) -> Arm:
    """The arm, which this command says its caveats of: what must be known before those of its numbers that are used.

    `remedy` is how rotors that are missing are added.
    """
    context = click.get_current_context(silent=True)
    if context is not None:
        context.meta.setdefault(_ARMS, []).extend(caveats_of([arm], used, remedy))
    return arm


def caveats() -> tuple[str, ...]:
    """One line for each arm that the running command stands on, where there is one to be said."""
    context = click.get_current_context(silent=True)
    return () if context is None else tuple(dict.fromkeys(filter(None, context.meta.get(_ARMS, ()))))


def say_caveats() -> None:
    """These lines on stdout, of a command that prints no document."""
    for line in caveats():
        click.echo(line)


def _lock(text: str) -> tuple[str, float]:
    joint, _, value = text.partition("=")
    try:
        return joint, number_of(value)
    except ValueError:
        raise OptionError("--lock", repr(text), "JOINT=VALUE, such as finger=0.02") from None


def used_by(elastic: str | None) -> Collection[str]:
    """What a loop stands on of an arm, by what --elastic asks for: numbers, and that no rotor is missing."""
    return *(DYNAMICS if elastic is None else ALL), ABSENT_ROTORS


def given_elasticity(text: str | None) -> str | float | None:
    """What `--elastic` asks for, as the option `elasticity` of `simulate`; raises `OptionError`."""
    try:
        if text in (None, "file") or 0.0 < number_of(str(text)) < float("inf"):
            return text if text in (None, "file") else number_of(str(text))
    except ValueError:
        pass
    raise OptionError("--elastic", repr(text), "a stiffness above 0 in N m/rad, or file")


def show(document: Document, as_json: bool, wrote: Iterable[object] = (), own_caveats: bool = False) -> None:
    """A result on stdout, as text with the files that were written, or as one JSON object.

    The caveats of the arms that it stands on come first; with `own_caveats` those of the document are all.
    """
    document = document if own_caveats else with_caveats(document)
    click.echo(json_text(document.record()) if as_json else document.text())
    for path in () if as_json else wrote:
        click.echo(f"wrote {path}")


def with_caveats(document: Document) -> Document:
    """The document with the caveats of the command's arms, for a page of it."""
    context = click.get_current_context(silent=True)
    if context is None or _ARMS not in context.meta:
        return document
    return replace(document, caveats=tuple(dict.fromkeys((*(document.caveats or ()), *caveats()))))


Given = Mapping[str, Any]
"""Values of a command's options by click's names."""


@dataclass(frozen=True, slots=True)
class Flag:
    """One option of the command line, and the option that it sets in each row that has it."""

    name: str
    kind: Any
    rows: dict[str, Option] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Click's name."""
        return self.name.replace("-", "_")

    @property
    def is_typed(self) -> bool:
        """Whether the user gave it in the running command."""
        return click.get_current_context().get_parameter_source(self.key) is ParameterSource.COMMANDLINE


@dataclass(frozen=True, slots=True)
class RowOptions:
    """The options of all rows of a registry, a row of which is chosen with `--chooser`."""

    registry: Registry[Any]
    chooser: str
    flags: tuple[Flag, ...]

    def click_options(self) -> list[click.Option]:
        """The options as a command takes them."""
        return [_click_option(flag, self.registry) for flag in self.flags]

    def refuse_unused(self, row: str) -> None:
        """Raise `OptionError` for the first typed option that does nothing for the chosen row."""
        typed = [flag for flag in self.flags if flag.is_typed]
        for flag in typed:
            if row not in flag.rows:
                words = f"with --{self.chooser} {', '.join(flag.rows)}"
                raise OptionError(f"--{flag.name}", "would do nothing here", words)
            for other in typed:
                if row in other.rows and other.rows[row].keyword == flag.rows[row].unless:
                    raise OptionError(f"--{flag.name}", "would do nothing here", f"without --{other.name}")

    def values(self, row: str, given: Given, arm: Arm) -> dict[str, Any]:
        """Typed values by keyword of the chosen row's factory; raises `OptionError` where one is missing."""
        values = {}
        for flag in (flag for flag in self.flags if row in flag.rows):
            if flag.is_typed:
                values[flag.rows[row].keyword] = si_value(flag.rows[row], given[flag.key], arm, f"--{flag.name}")
            elif flag.rows[row].default is REQUIRED:
                raise OptionError(f"--{flag.name}", "not given", _needed(flag, row, arm))
        return values


def row_options(registry: Registry[Any], chooser: str, others: Iterable[click.Parameter] = ()) -> RowOptions:
    """The union of the rows' options, without names that `others`, or an earlier row with another kind, have taken."""
    taken = {name for option in others for name in option.opts}
    flags: dict[str, Flag] = {}
    for row in registry.names:
        for option in _options_of(registry, row):
            name = option.flag_name
            flag = flags.get(name) or Flag(name, option.kind)
            if f"--{name}" not in taken and option.kind == flag.kind:
                flags[name] = flag
                flag.rows[row] = option
    return RowOptions(registry, chooser, tuple(flags.values()))


def _options_of(registry: Registry[Any], row: str) -> Collection[Option]:
    """The options of a row; empty for one that cannot be loaded, which raises when it is chosen."""
    try:
        return options_of(registry.load(row)).values()
    except LwrDynError:
        return ()


def _click_option(flag: Flag, registry: Registry[Any]) -> click.Option:
    kinds = {quantity: float if quantity is Quantity.ANGLE else NUMBERS for quantity in Quantity}
    kind = OneOf(flag.kind.names) if isinstance(flag.kind, Registry) else kinds.get(flag.kind, flag.kind)
    return option(f"--{flag.name}", _help(flag, registry), kind)


def _help(flag: Flag, registry: Registry[Any]) -> str:
    """Help lines with the rows they are for, and the defaults."""
    lines, defaults = _by_value(flag, "help"), _by_value(flag, "default")
    shared = len(flag.rows) == len(registry.names)
    text = " ".join(line if shared and len(lines) == 1 else f"{rows}: {line}" for line, rows in lines.items())
    values = [x if rows == ", ".join(flag.rows) else f"{x} ({rows})" for x, rows in defaults.items()]
    return text if flag.kind is bool or not values else f"{text}  [default: {', '.join(values)}]"


def _by_value(flag: Flag, name: str) -> dict[str, str]:
    """The values of the field `name` of the options, each with its rows."""
    rows: dict[str, list[str]] = {}
    for row, option in flag.rows.items():
        value = getattr(option, name)
        if name == "default" and option.kind is Quantity.ANGLE and isinstance(value, float):
            value = round(float(np.degrees(value)), 9)
        if value is not None and value is not REQUIRED:
            rows.setdefault(str(value), []).append(row)
    return {value: ", ".join(names) for value, names in rows.items()}


def _needed(flag: Flag, row: str, arm: Arm) -> str:
    if flag.kind is Quantity.JOINT_POSITIONS:
        return f"{arm.n} joint positions, deg (m for sliding joints)"
    return f"a value ({flag.rows[row].help.rstrip('.')})"


@dataclass(frozen=True, slots=True)
class OptionRule:
    """An option that has an effect only where `holds` is true; `words` says so."""

    option: str
    holds: Callable[[Given], bool]
    words: str


def refuse_unused(rules: tuple[OptionRule, ...], given: Given) -> None:
    """Raise `OptionError` for the first option that was typed and would do nothing."""
    for rule in rules:
        if Flag(rule.option, None).is_typed and not rule.holds(given):
            raise OptionError(f"--{rule.option}", "would do nothing here", rule.words)
