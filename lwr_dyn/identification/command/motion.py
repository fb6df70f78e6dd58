"""`lwr-dyn identify motion`: friction and inertial parameters from any motion."""

import click

from lwr_dyn.cli.options import print_json
from lwr_dyn.front import load
from lwr_dyn.identification.command.log_options import end, log_options, readable_logs, warn
from lwr_dyn.identification.logs.log_columns import declared_units
from lwr_dyn.identification.motion.motion_fit import DEFAULT_MOTION, MotionRule, identify_motion
from lwr_dyn.identification.motion.motion_tables import body_lines, motion_record, motion_text
from lwr_dyn.progress import progress


@click.command("motion")
@log_options
@click.option("--robot", required=True, help="Whose geometry it is (name, .toml or .urdf).")
@click.option("--window", type=float, default=DEFAULT_MOTION.window, show_default=True, help="Of smoothing, seconds.")
@click.option("--held-out", type=float, default=DEFAULT_MOTION.held_out, show_default=True,
              help="Share of every log kept for validation.")  # fmt: skip
def command(
    logs: tuple[str, ...], robot: str, reading: str | None, units: str | None, window: float, held_out: float,
    as_json: bool,
) -> None:  # fmt: skip
    """Friction and inertial base parameters from any motion, by regression, validated on held-out time.

    Says of each parameter whether it is identified, and what no bodies can have; that is a warning, not an error (exit
    0), with --json on the error stream too.
    """
    rule, arm, declared = MotionRule(window=window, held_out=held_out), load(robot, reading), declared_units(units)
    with progress("reading and fitting the logs"):
        usable, faults = readable_logs(logs, declared, arm)
        result = identify_motion(usable, arm, rule) if usable else None
    if result is not None:
        if as_json:
            print_json(motion_record(result, robot))
            warn(body_lines(result.bodies))
        else:
            click.echo(motion_text(result))
    end(faults)
