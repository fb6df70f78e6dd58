"""`lwr-dyn identify friction`: friction from runs at constant speed."""

from typing import Any

import click
from click.core import ParameterSource

from lwr_dyn.cli.help_text import ROBOT_OPTIONS
from lwr_dyn.cli.identify.log_options import end, is_log, log_options
from lwr_dyn.cli.options import Loading, OneOf, robot_options, show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.progress import progress
from lwr_dyn.identification.friction import identify_friction
from lwr_dyn.identification.friction.direction_fit import MODELS
from lwr_dyn.identification.friction.friction_map import DEFAULT_CRUISE, SUBTRACT, CruiseRule
from lwr_dyn.identification.logs.log_columns import column_map, declared_units
from lwr_dyn.pages.plotting.plots import check_figure, save_figure

OF_ROBOT = (*ROBOT_OPTIONS, "--subtract")
"""Options that need a model."""


@click.command("friction")
@robot_options
@log_options
@click.option("--subtract", type=OneOf(SUBTRACT), default="gravity", show_default=True,
              help="What the model of ROBOT takes out: g; B ddq + C dq; all of it.")  # fmt: skip
@click.option("--model", type=OneOf(MODELS), default=MODELS[0], show_default=True, help="What is fitted.")
@click.option("--robust", is_flag=True, help="Huber's loss: outliers have little influence.")
@click.option("--equal-weights", is_flag=True, help="Every cruise counts the same, not every sample.")
@click.option(
    "--shortest",
    type=float,
    default=DEFAULT_CRUISE.shortest,
    show_default=True,
    help="Shortest cruise (run at one speed) that counts, s.",
)
@click.option("--tolerance", type=float, default=DEFAULT_CRUISE.tolerance, show_default=True,
              help="Share by which the speed of a cruise may vary.")  # fmt: skip
@with_shared("--plot", " of the friction-velocity maps, .png and .svg. Repeatable", form="FILE.png")
def command(robot: str, loading: Loading, logs: tuple[str, ...], units: str | None, **given: Any) -> None:
    """Friction of each joint and direction from constant-velocity runs.

    The model of ROBOT is taken out of the torques; without a robot they are taken as they are.
    """
    model, logs = (None, (robot, *logs)) if is_log(robot) else (robot, logs)
    if model is None:
        _refuse_of_robot()
    elif not logs:
        raise click.MissingParameter(param_hint="'LOG...'", param_type="argument")
    for path in given["plot"]:
        check_figure(path)
    rule = CruiseRule(shortest=given["shortest"], tolerance=given["tolerance"])
    options = identify_friction.FitOptions(given["model"], given["robust"], given["equal_weights"], rule)
    arm = None if model is None else loading.arm(model)
    with progress("reading and fitting the logs"):
        result = identify_friction.identify_friction_files(
            logs, declared_units(units), arm, given["subtract"], options, column_map(*given["columns"])
        )
    if result.points:
        show(identify_friction.friction_document(result, model), given["as_json"])
    for path in given["plot"] if result.points else ():
        png, svg = save_figure(identify_friction.friction_map_figure(result), path)
        if not given["as_json"]:
            click.echo(f"wrote {png} and {svg}")
    end(result.faults)


command.params = [
    click.Argument(["robot"], metavar="[ROBOT]"),
    *(param for param in command.params if param.name not in ("robot", "logs")),
    click.Argument(["logs"], nargs=-1, metavar="LOG..."),
]


def _refuse_of_robot() -> None:
    """Raise `OptionError` for the first typed option that does nothing without a robot."""
    context = click.get_current_context()
    for param in context.command.params:
        typed = context.get_parameter_source(param.name or "") is ParameterSource.COMMANDLINE
        if typed and param.opts[0] in OF_ROBOT:
            raise OptionError(param.opts[0], "would do nothing here", "with a robot: ROBOT LOG...")
