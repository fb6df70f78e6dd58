"""`lwr-dyn identify elastic`: springs and dampers of gears from logs of both their sides."""

from typing import Any

import click

from lwr_dyn.cli.identify.log_options import check_robot, end, log_options, readable_logs
from lwr_dyn.cli.options import Loading, robot_options, show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.progress import progress
from lwr_dyn.identification.elastic_joints import TWO_ENCODERS, elastic_document, identify_elastic
from lwr_dyn.identification.logs.log_columns import declared_units
from lwr_dyn.identification.regression.samples import DEFAULT_SAMPLES, SampleRule

NEEDS = ("q", "qm", "tau")
"""Both encoders, and the torques of the motors."""


@click.command("elastic")
@robot_options
@log_options
@with_shared("--cutoff", default=TWO_ENCODERS.cutoff)
@click.option("--slowest", type=float, default=DEFAULT_SAMPLES.slowest, show_default=True,
              help="Speed up to which a joint's torques are left out, of its motor, rad/s or m/s.")  # fmt: skip
def command(
    robot: str, loading: Loading, logs: tuple[str, ...], units: str | None, as_json: bool, **given: Any
) -> None:
    """Stiffness, damping, rotors and friction of the elastic joints of ROBOT, from logs of both sides of the gears.

    Beside q1.. of the links the logs have qm1.., the motors' positions seen at the joints, and tau1.., the motors'
    torques seen at the joints. The links' base parameters are fitted too.
    """
    check_robot(robot)
    arm, rule = loading.arm(robot), SampleRule(given["cutoff"], slowest=given["slowest"])
    with progress("reading and fitting the logs"):
        usable, faults = readable_logs(logs, declared_units(units), arm, given["columns"], True, NEEDS, ())
        found = identify_elastic(usable, arm, rule) if usable else None
    if found is not None:
        show(elastic_document(found, arm, robot), as_json)
    end(faults)
