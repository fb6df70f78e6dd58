"""The options that several commands share: what each name means, its type, unit and form, in one table.

A test reads all commands: a name that two of them explain differently has a row here, with which both agree.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class Word:
    """What an option means wherever it stands: its words, type (a flag is `bool`), unit and forms of its value.

    A command adds to the words what it does with the value. Which names a `OneOf` takes, each command says.
    """

    words: str
    kind: Any = str
    unit: str = ""
    forms: tuple[str | None, ...] = (None,)
    repeatable: bool = False

    def text(self, more: str = "") -> str:
        """The line of the help: the words, what a command adds, the unit."""
        return f"{self.words}{more}{f', {self.unit}' if self.unit else ''}."


VOCABULARY = {
    "--jobs": Word("Threads or processes that work at once, for the same result", click.IntRange(1), forms=("N",)),
    "--json": Word("One JSON object", bool),
}
"""Option -> what it means."""


def shared(names: str, more: str = "", default: Any = None, **given: Any) -> click.Option:
    """An option of the table by click's names, as `--label labels`; `more` follows its words.

    `kind` and `form` choose where a row leaves them open. Raises `KeyError` for a name that has no row.
    """
    return click.Option(names.split(), **_settings(names, more, default, **given))


def with_shared(names: str, more: str = "", default: Any = None, **given: Any) -> Callable[[F], F]:
    """The same as a decorator of a command."""
    return click.option(*names.split(), **_settings(names, more, default, **given))


def _settings(names: str, more: str, default: Any, kind: Any = None, form: str | None = None) -> dict[str, Any]:
    word = VOCABULARY[names.split()[0]]
    if word.kind is bool:
        return {"is_flag": True, "help": word.text(more)}
    shown = {"default": default, "show_default": default is not None}
    return {"type": kind or word.kind, "metavar": form or word.forms[0], "multiple": word.repeatable, **shown,
            "help": word.text(more)}  # fmt: skip
