"""What the subcommands of `lwr-dyn identify` share: options of logs and motors, logs from files, faults, exit codes."""

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np

from lwr_dyn.cli.options import NUMBERS, OptionRule, refuse_unused
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.column_files import SUFFIXES
from lwr_dyn.foundation.errors import LogError, LwrDynError, OptionError
from lwr_dyn.identification.log_faults.found_faults import log_faults, prepared_logs
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.log_columns import column_map
from lwr_dyn.identification.logs.motor_side import MotorMap, log_at_joints, motor_map
from lwr_dyn.identification.logs.ros_bags import is_bag
from lwr_dyn.identification.payload.identify_load import CUTOFFS
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.model.arm import LINK_SIDE, Arm

LIKELIEST = f"; the likeliest of {', '.join(f'{x:g}' for x in CUTOFFS)} if not given"
"""What a command says of `--cutoff` that it chooses by the log."""

F = TypeVar("F", bound=Callable[..., Any])
RUN = ".npz"


columns_option = click.option(
    "--columns",
    metavar="MAP",
    multiple=True,
    help="What the logs call their columns: a .toml file or q=joint_pos_*,tau=effort_* (ROS 2 bags: topics). "
    "Repeatable.",
)


def log_options(command: F) -> F:
    """LOG..., --units, --columns and --json."""
    for option in (
        with_shared("--json as_json"),
        columns_option,
        click.option("--units", help="Units of columns that declare none, such as time=ms,q=deg,tau=mN m."),
        click.argument("logs", nargs=-1, required=True, metavar="LOG..."),
    ):
        command = option(command)
    return command


def is_log(path: str) -> bool:
    """Whether a path is one of a log, by its ending or form."""
    return Path(path).suffix in (*SUFFIXES, RUN) or is_bag(Path(path))


def check_robot(robot: str) -> None:
    """Raise `OptionError` for a log in the place of the robot."""
    if is_log(robot):
        raise OptionError("ROBOT", f"{robot}, a log", "a robot first, then its logs, as in  ROBOT LOG...")


def check_option(command: F) -> F:
    """--as-logged, for commands that take logs of any motion."""
    text = "Take columns that look wrong (sign, order, unit) as they are."
    return click.option("--as-logged", is_flag=True, help=text)(command)


def readable_logs(
    paths: Iterable[str], units: Mapping[str, str], arm: Arm, columns: Sequence[str] = (), as_logged: bool = False,
    needs: Sequence[str] = ("q", "tau"), also: Sequence[str] = ("dq",),
) -> tuple[list[JointLog], list[LwrDynError]]:  # fmt: skip
    """The logs of the files that can be used, and a fault for each other one.

    What preparing them did, and joints that never move, are warnings. Where the arm explains the logs only with other
    signs, order or units of columns, none can be used; with `as_logged` that is a warning too. With
    a torque that never changes none can be used in any case.
    """
    prepared = prepared_logs(paths, units, arm, column_map(*columns), needs, also)
    warn(prepared.notes)
    logs, errors = list(prepared.logs), list(prepared.errors)
    if not logs or any(np.isnan(log.q).any() for log in logs):
        return logs, errors
    try:
        faults = log_faults(logs, arm)
    except LwrDynError:  # too few rows, of which the command itself says more
        return logs, errors
    severe = [fault for fault in faults if fault.severe and (fault.kind == "silent" or not as_logged)]
    warn(str(fault) for fault in faults if fault not in severe)
    refused = [LogError(fault.where, "columns", fault.found, fault.needed) for fault in severe]
    return ([] if severe else logs), [*errors, *refused]


def warn(lines: Iterable[str]) -> None:
    """A line each on the error stream."""
    for line in lines:
        click.echo(f"lwr-dyn: warning: {' '.join(line.split())}", err=True)


def end(faults: Iterable[LwrDynError]) -> None:
    """Exit 0, or 2 with a line on the error stream for each fault."""
    several = list(faults)
    for fault in several:
        click.echo(f"lwr-dyn: {' '.join(str(fault).split())}", err=True)
    sys.exit(2 if several else 0)


MOTOR_RULES = (
    *(
        OptionRule(option, lambda given: given["motor_side"], "with --motor-side")
        for option in ("torque-constant", "motor-home")
    ),
    OptionRule("link-side", lambda given: not given["motor_side"], "without --motor-side"),
)
"""Options that need logs of motors."""


def motor_options(command: F) -> F:
    """--motor-side, --torque-constant and --motor-home."""
    for option in (
        click.option("--motor-home", type=NUMBERS, help="What the motors' encoders show with all joints at 0, rad."),
        click.option("--torque-constant", type=NUMBERS, metavar="K1,K2,...",
                     help="Of each motor, N m/A: torques are those of currents i1..; without, tau1.. of the motors."),
        click.option("--motor-side", is_flag=True,
                     help="The logs have motor positions qm1..: the robot's gears and couplings lead to the joints."),
    ):  # fmt: skip
        command = option(command)
    return command


def chosen_motors(arm: Arm, given: Mapping[str, Any]) -> MotorMap | None:
    """The motors of --motor-side; None for logs of joints. Raises `OptionError`, `ShapeError`, `MissingDataError`."""
    refuse_unused(MOTOR_RULES, given)
    return motor_map(arm, given["torque_constant"], given["motor_home"]) if given["motor_side"] else None


def link_side_option(command: F) -> F:
    """--link-side, for commands that fit torques of any motion."""
    text = "Torques are those of sensors behind the gears, with no rotor in them; so taken where ROBOT's file says it."
    return click.option("--link-side", is_flag=True, help=text)(command)


def behind_the_gears(arm: Arm, given: Mapping[str, Any]) -> bool:
    """Whether the torques of the logs have no rotors in them: as asked, or as the robot's file says, with a warning."""
    if given["link_side"] or arm.torques != LINK_SIDE or given.get("motor_side"):
        return bool(given["link_side"])
    warn([f'{arm.name}: torques are measured behind the gears (torques = "link" in its file): no rotor is fitted'])
    return True


def sample_rule(cutoff: float | None, slowest: float, motors: MotorMap | None, link_side: bool = False) -> SampleRule:
    """How instants are taken; of motors' logs none at which a motor is slower than where its joints have that speed."""
    if motors is None:
        return SampleRule(cutoff, slowest=slowest, link_side=link_side)
    speeds = slowest * np.linalg.norm(motors.transmission.matrix, axis=1)
    return SampleRule(cutoff, slowest=speeds, transmission=motors.transmission)


def joint_logs(
    paths: Iterable[str], units: Mapping[str, str], arm: Arm, motors: MotorMap | None, columns: Sequence[str],
    as_logged: bool = False,
) -> tuple[list[JointLog], list[LwrDynError]]:  # fmt: skip
    """As `readable_logs`; logs of motors are brought to the joints, and not tried for other signs, order or units."""
    if motors is None:
        return readable_logs(paths, units, arm, columns, as_logged)
    needs = ("qm", "tau" if motors.torque_constant is None else "i")
    logs, faults = readable_logs(paths, units, arm, columns, as_logged, needs, ())
    usable: list[JointLog] = []
    for log in logs:
        try:
            usable.append(log_at_joints(log, motors))
        except LwrDynError as fault:
            faults.append(fault)
    return usable, faults
