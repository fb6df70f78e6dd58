"""All faults of logs, and logs made ready for a regression."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.identification.log_faults.column_trials import column_faults, not_tried, trial_samples
from lwr_dyn.identification.log_faults.log_fault import LogFault
from lwr_dyn.identification.log_faults.saturation import cut_saturated
from lwr_dyn.identification.log_faults.silent_torques import silent_torques
from lwr_dyn.identification.log_faults.still_joints import still_joints
from lwr_dyn.identification.log_faults.torque_scale import torque_scale_faults
from lwr_dyn.identification.logs.clock import on_even_clock
from lwr_dyn.identification.logs.column_map import NO_MAP, ColumnMap
from lwr_dyn.identification.logs.joint_log import JointLog, read_log
from lwr_dyn.identification.logs.repeated import apart_from
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True)
class PreparedLogs:
    """Logs on even clocks without saturated torques, the `faults` cut out of them, and `errors`: files left out."""

    logs: tuple[JointLog, ...]
    faults: tuple[LogFault, ...]
    errors: tuple[LwrDynError, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """What reading and preparing did, a line each."""
        return tuple(note for log in self.logs for note in log.notes)


def prepared_logs(
    paths: Iterable[str | Path], units: Mapping[str, str] | None = None, arm: Arm | None = None,
    columns: ColumnMap = NO_MAP, needs: Sequence[str] = ("q", "tau"), also: Sequence[str] = ("dq",),
) -> PreparedLogs:  # fmt: skip
    """Logs of files (as `read_log` takes them), resampled where their clock is uneven, saturated torques cut out.

    An error of one file leaves that file out; its fault is in the result. So is a second log of the same rows.
    """
    logs: list[JointLog] = []
    faults: list[LogFault] = []
    errors: list[LwrDynError] = []
    for path in paths:
        try:
            log, cut = cut_saturated(read_log(path, units, arm, columns, needs, also), arm)
            logs.append(on_even_clock(log))
        except LwrDynError as error:
            errors.append(error)
            continue
        faults += cut
    single, repeats = apart_from(logs)
    return PreparedLogs(tuple(single), tuple(faults), (*errors, *repeats))


def log_faults(logs: Sequence[JointLog], arm: Arm) -> tuple[LogFault, ...]:
    """Faults of logs taken of an arm: columns of wrong sign, order or unit, torques that never change, still joints.

    Where torques are cut out of most instants, sign, order and unit are not tried: what is left is not the motion.
    Saturated torques are cut out and said by `prepared_logs`; what a motion leaves open is said by
    `MotionIdentification.missing_motions`. Torques that never change are the only fault that is returned with them.

    Parameters
    ----------
    logs : sequence of JointLog
        On even clocks.
    arm : Arm
        With its table.

    Returns
    -------
    tuple of LogFault
        Severe ones first.

    Raises
    ------
    LogError
        As `samples_of`.
    """
    silent = silent_torques(logs)
    if silent:
        return silent
    samples = trial_samples(logs)
    if samples is None:
        return (not_tried(logs), *still_joints(logs))
    scale = torque_scale_faults(samples, arm)
    return (*scale, *(() if scale else column_faults(samples, arm)), *still_joints(logs))
