"""Options that would do nothing beside the others given: refused, since silence would promise an effect."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import click
from click.core import ParameterSource

from lwr_dyn.errors import OptionError

Given = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Needs:
    """An option with what must hold beside it, as a test and in words."""

    option: str
    holds: Callable[[Given], bool]
    words: str


def refuse_idle(rules: tuple[Needs, ...], given: Given) -> None:
    """Raise `OptionError` for the first option that was typed and would do nothing."""
    source = click.get_current_context().get_parameter_source
    for rule in rules:
        if source(rule.option) is ParameterSource.COMMANDLINE and not rule.holds(given):
            name = f"--{rule.option.replace('_', '-')}"
            raise OptionError(name, "would do nothing here", rule.words)
