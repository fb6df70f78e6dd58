"""All faults of logs, and logs made ready for a regression.

Saturated torques are cut out, and said: a torque at a bound is not what moved the arm. A bound is the limit of the
joint, or a level at which the recorded torque itself is cut off: its largest value comes far more often than those next
to it. A torque that never changes while its joint moves (a sensor that is off, a column never written, always a bound)
measures nothing; so does one cut off below the friction of its joint, at one bound or the other all the time.

A joint that runs into its mechanical stop loses its speed at an end of its range faster than its drive ever changes it:

    |dq after - dq before| > 3 times what is usual away from the ends, from outward to less than 0.3 of it

The stop's torque is in no column of a model, so all torques are cut out while the joint is there, and for a while about
it, where a filter smears the blow.

Torques in the wrong unit are a thousand times too large or too small beside the gravity of the arm's table:

    tau_j = a_j g_j(q) + rotor, friction and offset of joint j

The slope a_j is 1, give or take what the arm differs from its table; 1000 or 0.001 is a unit (mN m read as N m, or the
other way). Of a joint that carries no weight, or little beside what moves its links, nothing can be said.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.identification.friction.friction_map import position_noise
from lwr_dyn.identification.log_faults.column_trials import LogFault, column_faults, not_tried, trial_samples
from lwr_dyn.identification.logs.clock import on_even_clock
from lwr_dyn.identification.logs.joint_log import JointLog, apart_from, read_log
from lwr_dyn.identification.logs.log_columns import NO_MAP, ColumnMap, recordings
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm

AT_LIMIT = 0.999
"""Share of a joint's limit from which a torque counts as saturated."""
OFTEN = 8
"""Rows at the largest value, and times the rows of the values next to it, from which on it is a level.

The peak of a smooth torque in counts has three times the rows of the counts below it.
"""
NEXT = 3
"""Values next to the largest that it is compared with."""
FEW = 20
"""Different values a torque must have for that."""


def saturated_rows(log: JointLog, arm: Arm | None = None) -> NDArray[np.bool_]:
    """Which torques (k, n) of a log are at a bound; the joint's limit counts where the arm is given."""
    out = np.zeros(log.tau.shape, dtype=bool)
    for j in range(log.tau.shape[1]):
        tau = log.tau[:, j]
        out[:, j] = _at_level(tau) | _at_level(-tau)
        if arm is not None and np.isfinite(arm.effort[j]):
            with np.errstate(invalid="ignore"):
                out[:, j] |= np.abs(tau) >= AT_LIMIT * arm.effort[j]
    return out


def _at_level(tau: Array) -> NDArray[np.bool_]:
    """Rows at the largest value, if it comes too often for a peak."""
    known = tau[np.isfinite(tau)]
    at = np.asarray(tau == known.max(initial=-np.inf))
    if at.sum() >= OFTEN:
        values, rows = np.unique(known, return_counts=True)
        if values.size >= FEW and rows[-1] >= OFTEN * rows[-1 - NEXT : -1].mean():
            return at
    return np.zeros(tau.size, dtype=bool)


def cut_saturated(log: JointLog, arm: Arm | None = None) -> tuple[JointLog, tuple[LogFault, ...]]:
    """The log with NaN for its saturated torques, which the regression leaves out, and what was cut, joint by joint."""
    rows = saturated_rows(log, arm)
    if not rows.any():
        return log, ()
    faults = []
    for j in np.flatnonzero(rows.any(axis=0)):
        level = float(np.abs(log.tau[rows[:, j], j]).min())
        count, first = int(rows[:, j].sum()), int(np.argmax(rows[:, j]))
        found = f"{count} rows ({rows[:, j].mean():.1%}, first {first + 1}) at {level:.4g} or beyond, cut out"
        needed, joint = "torques below the bound: a slower or shorter motion", int(log.joints[j])
        faults.append(LogFault("saturated", (joint,), f"{log.source}: column tau{joint}", found, needed))
    tau = np.where(rows, np.nan, log.tau)
    return replace(log, tau=tau, notes=(*log.notes, *map(str, faults))), tuple(faults)


STOP_WINDOW = 0.02
"""[s] Over half of which a speed is taken on both sides of an instant."""
OUTWARD, LOST = 0.05, 0.3
"""Speed before a stop, at least [rad/s or m/s], and the share of it that may be left."""
USUAL, FASTER = 0.999, 3.0
"""Quantile of the changes of speed away from the ends, and times it that a stop's is at least."""
AT_END, LEAST_END = 0.005, 2e-4
"""Share of a joint's range, and [rad or m], within which it is at its end."""
SMEARED = 0.2
"""[s] Before and after a stop, cut out: four periods of a 20 Hz filter."""


def stop_rows(log: JointLog) -> NDArray[np.bool_]:
    """Rows (k, n) at which a joint stands against a stop that it has run into, in each recording of an even log.

    A recording that begins with a step of speed hides them: that step is then usual.
    """
    out = np.zeros(log.q.shape, dtype=bool)
    for piece in recordings(log.t):
        t, half = log.t[piece], 0
        if t.size > 2:
            half = max(1, round(STOP_WINDOW / 2.0 / float(np.median(np.diff(t)))))
        if t.size > 4 * half > 0:
            for j in range(log.q.shape[1]):
                out[piece, j] = _at_stop(t, log.q[piece, j], half)
    return out


def _at_stop(t: Array, q: Array, half: int) -> NDArray[np.bool_]:
    out, travel, span = np.zeros(q.size, dtype=bool), float(np.ptp(q)), half * float(np.median(np.diff(t)))
    if not travel > LEAST:
        return out
    before, after = (q[half:-half] - q[: -2 * half]) / span, (q[2 * half :] - q[half:-half]) / span
    change, close = np.abs(after - before), max(AT_END * travel, LEAST_END)
    for sign, end in ((1.0, q.max()), (-1.0, q.min())):
        at = np.abs(q - end) < close
        near = at[half:-half]
        usual = float(np.quantile(change[~near], USUAL)) if (~near).any() else 0.0
        fast = (change > FASTER * usual) & (sign * before > OUTWARD) & (sign * after < LOST * sign * before)
        hits = np.flatnonzero(near & fast) + half
        stays = np.cumsum(np.diff(at.astype(np.intp), prepend=0) != 0)  # of the same number from one change to the next
        out |= at & np.isin(stays, stays[hits])
    return out


def cut_stops(log: JointLog) -> tuple[JointLog, tuple[LogFault, ...]]:
    """The log with NaN for all torques while a joint stands against a stop and `SMEARED` about it, and what was cut."""
    rows = stop_rows(log)
    if not rows.any():
        return log, ()
    cut, faults = np.zeros(len(log.t), dtype=bool), []
    for j in np.flatnonzero(rows.any(axis=0)):
        times = log.t[rows[:, j]]
        nearest = np.searchsorted(times, log.t)
        away = [np.abs(log.t - times[np.clip(nearest - k, 0, times.size - 1)]) for k in (0, 1)]
        own = np.minimum(*away) <= SMEARED
        cut |= own
        joint, end = int(log.joints[j]), float(log.q[int(np.argmax(rows[:, j])), j])
        found = (
            f"joint {joint} runs into a stop at {end:.4g} rad or m, first at {times[0]:.4g} s: {own.sum()} rows cut out"
        )
        needed = "a motion inside the joint's mechanical range"
        faults.append(LogFault("stop", (joint,), f"{log.source}: column q{joint}", found, needed))
    tau = np.where(cut[:, None], np.nan, log.tau)
    return replace(log, tau=tau, notes=(*log.notes, *map(str, faults))), tuple(faults)


LEAST = 1e-3
"""[rad or m] of travel, in all, below which a joint stands still."""
NOISES = 12.0
"""Standard deviations of the position noise that travel must exceed."""
LONGEST = 20_000
"""Rows of a log that the noise is taken from."""


def still_joints(logs: Sequence[JointLog]) -> tuple[LogFault, ...]:
    """A fault for every joint that moves in none of the logs; one alone where no joint moves."""
    where = ", ".join(dict.fromkeys(log.source for log in logs))
    faults = []
    for j, joint in enumerate(logs[0].joints):
        travel = [float(np.ptp(log.q[:, j])) for log in logs]
        noise = max(position_noise(log.q[:LONGEST, j]) for log in logs)
        if max(travel) < max(LEAST, NOISES * noise):
            found = f"joint {joint} never moves (at most {max(travel):.2g} rad or m)"
            needed = f"a log in which joint {joint} moves both ways: its friction, rotor and most of its link stay open"
            faults.append(LogFault("still", (joint,), f"{where}: column q{joint}", found, needed))
    if len(faults) > 1 and len(faults) == len(logs[0].joints):
        needed = "a log of a motion in which every joint moves both ways"
        return (LogFault("still", logs[0].joints, f"{where}: columns q1..", "no joint ever moves", needed),)
    return tuple(faults)


AT_ENDS = 0.95
"""Share of rows at its least or its largest value from which a torque is one that measures nothing."""


def silent_torques(logs: Sequence[JointLog]) -> tuple[LogFault, ...]:
    """A severe fault for all joints that move and whose torque has one value, or two, in all logs.

    Torques cut out do not count. A joint that stands still may well have one torque: `still_joints` says that.
    """
    moving = set(logs[0].joints) - {joint for fault in still_joints(logs) for joint in fault.joints}
    silent: dict[int, str] = {}
    for j, joint in enumerate(logs[0].joints):
        tau = np.concatenate([log.tau[:, j] for log in logs])
        ends = _ends(tau[np.isfinite(tau)]) if joint in moving else ""
        if ends:
            silent[joint] = ends
    if not silent:
        return ()
    where = ", ".join(dict.fromkeys(log.source for log in logs))
    names = ", ".join(f"tau{joint}" for joint in silent)
    values = ", ".join(silent.values())
    several = len(silent) > 1
    found = f"{names} never change{'' if several else 's'} ({values} N m or N) while the joint{'s' * several} moved"
    return (LogFault("silent", tuple(silent), where, found, "torques of a sensor that measures", severe=True),)


def _ends(tau: Array) -> str:
    """The value that a torque always has, or the two; empty for others."""
    if tau.size == 0:
        return ""
    low, high = float(tau.min()) + 0.0, float(tau.max()) + 0.0  # 0.0: not -0
    if low == high:
        return f"{low:g}"
    return f"{low:g} or {high:g}" if float(np.mean((tau == low) | (tau == high))) >= AT_ENDS else ""


SLIPS = {1e-3: "in N m, read as mN m", 1e3: "in mN m, read as N m"}
"""Slopes of torques in the wrong unit, and what went wrong."""
WITHIN = 4.0
"""Factor by which a slope may miss 1 or a slip."""
EXPLAINED = 0.5
"""Share of what friction leaves of a joint's torque that the prediction must explain, or nothing is said."""
SLOW = 1e-3
"""Speed of an instant whose friction is not asked for [rad/s or m/s]."""
WEIGHT = 0.1
"""Least torque of weight, as a share of what accelerates the links, of a joint whose slope says something (RMS)."""


def torque_scale_faults(samples: Samples, arm: Arm) -> tuple[LogFault, ...]:
    """A fault for all torques in the wrong unit, or for each joint's."""
    columns = TorqueColumns(arm.chain, friction="directions")
    own = columns.own(arm)
    own[columns.friction_indices] = 0.0
    still = np.zeros(samples.q.shape)
    predicted = columns(samples.q, still, still) @ own
    slopes = np.array([_slope(samples, columns, predicted[:, j], j) for j in range(arm.n)])
    moved = columns(samples.q, samples.dq, samples.ddq) @ own - predicted
    heavy = np.square(predicted).sum(axis=0) > WEIGHT**2 * np.square(moved).sum(axis=0)
    known = np.isfinite(slopes) & heavy
    where = ", ".join(dict.fromkeys(samples.sources))
    faults: list[LogFault] = []
    for slip, text in SLIPS.items():
        hit = known & (slopes > slip / WITHIN) & (slopes < slip * WITHIN)
        if not hit.any():
            continue
        joints = tuple((np.flatnonzero(hit) + 1).tolist())
        whole = bool((hit == known).all()) and len(joints) > 1
        names = "all torques" if whole else ", ".join(f"tau{j}" for j in joints)
        shown = ", ".join(f"{slopes[j - 1]:.3g} (joint {j})" for j in joints)
        found = f"{names} {text}: times the gravity of the table {shown}"
        needed = f"N m: --units tau={'N m' if slip < 1.0 else 'mN m'}" if whole else "one unit for all joints"
        faults.append(LogFault("unit", () if whole else joints, where, found, needed, severe=True))
    return tuple(faults)


def _slope(samples: Samples, columns: TorqueColumns, predicted: Array, joint: int) -> float:
    """a_j, NaN where it is not known."""
    rows = np.abs(samples.dq[:, joint]) > SLOW
    own = columns.own_columns(samples.q[rows], samples.dq[rows], samples.ddq[rows])[joint]  # rotor and friction
    beside = np.column_stack([own[:, np.abs(own).any(axis=0)], np.ones(len(own))])
    if len(beside) <= beside.shape[1] + 1:
        return float("nan")
    both = np.column_stack([samples.tau[rows, joint], predicted[rows]])
    tau, part = (both - beside @ np.linalg.lstsq(beside, both, rcond=None)[0]).T
    squares = float(part @ part)
    slope = float(part @ tau) / squares if squares > 0.0 else float("nan")
    left = tau - slope * part
    return slope if float(left @ left) < (1.0 - EXPLAINED) * float(tau @ tau) else float("nan")


@dataclass(frozen=True, slots=True)
class PreparedLogs:
    """Logs on even clocks without saturated torques and stops, the `faults` cut out, and `errors`: files left out."""

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
    """Logs of files (as `read_log` takes them), on even clocks, saturated torques and joint stops cut out.

    An error of one file leaves that file out; its fault is in the result. So is a second log of the same rows.
    """
    logs: list[JointLog] = []
    faults: list[LogFault] = []
    errors: list[LwrDynError] = []
    for path in paths:
        try:
            log, cut = cut_saturated(read_log(path, units, arm, columns, needs, also), arm)
            log, stops = cut_stops(on_even_clock(log))
        except LwrDynError as error:
            errors.append(error)
            continue
        logs.append(log)
        faults += [*cut, *stops]
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
