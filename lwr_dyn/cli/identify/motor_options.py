"""Options for logs of the motors, and such logs from files as logs of the joints."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import click
import numpy as np

from lwr_dyn.cli.identify.log_options import readable_logs
from lwr_dyn.cli.options import NUMBERS
from lwr_dyn.cli.row_options import OptionRule, refuse_unused
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.motor_side import MotorMap, log_at_joints, motor_map
from lwr_dyn.model.arm import Arm

F = TypeVar("F", bound=Callable[..., Any])
MOTOR_RULES = tuple(
    OptionRule(option, lambda given: given["motor_side"], "with --motor-side")
    for option in ("torque-constant", "motor-home")
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


def slowest_motors(slowest: float, motors: MotorMap | None) -> float | Array:
    """The speed of every motor (n,) where its joints have that speed [rad/s]; the speed itself for logs of joints."""
    return slowest if motors is None else slowest * np.linalg.norm(motors.transmission.matrix, axis=1)


def joint_logs(
    paths: Iterable[str], units: Mapping[str, str], arm: Arm, motors: MotorMap | None, columns: str | None,
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
