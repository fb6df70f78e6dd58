"""The options that several commands share: what each name means, its type, unit and form, in one table.

A test reads all commands: a name that two of them explain differently has a row here, with which both agree.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import click

from lwr_dyn.cli.options import NUMBERS, OneOf, Separated
from lwr_dyn.foundation.arrays import Array, number_of
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm, from_degrees, positions

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
        """The line of the help: the words and what a command adds, with the unit before its first `;` or `:`."""
        until = re.match(r"[^;:]*", more)
        of_words = until.group() if until else ""
        return f"{self.words}{of_words}{f', {self.unit}' if self.unit else ''}{more[len(of_words) :]}."


FILE, FOLDER = "FILE", "FOLDER"


def _share(text: str) -> float:
    return number_of(text.strip().removesuffix("%")) / (100.0 if text.strip().endswith("%") else 1.0)


SHARE = Separated("share", _share, "a share; allowed: a number such as 5% or 0.05")

VOCABULARY = {
    "--all": Word("Print all", bool),
    "--arm-angle-deg": Word("Arm angle", float),
    "--browser": Word("Open the page", bool),
    "--controller": Word("A name, or a file of your own", OneOf),
    "--convention": Word("DH convention", OneOf),
    "--cutoff": Word("Cut-off of the filter on positions", float, "Hz"),
    "--delay": Word("Delay from a command to its torque", int, "samples"),
    "--deviation": Word("How far the arm may be from its table", SHARE),
    "--duration": Word("Duration", float, "s"),
    "--elastic": Word("Elastic joints: the largest stiffness", str, "N m/rad", ("K|file",)),
    "--encoders": Word("The side of elastic joints that the controller gets", OneOf),
    "--fit-friction": Word("Friction that is fitted", OneOf),
    "--from-deg": Word("Where the joints start (m for sliding)", NUMBERS),
    "--html": Word("Write one page that needs no network", forms=(FILE,)),
    "--jobs": Word("Threads or processes at once; the result is the same", click.IntRange(1), forms=("N",)),
    "--json": Word("One JSON object", bool),
    "--label": Word("Name of a run", forms=("TEXT",), repeatable=True),
    "--law": Word("A control law", forms=("NAME:OPTION=VALUE", "NAME")),
    "--markdown": Word("One table in Markdown", bool),
    "--omega-n": Word("Natural frequency", float, "rad/s"),
    "--out": Word("Write", forms=(FILE, FOLDER)),
    "--payload": Word("Point mass at the flange", float, "kg"),
    "--plant-reading": Word("another reading than the controller's"),
    "--plot": Word("Picture", forms=("NAME|FILE.png", "FILE.png"), repeatable=True),
    "--poses": Word("Poses drawn from the joint box", int),
    "--q": Word("Joint positions, rad (m for sliding joints)", NUMBERS),
    "--q-deg": Word("Joint positions, deg (m for sliding joints)", NUMBERS),
    "--rate": Word("Samples a second", float),
    "--reading": Word("How to read the tables"),
    "--robot": Word("With KUKA's axes"),
    "--runs": Word("Runs of each controller", int, forms=("N", None)),
    "--seed": Word("Seed of", int),
    "--serve": Word("Serve a live meshcat on 127.0.0.1 until Ctrl-C", bool),
    "--slowest": Word("Speed up to which a joint's torques are left out", float, "rad/s or m/s"),
    "--speed": Word("Largest speed of the tip", float, "m/s"),
    "--speed-share": Word("Share of the speed limits", float),
    "--task": Word("What the arm does", OneOf),
    "--timing": Word("Motion profile along the path", OneOf),
    "--torque-share": Word("Share of the torque limits", float),
    "--velocity-cutoff": Word("Cut-off of the velocity filter", float, "Hz"),
    "--xi": Word("Damping ratio", float),
}
"""Option -> what it means."""


def shared(names: str, more: str = "", default: Any = None, **given: Any) -> click.Option:
    """An option of the table by click's names, as `--label labels`; `more` follows its words.

    `kind` and `form` choose where a row leaves them open; the rest is click's. Raises `KeyError` for a name that has
    no row.
    """
    return click.Option(names.split(), **_settings(names, more, default, **given))


def with_shared(names: str, more: str = "", default: Any = None, **given: Any) -> Callable[[F], F]:
    """The same as a decorator of a command."""
    return click.option(*names.split(), **_settings(names, more, default, **given))


def _settings(
    names: str, more: str, default: Any, kind: Any = None, form: str | None = None, **others: Any
) -> dict[str, Any]:
    word = VOCABULARY[names.split()[0]]
    if word.kind is bool:
        return {"is_flag": True, "help": word.text(more)}
    shown = {"default": default, "show_default": default is not None}
    return {
        "type": kind or word.kind, "metavar": form or word.forms[0], "multiple": word.repeatable, **shown,
        "help": word.text(more), **others,
    }  # fmt: skip


def given_positions(arm: Arm, q: tuple[float, ...] | None, q_deg: tuple[float, ...] | None) -> Array | None:
    """Joint positions (n,) [rad or m] by --q or --q-deg; None without either.

    Raises `OptionError` where both are given, `ShapeError` for another number of joints.
    """
    if q is not None and q_deg is not None:
        raise OptionError("--q, --q-deg", "both given", "one of them")
    if q_deg is not None:
        return from_degrees(arm, q_deg, "--q-deg")
    return None if q is None else positions(arm, q, "--q")
