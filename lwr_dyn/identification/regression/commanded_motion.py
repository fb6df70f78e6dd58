"""What unfiltered logs say of the base parameters, with the motion that was commanded as instruments."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.instrumental import UNFILTERED, instrumental
from lwr_dyn.identification.regression.normal_equations import normal_equations
from lwr_dyn.identification.regression.samples import Samples, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.run import Motion


def commanded_motion(command: JointLog, t: Array) -> Motion:
    """The motion that was commanded at times t (k,) [s], by a spline through its positions.

    Parameters
    ----------
    command : JointLog
        Its times and positions count, its torques need not be there: the file of `lwr-dyn excite`, or a run of the same
        command by `lwr-dyn simulate`, whose motion is nearer to that of the arm.
    t : (k,) array

    Returns
    -------
    Motion

    Raises
    ------
    LogError
        A command that does not cover these times.
    """
    slack = 0.5 * float(np.median(np.diff(command.t)))
    if t[0] < command.t[0] - slack or t[-1] > command.t[-1] + slack:
        found = f"{command.t[0]:g} to {command.t[-1]:g} s"
        raise LogError(command.source, "column time", found, f"all times of the log, {t[0]:g} to {t[-1]:g} s")
    q = CubicSpline(command.t, command.q)
    return Motion(t, q(t), q(t, 1), q(t, 2))


def instrumental_information(
    logs: Sequence[JointLog], commands: Sequence[JointLog], columns: TorqueColumns, slowest: float
) -> tuple[Information, Samples]:
    """What logs without a filter say of the base parameters, and their torques along the commanded motion.

    Parameters
    ----------
    logs, commands : sequence of JointLog
        Recordings, and the command of each.
    columns : TorqueColumns
    slowest : float
        Speed of the command up to which a joint's equation is left out [rad/s or m/s].

    Returns
    -------
    Information, Samples
        Values, precision and noise of `instrumental`; chi^2 is that of the noise, which is taken from the residuals.
        Normal equations and samples have the states of the command, which have no noise: they compare predictions.

    Raises
    ------
    OptionError
        Another number of commands than of logs.
    LogError
        A command that does not cover the times of its log; as `samples_of` and `instrumental`.
    """
    if len(commands) != len(logs):
        raise OptionError("instruments", f"{len(commands)} for {len(logs)} logs", "one for each log, in their order")
    samples = samples_of(logs, UNFILTERED)
    motions = [commanded_motion(c, samples_of([log], UNFILTERED).t) for log, c in zip(logs, commands, strict=True)]
    t, q, dq, ddq = (np.concatenate([getattr(m, name) for m in motions]) for name in ("t", "q", "dq", "ddq"))
    found = instrumental(samples, columns, Motion(t, q, dq, ddq), slowest)
    used = samples.used & (np.abs(dq) > slowest)
    along = replace(samples, q=q, dq=dq, ddq=ddq, used=used)
    dof = found.equations - found.base.count
    information = Information(
        columns, found.base, found.values, np.asarray(np.linalg.inv(found.covariance), dtype=np.float64), found.noise,
        np.count_nonzero(used, axis=0), float(dof), dof, np.ones(found.base.count, dtype=np.bool_),
        normal_equations(along, columns, found.base), np.ones(columns.n),
    )  # fmt: skip
    return information, along
