"""`lwr-dyn identify payload`: a load in the hand from any motion."""

from dataclasses import replace
from typing import Any

import click

from lwr_dyn.cli.identify import log_options as of_logs
from lwr_dyn.cli.options import Loading, OneOf, robot_options, show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.progress import progress
from lwr_dyn.identification.logs.joint_log import apart_from
from lwr_dyn.identification.logs.log_columns import declared_units
from lwr_dyn.identification.payload.identify_load import CUTOFFS, FRICTIONS, identify_load
from lwr_dyn.identification.payload.possible_load import load_document, load_warnings
from lwr_dyn.identification.regression.samples import DEFAULT_SAMPLES
from lwr_dyn.model.arm import caveats_of


@click.command("payload")
@robot_options
@of_logs.log_options
@click.option("--without", multiple=True, metavar="LOG", help="A log of the same arm without the load: then the arm is "
              "fitted too, and errors of its table stay out of the load. Repeatable.")  # fmt: skip
@with_shared(
    "--fit-friction friction", " beside the load; own: the robot's, not fitted", FRICTIONS[0], kind=OneOf(FRICTIONS)
)
@with_shared("--cutoff", of_logs.LIKELIEST)
@click.option("--slowest", type=float, default=DEFAULT_SAMPLES.slowest, show_default=True,
              help="Speed up to which a joint's torques are left out, rad/s or m/s.")  # fmt: skip
@of_logs.link_side_option
@of_logs.motor_options
def command(
    robot: str, loading: Loading, logs: tuple[str, ...], units: str | None, as_json: bool, **given: Any
) -> None:
    """Mass, centre of mass and inertia of a load fixed to the flange of ROBOT, from any motion with it.

    The ten numbers are those of a body that can be: the nearest to what the torques say.
    """
    cutoffs = CUTOFFS if given["cutoff"] is None else (given["cutoff"],)
    of_logs.check_robot(robot)
    arm, declared = loading.arm(robot), declared_units(units)
    motors = of_logs.chosen_motors(arm, given)
    behind = of_logs.behind_the_gears(arm, given)
    rules = [of_logs.sample_rule(cutoff, given["slowest"], motors, behind) for cutoff in cutoffs]
    with progress("reading and fitting the logs"):
        usable, faults = of_logs.joint_logs(logs, declared, arm, motors, given["columns"], True)
        empty, more = of_logs.joint_logs(given["without"], declared, arm, motors, given["columns"], True)
        empty, same = apart_from(empty, usable, "which is with the load", "logs without the load")
        usable = [] if same else usable  # one of the two is not what it is called
        found = identify_load(usable, arm, rules, given["friction"], empty) if usable else None
    if found is not None:
        at_motors = bool(found.motors) or motors is not None  # then nothing between joints is left out
        known = replace(arm, transmission=None) if at_motors else arm
        show(replace(load_document(found, robot), caveats=caveats_of([known])), as_json, own_caveats=True)
        if as_json:
            of_logs.warn(load_warnings(found))
    of_logs.end([*faults, *more, *same])
