"""Parts of several subcommands: the ROBOT argument with its options, lists of numbers, JSON output."""

from collections.abc import Callable
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

from lwr_dyn.arms.loading import load_with_paper, xacro_arguments
from lwr_dyn.arms.papers.catalog import robots
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.arrays import number_of
from lwr_dyn.foundation.errors import OptionError, did_you_mean
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.model.arm import Arm

F = TypeVar("F", bound=Callable[..., Any])


class OneOf(click.Choice):  # type: ignore[type-arg] # generic only since click 8.2
    """One of some names; a misspelt one is answered with the name that it resembles."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The name."""
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter as fault:
            hint = did_you_mean(str(value), [str(name) for name in self.choices])
            raise click.BadParameter(f"{fault.message.rstrip('.')}{hint}.", ctx, param) from None


class Numbers(click.ParamType):  # type: ignore[type-arg] # generic only since click 8.4
    """Numbers separated by commas: `--q-deg -90,0` and `--q-deg=-90,0` both work."""

    name = "numbers"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, ...]:
        """The numbers as floats."""
        if isinstance(value, tuple):
            return value
        try:
            return tuple(number_of(x) for x in str(value).split(","))
        except ValueError:
            self.fail(
                f"{value!r} is not a list of numbers; allowed: numbers separated by commas, such as -90,0", param, ctx
            )


class NamedAxes(click.ParamType):  # type: ignore[type-arg] # generic only since click 8.4
    """Joints by name: `A1=10,A2=-90`; those not named are 0."""

    name = "name=value,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, float]:
        """Name -> value."""
        if isinstance(value, dict):
            return value
        try:
            pairs = [part.split("=") for part in str(value).split(",")]
            return {name.strip(): number_of(number) for name, number in pairs}
        except ValueError:
            self.fail(
                f"{value!r} is not a list of axes; allowed: NAME=DEG separated by commas, A1=10,A2=-90", param, ctx
            )


NUMBERS, NAMED_AXES = Numbers(), NamedAxes()


_LOADING = "lwr_dyn.arms.loading"
"""Where click's context keeps options of loading."""


def _robots(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    names = [CompletionItem(name) for name in robots() if name.startswith(begun)]
    return names or [CompletionItem(begun, type="file")]


def robot_options(command: F) -> F:
    """ROBOT, --reading, --lock, --mount, --tool, for a .urdf --tip, for a .xacro --xacro-arg.

    `load_robot` finds mount, tool and xacro's arguments in click's context, so that no command takes them itself.
    """
    for option in (
        _kept("xacro_args", "--xacro-arg", "NAME:=VALUE", "Argument of a .xacro."),
        _kept("tool", "--tool", "KEY=NUMBERS|FILE.toml", "On the flange: xyz, rpy_deg, mass, com, inertia; m, kg."),
        _kept("mount", "--mount", "PLACE|KEY=NUMBERS|FILE.toml", "Base on floor, wall, ceiling; xyz in m, rpy_deg."),
        click.option("--lock", "locks", multiple=True, metavar="JOINT=VALUE", help="Hold a joint, rad or m."),
        click.option("--tip", help="Last link of the chain (of a .urdf); that of the obvious arm if not given."),
        click.option("--reading", help="How to read the tables; the paper's default if not given."),
        click.argument("robot", shell_complete=_robots),
    ):
        command = option(command)
    return command


def load_robot(robot: str, reading: str | None, tip: str | None, locks: tuple[str, ...]) -> Arm:
    """The arm that the options name, with its notes on stderr; raises as `lwr_dyn.load`."""
    arm, _ = load_robot_and_paper(robot, reading, tip, locks)
    for note in arm.notes:
        click.echo(f"note: {note}", err=True)
    return arm


def load_robot_and_paper(
    robot: str, reading: str | None, tip: str | None, locks: tuple[str, ...]
) -> tuple[Arm, Paper | None]:
    """The arm that the options name and its paper (None for a `.urdf`); raises as `lwr_dyn.load`."""
    return load_with_paper(robot, reading, tip=tip, lock=dict(_lock(text) for text in locks), **options_kept())


def given_xacro_args() -> dict[str, str]:
    """The arguments of a .xacro that the options name; raises `OptionError`."""
    return xacro_arguments(options_kept().get("xacro_args") or ())


def options_kept() -> dict[str, Any]:
    """The texts of --mount, --tool and --xacro-arg, None where not given."""
    context = click.get_current_context(silent=True)
    return {} if context is None else context.meta.get(_LOADING, {})


def _kept(argument: str, option: str, metavar: str, text: str) -> Any:
    """An option of loading that can be given several times, kept as texts: `--mount ceiling --mount xyz=0,0,2.5`."""

    def keep(context: click.Context, _: click.Parameter, texts: tuple[str, ...]) -> None:
        context.meta.setdefault(_LOADING, {})[argument] = texts or None

    return click.option(
        option, argument, multiple=True, metavar=metavar, help=f"{text} Repeatable.", callback=keep, expose_value=False
    )


def _lock(text: str) -> tuple[str, float]:
    joint, _, value = text.partition("=")
    try:
        return joint, number_of(value)
    except ValueError:
        raise OptionError("--lock", repr(text), "JOINT=VALUE, such as finger=0.02") from None


def given_elasticity(text: str | None) -> str | float | None:
    """What `--elastic` asks for, as the option `elasticity` of `simulate`; raises `OptionError`."""
    try:
        if text in (None, "file") or 0.0 < number_of(str(text)) < float("inf"):
            return text if text in (None, "file") else number_of(str(text))
    except ValueError:
        pass
    raise OptionError("--elastic", repr(text), "a stiffness above 0 in N m/rad, or file")


def print_json(record: Any) -> None:
    """One JSON object on stdout."""
    click.echo(json_text(record))
