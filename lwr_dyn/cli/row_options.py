"""Options of the rows of a registry on the command line: all of them are accepted, those of other rows are refused."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import click
import numpy as np
from click.core import ParameterSource

from lwr_dyn.cli.options import NUMBERS, OneOf
from lwr_dyn.foundation.errors import LwrDynError, OptionError
from lwr_dyn.foundation.registry import REQUIRED, Option, Quantity, Registry, options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.option_values import si_value

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
    settings: dict[str, Any] = {"is_flag": True} if flag.kind is bool else {"type": kind}
    return click.Option([f"--{flag.name}"], help=_help(flag, registry), **settings)


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
