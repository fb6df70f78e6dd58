"""`lwr-dyn identify friction`: friction from runs at constant speed."""

from typing import Any

import click

from lwr_dyn.arms.loading import load
from lwr_dyn.cli.identify.log_options import end, log_options
from lwr_dyn.cli.options import OneOf, OptionRule, refuse_unused, show, stands_on
from lwr_dyn.foundation.progress import progress
from lwr_dyn.identification.friction import identify_friction
from lwr_dyn.identification.friction.direction_fit import MODELS
from lwr_dyn.identification.friction.friction_map import DEFAULT_CRUISE, SUBTRACT, CruiseRule
from lwr_dyn.identification.logs.log_columns import column_map, declared_units
from lwr_dyn.pages.plotting.plots import check_figure, save_figure

FRICTION_RULES = tuple(
    OptionRule(option, lambda given: given["robot"] is not None, "with --robot") for option in ("subtract", "reading")
)
"""Options that need a model."""


@click.command("friction")
@log_options
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
def command(logs: tuple[str, ...], robot: str | None, reading: str | None, units: str | None, **given: Any) -> None:
    """Friction of each joint and direction from constant-velocity runs."""
    refuse_unused(FRICTION_RULES, {**given, "robot": robot})
    if given["plot"] is not None:
        check_figure(given["plot"])
    rule = CruiseRule(shortest=given["shortest"], tolerance=given["tolerance"])
    options = identify_friction.FitOptions(given["model"], given["robust"], given["equal_weights"], rule)
    arm = None if robot is None else stands_on(load(robot, reading))
    with progress("reading and fitting the logs"):
        result = identify_friction.identify_friction_files(
            logs, declared_units(units), arm, given["subtract"], options, column_map(given["columns"])
        )
    if result.points:
        show(identify_friction.friction_document(result, robot), given["as_json"])
    if result.points and given["plot"] is not None:
        png, svg = save_figure(identify_friction.friction_map_figure(result), given["plot"])
        if not given["as_json"]:
            click.echo(f"wrote {png} and {svg}")
    end(result.faults)
