"""Options of the rows of a registry on the command line: all of them are accepted, those of other rows are refused."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import click
import numpy as np
from click.core import ParameterSource

from lwr_dyn.cli.options import NUMBERS, from_degrees
from lwr_dyn.errors import LwrDynError, OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.registry import REQUIRED, Option, Quantity, Registry, options_of

Given = Mapping[str, Any]
"""Values of a command's options by click's names."""


@dataclass(frozen=True, slots=True)
class Flag:
    """One option of the command line: the keyword that it sets in each row that has it."""

    name: str
    kind: Any
    keywords: dict[str, str] = field(default_factory=dict)
    options: dict[str, Option] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Click's name."""
        return self.name.replace("-", "_")

    @property
    def is_typed(self) -> bool:
        """Whether the user gave it in the running command."""
        return click.get_current_context().get_parameter_source(self.key) is ParameterSource.COMMANDLINE

    def value(self, row: str, given: Given, arm: Arm) -> Any:
        """The typed value for the row's keyword [rad, m]."""
        option, value = self.options[row], given[self.key]
        if self.kind is bool:
            return not option.default
        if self.kind is Quantity.ANGLE:
            return float(np.radians(value))
        return from_degrees(arm, value, f"--{self.name}") if self.kind is Quantity.JOINT_POSITIONS else value


@dataclass(frozen=True, slots=True)
class RowOptions:
    """The options of all rows of a registry, whose name is chosen with `--chooser`."""

    registry: Registry[Any]
    chooser: str
    flags: Mapping[str, Flag]

    def click_options(self) -> list[click.Option]:
        """The options as a command takes them."""
        return [_click_option(flag, self.registry) for flag in self.flags.values()]

    def refuse_unused(self, row: str) -> None:
        """Raise `OptionError` for the first typed option that does nothing for the chosen row."""
        for flag in (flag for flag in self.flags.values() if flag.is_typed):
            if row not in flag.keywords:
                words = f"with --{self.chooser} {', '.join(flag.keywords)}"
                raise OptionError(f"--{flag.name}", "would do nothing here", words)
            other = flag.options[row].unless
            for blocking in (f for f in self.flags.values() if f.keywords.get(row) == other):
                if blocking.is_typed:
                    raise OptionError(f"--{flag.name}", "would do nothing here", f"without --{blocking.name}")

    def values(self, row: str, given: Given, arm: Arm) -> dict[str, Any]:
        """Keywords of the chosen row's factory with what was typed; raises `OptionError` where one is missing."""
        values = {}
        for flag in (flag for flag in self.flags.values() if row in flag.keywords):
            if flag.is_typed:
                values[flag.keywords[row]] = flag.value(row, given, arm)
            elif flag.options[row].default is REQUIRED:
                raise OptionError(f"--{flag.name}", "not given", _needed(flag, arm))
        return values


def row_options(registry: Registry[Any], chooser: str, others: Iterable[click.Parameter] = ()) -> RowOptions:
    """The union of the rows' options; a name that `others` have, or a row before with another kind, is left to them."""
    taken = {name for option in others for name in option.opts}
    flags: dict[str, Flag] = {}
    for row in registry.names:
        for keyword, option in _options_of(registry, row).items():
            name = option.flag or _flag_name(keyword, option)
            flag = flags.get(name) or Flag(name, option.kind)
            if f"--{name}" not in taken and option.kind == flag.kind:
                flags[name] = flag
                flag.keywords[row], flag.options[row] = keyword, option
    return RowOptions(registry, chooser, flags)


def _options_of(registry: Registry[Any], row: str) -> dict[str, Option]:
    """None for a row that cannot be loaded: choosing it says why."""
    try:
        return options_of(registry.load(row))
    except LwrDynError:
        return {}


def _flag_name(keyword: str, option: Option) -> str:
    name = keyword.replace("_", "-")
    if option.kind in (Quantity.ANGLE, Quantity.JOINT_POSITIONS):
        return f"{name}-deg"
    return f"no-{name}" if option.kind is bool and option.default else name


def _click_option(flag: Flag, registry: Registry[Any]) -> click.Option:
    kinds = {Quantity.ANGLE: float, Quantity.JOINT_POSITIONS: NUMBERS}
    kind = click.Choice(flag.kind.names) if isinstance(flag.kind, Registry) else kinds.get(flag.kind, flag.kind)
    settings: dict[str, Any] = {"is_flag": True} if flag.kind is bool else {"type": kind}
    return click.Option([f"--{flag.name}"], help=_help(flag, registry), **settings)


def _help(flag: Flag, registry: Registry[Any]) -> str:
    """Help lines with the rows they are for, and the defaults."""
    lines, defaults = _by_value(flag, "help"), _by_value(flag, "default")
    shared = len(flag.options) == len(registry.names)
    text = " ".join(line if shared and len(lines) == 1 else f"{rows}: {line}" for line, rows in lines.items())
    values = [x if len(defaults) == 1 else f"{x} ({rows})" for x, rows in defaults.items()]
    return text if flag.kind is bool or not values else f"{text}  [default: {', '.join(values)}]"


def _by_value(flag: Flag, name: str) -> dict[str, str]:
    """What the options say of `name`, with the rows that say so."""
    rows: dict[str, list[str]] = {}
    for row, option in flag.options.items():
        value = getattr(option, name)
        if value is not None and value is not REQUIRED:
            rows.setdefault(str(value), []).append(row)
    return {value: ", ".join(names) for value, names in rows.items()}


def _needed(flag: Flag, arm: Arm) -> str:
    if flag.kind is Quantity.JOINT_POSITIONS:
        return f"{arm.n} joint positions, deg (m for sliding joints)"
    return "a value"


@dataclass(frozen=True, slots=True)
class OptionRule:
    """An option with what must hold beside it, as a test and in words."""

    option: str
    holds: Callable[[Given], bool]
    words: str


def refuse_unused(rules: tuple[OptionRule, ...], given: Given) -> None:
    """Raise `OptionError` for the first option that was typed and would do nothing."""
    for rule in rules:
        if Flag(rule.option, None).is_typed and not rule.holds(given):
            raise OptionError(f"--{rule.option}", "would do nothing here", rule.words)
