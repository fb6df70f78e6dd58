"""`lwr-dyn identify`: friction from constant-velocity logs, or friction and inertia from any motion."""

import sys
from collections.abc import Callable
from typing import Any, TypeVar

import click

from lwr_dyn.cli.help_text import NamedGroup
from lwr_dyn.cli.options import OneOf, print_json
from lwr_dyn.cli.row_options import OptionRule, refuse_unused
from lwr_dyn.errors import LwrDynError
from lwr_dyn.front import load
from lwr_dyn.identification.friction.cruise import DEFAULT_CRUISE, CruiseRule
from lwr_dyn.identification.friction.direction_fit import MODELS
from lwr_dyn.identification.friction.friction_tables import friction_record, friction_text
from lwr_dyn.identification.friction.identify_friction import FitOptions, friction_map_figure, identify_friction_files
from lwr_dyn.identification.friction.torque_model import SUBTRACT
from lwr_dyn.identification.logs.joint_log import JointLog, read_log
from lwr_dyn.identification.logs.log_columns import declared_units
from lwr_dyn.identification.motion.motion_fit import DEFAULT_MOTION, MotionRule, identify_motion
from lwr_dyn.identification.motion.motion_tables import body_lines, motion_record, motion_text
from lwr_dyn.model.arm import Arm
from lwr_dyn.plotting.plots import check_figure, save_figure
from lwr_dyn.progress import progress

F = TypeVar("F", bound=Callable[..., Any])
FRICTION_RULES = tuple(
    OptionRule(option, lambda given: given["robot"] is not None, "with --robot") for option in ("subtract", "reading")
)
"""Options that need a model."""


def _log_options(command: F) -> F:
    for option in (
        click.option("--json", "as_json", is_flag=True, help="One JSON object."),
        click.option("--units", help="Units of columns that declare none, such as time=ms,q=deg,tau=mN m."),
        click.option("--reading", help="Reading of --robot; its default if not given."),
        click.argument("logs", nargs=-1, required=True, metavar="LOG..."),
    ):
        command = option(command)
    return command


@click.group("identify", cls=NamedGroup)
def command() -> None:
    """Parameters of an arm from its logs (.csv, .parquet).

    Columns: time, q1.., tau1.., and dq1.. where measured, each with its unit in brackets (q1 [deg]) or in SI;
    other columns are ignored. Exit 2 when a file or joint could not be used; the others are reported all the same.
    """


@command.command("friction")
@_log_options
@click.option("--robot", help="Take the model of this robot out of the torques (name, .toml or .urdf).")
@click.option("--subtract", type=OneOf(SUBTRACT), default="gravity", show_default=True,
              help="What the model of --robot takes out: g; B ddq + C dq; all of it.")  # fmt: skip
@click.option("--model", type=OneOf(MODELS), default=MODELS[0], show_default=True, help="What is fitted.")
@click.option("--robust", is_flag=True, help="Huber's loss: outliers have little influence.")
@click.option("--equal-weights", is_flag=True, help="Every cruise counts the same, not every sample.")
@click.option("--shortest", type=float, default=DEFAULT_CRUISE.shortest, show_default=True, help="Cruise, seconds.")
@click.option("--tolerance", type=float, default=DEFAULT_CRUISE.tolerance, show_default=True,
              help="Share by which a cruise's speed may wander.")  # fmt: skip
@click.option("--plot", help="Write the friction-velocity maps there, .png and .svg.")
def friction(logs: tuple[str, ...], robot: str | None, reading: str | None, units: str | None, **given: Any) -> None:
    """Friction of each joint and direction from constant-velocity runs."""
    refuse_unused(FRICTION_RULES, {**given, "robot": robot})
    if given["plot"] is not None:
        check_figure(given["plot"])
    rule = CruiseRule(shortest=given["shortest"], tolerance=given["tolerance"])
    options = FitOptions(given["model"], given["robust"], given["equal_weights"], rule)
    arm = None if robot is None else load(robot, reading)
    with progress("reading and fitting the logs"):
        result = identify_friction_files(logs, declared_units(units), arm, given["subtract"], options)
    subtract = "none" if arm is None else given["subtract"]
    if result.points and given["as_json"]:
        print_json(friction_record(result, options, robot, subtract))
    elif result.points:
        click.echo(friction_text(result, options, subtract))
    if result.points and given["plot"] is not None:
        png, svg = save_figure(friction_map_figure(result), given["plot"])
        if not given["as_json"]:
            click.echo(f"wrote {png} and {svg}")
    _end(result.faults)


@command.command("motion")
@_log_options
@click.option("--robot", required=True, help="Whose geometry it is (name, .toml or .urdf).")
@click.option("--window", type=float, default=DEFAULT_MOTION.window, show_default=True, help="Of smoothing, seconds.")
@click.option("--held-out", type=float, default=DEFAULT_MOTION.held_out, show_default=True,
              help="Share of every log kept for validation.")  # fmt: skip
def motion(
    logs: tuple[str, ...], robot: str, reading: str | None, units: str | None, window: float, held_out: float,
    as_json: bool,
) -> None:  # fmt: skip
    """Friction and inertial base parameters from any motion, by regression, validated on held-out time.

    Says of each parameter whether it is identified, and what no bodies can have; that is a warning, not an error (exit
    0), with --json on the error stream too.
    """
    rule, arm, declared = MotionRule(window=window, held_out=held_out), load(robot, reading), declared_units(units)
    with progress("reading and fitting the logs"):
        usable, faults = _readable(logs, declared, arm)
        result = identify_motion(usable, arm, rule) if usable else None
    if result is not None:
        if as_json:
            print_json(motion_record(result, robot))
            for line in body_lines(result.bodies):
                click.echo(f"lwr-dyn: warning: {line}", err=True)
        else:
            click.echo(motion_text(result))
    _end(faults)


def _readable(paths: tuple[str, ...], units: dict[str, str], arm: Arm) -> tuple[list[JointLog], list[LwrDynError]]:
    usable: list[JointLog] = []
    faults: list[LwrDynError] = []
    for path in paths:
        try:
            usable.append(read_log(path, units, arm))
        except LwrDynError as fault:
            faults.append(fault)
    return usable, faults


def _end(faults: list[LwrDynError] | tuple[LwrDynError, ...]) -> None:
    for fault in faults:
        click.echo(f"lwr-dyn: {' '.join(str(fault).split())}", err=True)
    sys.exit(2 if faults else 0)
