"""Logs of a moving arm: read from CSV files, Parquet files or ROS 2 bags, checked, written, taken from simulated runs.

Finite rows, rising times, and units that can be true; one clear line otherwise. Rows that are given twice, under
whatever name, are found: errors would look smaller than they are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from math import pi
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.column_files import SUFFIXES, read_columns, read_head, table_bytes
from lwr_dyn.foundation.errors import FileAccessError, LogError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.identification.logs import log_columns
from lwr_dyn.identification.logs.log_columns import NO_MAP, ColumnMap, Layout, LogColumn
from lwr_dyn.identification.logs.ros_bags import bag_table, is_bag
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Run, short_repr

STEPS = (5e-5, 0.5)
"""Seconds between rows a log of a moving arm may have; ms declared as s gives 10, s declared as ms 1e-5."""
TURNS = 3.0
"""Turns a joint without known limits may make before its angles look like degrees."""
MARGIN = 0.2
"""[rad or m] past a limit that a log may show: the arm's mechanical stops are no hard walls."""
OVERLOAD = 3.0
"""Times its limit that a torque may reach in a log."""
AGREEMENT = 1.5
"""Factor by which measured speeds may miss the slope of the positions; deg for rad is 57."""
DEGREES = 4.0
"""Times its limit beyond which an angle looks like degrees: 57 in a motion through the whole range; arms reach 3."""
MOVED = 1e-3
"""[rad or m] a joint must travel in all before its speed is compared."""


def check_arm(file: str, joints: tuple[int, ...], arm: Arm) -> None:
    """Every joint of the arm must be in the log; raises `LogError`."""
    wanted = tuple(range(1, arm.n + 1))
    if joints != wanted:
        found = f"joints {', '.join(map(str, joints))}"
        raise LogError(file, "columns", found, f"q1..q{arm.n} and tau1..tau{arm.n}, the joints of {arm.name}")


def check_log(file: str, lines: int, columns: Sequence[LogColumn], table: Array, arm: Arm | None) -> None:
    """Judge a table (k, columns) as it stands in the file, before its units are converted; raises `LogError`."""
    _check_finite(file, lines, columns, table)
    _check_times(file, lines, columns[0], table[:, 0])
    q = {c.joint: i for i, c in enumerate(columns) if c.quantity == "q"}
    for i, column in enumerate(columns):
        if column.quantity == "q":
            _check_position(file, column, table[:, i], arm)
        elif column.quantity == "tau":
            _check_torque(file, column, table[:, i], arm)
        elif column.quantity == "dq" and column.joint in q:
            position = columns[q[column.joint]]
            travel = table[:, q[column.joint]] * position.factor
            _check_speed(file, column, position, table[:, 0] * columns[0].factor, travel, table[:, i])


def _row(lines: int, index: int) -> str:
    return f"row {index + 1} (line {index + 1 + lines})" if lines else f"row {index + 1}"


def _check_finite(file: str, lines: int, columns: Sequence[LogColumn], table: Array) -> None:
    if np.isfinite(table.sum()):  # one NaN makes the sum NaN; an infinity makes it infinite or NaN
        return
    finite = np.isfinite(table)
    if not finite.all():
        bad = np.flatnonzero(~finite.all(axis=1))
        row, place = int(bad[0]), int(np.argmin(finite[bad[0]]))
        found = f"{table[row, place]}" + (f" ({bad.size} such rows)" if bad.size > 1 else "")
        where = f"{_row(lines, row)}, column {columns[place].shown}"
        raise LogError(file, where, found, "finite numbers; drop or repair the rows")


def _check_times(file: str, lines: int, column: LogColumn, time: Array) -> None:
    if time.size < 2:
        raise LogError(file, "rows", f"{time.size}", "a recording of at least a second")
    steps = np.diff(time)
    bad = np.flatnonzero(steps <= 0.0)
    if bad.size:
        row = int(bad[0]) + 1
        back = -steps[row - 1]
        found = "repeats the time before" if back == 0.0 else f"goes back by {back:.6g} {column.unit}"
        where = f"{_row(lines, row)}, column time"
        raise LogError(file, where, f"{time[row]:.10g} {column.unit} {found}", "times that rise from row to row")
    step = float(np.median(steps)) * column.factor
    if not STEPS[0] <= step <= STEPS[1]:
        found = f"{step:.3g} s from row to row, as [{column.unit}] is declared"
        fits = next((unit for unit, factor in log_columns.UNITS["time"].items()
                     if column.unit == "s" and STEPS[0] <= step * factor <= STEPS[1]), None)  # fmt: skip
        needed = f"{STEPS[0]:g} to {STEPS[1]:g} s; declare the unit it is in{f' ({fits} would fit)' if fits else ''}"
        raise LogError(file, "column time", found, needed)


def _check_position(file: str, column: LogColumn, values: Array, arm: Arm | None) -> None:
    low, high = float(values.min()) * column.factor, float(values.max()) * column.factor
    lower, upper, whose = -2 * pi * TURNS, 2 * pi * TURNS, f"within {TURNS:g} turns (or a robot with its limits)"
    if column.unit in ("m", "mm"):
        lower, upper = -np.inf, np.inf
    if arm is not None:
        j = column.joint - 1
        lower, upper = float(arm.lower[j]) - MARGIN, float(arm.upper[j]) + MARGIN
        whose = f"{arm.lower[j]:.4g} to {arm.upper[j]:.4g}, the limits of {arm.joint_names[j]}"
    if low < lower or high > upper:
        unit = "m" if _slides(column, arm) else "rad"
        found = f"{low:.4g} to {high:.4g} {unit}, as [{column.unit}] is declared"
        scale = log_columns.UNITS["q"]["deg"]
        fits = column.unit == "rad" and low * scale >= lower and high * scale <= upper
        far = max(high / upper if upper > 0.0 else 0.0, low / lower if lower < 0.0 else 0.0) > DEGREES
        other = "" if arm is None else ", or take the robot that it is a log of"
        needed = f"{whose}; declare the unit it is in{' (deg would fit)' if fits and far else other}"
        raise LogError(file, f"column {column.shown}", found, needed)


def _check_torque(file: str, column: LogColumn, values: Array, arm: Arm | None) -> None:
    if arm is None:
        return
    limit = float(arm.effort[column.joint - 1])
    peak = max(float(values.max()), -float(values.min())) * column.factor
    if peak > OVERLOAD * limit:
        unit = "N" if _slides(column, arm) else "N m"
        found = f"reaches {peak:.4g} {unit}, as [{column.unit}] is declared"
        needed = f"at most {OVERLOAD:g} times {limit:g} {unit}, the limit of {arm.joint_names[column.joint - 1]}"
        fits = column.unit in ("N m", "Nm") and peak * log_columns.UNITS["tau"]["mN m"] <= OVERLOAD * limit
        needed += f"; declare the unit it is in{' (mN m would fit)' if fits else ''}"
        raise LogError(file, f"column {column.shown}", found, needed)


def _check_speed(file: str, column: LogColumn, position: LogColumn, t: Array, q: Array, dq: Array) -> None:
    """Measured speeds against the slope of the positions, over spans of a tenth of a second."""
    span = max(1, round(0.1 / float(np.median(np.diff(t)))))
    slope = np.diff(q[::span]) / np.diff(t[::span])
    if slope.size < 2 or np.abs(np.diff(q[::span])).sum() < MOVED:
        return
    total = np.concatenate([[0.0], np.cumsum((dq[1:] + dq[:-1]) / 2 * np.diff(t))])[::span]
    mean = np.diff(total) / np.diff(t[::span]) * column.factor
    ratio = float((mean @ slope) / (slope @ slope))
    if not 1 / AGREEMENT < ratio < AGREEMENT:
        units = f"[{column.unit}] and [{position.unit}]"
        found = f"{ratio:.4g} times the slope of {position.shown}, as {units} are declared"
        needed = "velocities of the same joint; declare the units they are in"
        raise LogError(file, f"column {column.shown}", found, needed)


def _slides(column: LogColumn, arm: Arm | None) -> bool:
    return arm is not None and arm.chain.links[column.joint - 1].kind is JointKind.PRISMATIC


FIELDS: Mapping[str, str] = {"q": "q", "tau": "tau", "dq": "dq", "qm": "motor_q", "i": "current"}
"""Quantity in the name of a column -> field of `JointLog`."""


@dataclass(frozen=True, slots=True, eq=False)
class JointLog:
    """A recording: t (k,) [s]; q, tau and, where measured, dq (k, n) of the joints numbered in `joints` (from 1).

    Turning joints in rad, rad/s, N m; sliding ones in m, m/s, N. Where motors have encoders and current sensors of
    their own: `motor_q` (k, n) [rad], as logged (behind the gear for an elastic joint, before it for a log of the
    motors), and `current` (k, n) [A]. A quantity that must be computed from those is NaN. `notes` say what reading did.
    """

    source: str
    joints: tuple[int, ...]
    t: Array
    q: Array
    tau: Array
    dq: Array | None = None
    motor_q: Array | None = None
    current: Array | None = None
    notes: tuple[str, ...] = ()
    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in ("t", *FIELDS.values()):
            array = getattr(self, name)
            if array is not None:  # read-only views: a log may be large, so nothing is copied
                view = np.asarray(array, dtype=np.float64).view()
                view.flags.writeable = False
                object.__setattr__(self, name, view)


def read_log(
    path: str | Path, units: Mapping[str, str] | None = None, arm: Arm | None = None, columns: ColumnMap = NO_MAP,
    needs: Sequence[str] = ("q", "tau"), also: Sequence[str] = ("dq",),
) -> JointLog:  # fmt: skip
    """A log from a CSV or Parquet file or a ROS 2 bag, checked and in SI.

    Parameters
    ----------
    path : str or path
        Ends in .csv or .parquet; the columns are those of `lwr_dyn.identification.logs.log_columns`. Or a bag. Or a run
        of `simulate` (.npz), as `log_of_run` takes it at each of its samples.
    units : mapping, optional
        Quantity -> unit of the columns that declare none, such as {"q": "deg"}.
    arm : Arm, optional
        The robot: all its joints must be there, inside their limits of position and torque.
    columns : ColumnMap
        What the file calls its columns, where these are not ours.
    needs, also : sequence of str
        Quantities (q, tau, dq, qm, i) that every joint must have; those that are read where every joint has them.

    Returns
    -------
    JointLog
        q or tau that are neither needed nor there are NaN.

    Raises
    ------
    FileAccessError
        The file cannot be read.
    LogError
        Missing columns, units that cannot be, NaN, times unsorted or repeated: with file, row or column.
    MissingPackageError
        A Parquet file without pyarrow, a bag without rosbags.
    """
    place = Path(path)
    joint_names = () if arm is None else arm.joint_names
    if place.suffix == ".npz":
        return _of_run_file(place, arm, needs)
    if is_bag(place):
        bag = bag_table(place, columns, joint_names, needs, also)
        _check_joints(str(path), bag.layout, arm)
        return _made(str(path), bag.layout, tuple(bag.layout.columns.values()), bag.table, 0, arm, bag.notes)
    head = read_head(place)
    mapped = columns.of(str(path), head.names, joint_names)
    layout = log_columns.layout_of(str(path), mapped.names, {**mapped.units, **(units or {})}, needs, mapped.own)
    quantities = [*needs, *(x for x in ("q", "tau", *also) if x not in needs and layout.has(x))]
    taken = [layout.columns[x] for x in ("time", *(f"{quantity}{j}" for quantity in quantities for j in layout.joints))]
    _check_joints(str(path), layout, arm)
    return _made(str(path), layout, taken, read_columns(place, head, [c.index for c in taken]), head.lines, arm)


def _of_run_file(path: Path, arm: Arm | None, needs: Sequence[str]) -> JointLog:
    run = Run.load(path)
    if run.t.size < 2:
        raise LogError(str(path), "rows", f"{run.t.size}", "a recording of at least a second")
    log = log_of_run(run, 1.0 / float(run.t[1] - run.t[0]), str(path))
    for quantity in (x for x in needs if x not in ("q", "tau")):
        raise LogError(str(path), "columns", f"no {quantity}1.. in a run", "a log that has them")
    if arm is not None:
        check_arm(str(path), log.joints, arm)
    return log


def _check_joints(file: str, layout: Layout, arm: Arm | None) -> None:
    if arm is not None:
        check_arm(file, layout.joints, arm)
        log_columns.check_kinds(file, layout, [link.kind for link in arm.chain.links])


def _made(
    file: str, layout: Layout, columns: Sequence[LogColumn], table: Array, lines: int, arm: Arm | None,
    notes: tuple[str, ...] = (),
) -> JointLog:  # fmt: skip
    """The log of a table (k, columns), checked; its numbers become SI in place."""
    check_log(file, lines, columns, table, arm)
    table *= np.array([c.factor for c in columns])
    parts: dict[str, list[int]] = {}
    for place, column in enumerate(columns):
        parts.setdefault(column.quantity, []).append(place)
    absent = np.broadcast_to(np.nan, (len(table), len(layout.joints)))
    fields: dict[str, Array | None] = {field: None for field in FIELDS.values()} | {"q": absent, "tau": absent}
    for quantity, places in parts.items():
        if quantity != "time":
            fields[FIELDS[quantity]] = table[:, places[0] : places[-1] + 1]
    return JointLog(file, layout.joints, table[:, 0], **fields, notes=notes)  # type: ignore[arg-type]


def write_log(path: str | Path, log: JointLog) -> None:
    """Write a log as .csv or .parquet, in SI with the units in the names; raises `FileAccessError`.

    A quantity that is NaN throughout is left out.
    """
    suffix = Path(path).suffix
    if suffix not in SUFFIXES:
        raise FileAccessError(str(path), f"ends in {suffix or 'nothing'!r}", "a path that ends in .csv or .parquet")
    names, columns = [f"time [{log_columns.SI['time']}]"], [log.t]
    for quantity, field in FIELDS.items():
        values = getattr(log, field)
        if values is None or np.isnan(values).all():
            continue
        for i, joint in enumerate(log.joints):
            names.append(f"{quantity}{joint} [{log_columns.SI[quantity]}]")
            columns.append(values[:, i])
    write_file(path, table_bytes(names, columns, suffix))


def log_of_run(run: Run, rate: float = 100.0, source: str = "run") -> JointLog:
    """What a log of a simulated run at `rate` [Hz] holds: exact positions and applied torques, no velocity.

    At a sample of the controller the held torque jumps; a row has the mean of what was held before and after it, as any
    transducer of finite speed shows. `lwr_dyn.identification.logs.simulated_logs` adds noise and rounding.
    """
    rows = slice(0, None, max(1, round(1.0 / (rate * float(run.t[1] - run.t[0])))))
    held = run.tau_applied
    tau = np.concatenate([held[:1], (held[1:] + held[:-1]) / 2])
    theta = run.signals.get("theta")  # of elastic joints: the motors, seen at the joints
    motors, joints = None if theta is None else theta[rows], tuple(range(1, run.n + 1))
    return JointLog(source, joints, run.t[rows], run.q[rows], tau[rows], motor_q=motors)


_BLOCK = 10_000
"""Rows at once."""


def digest_of(log: JointLog) -> bytes:
    """Of all that was measured, to the last bit; of the times only their number, as clocks may start anywhere."""
    found = blake2b(f"{log.joints} {len(log.t)}".encode())
    for field in FIELDS.values():
        values = getattr(log, field)
        if field != "dq" and values is not None:  # a copy may lack the measured velocity
            for first in range(0, len(values), _BLOCK):
                found.update(np.ascontiguousarray(values[first : first + _BLOCK]).data)
    return found.digest()


def repeated(log: JointLog, seen: dict[bytes, str], needed: str = "each recording once") -> LogError | None:
    """A fault where the rows are in `seen` (digest -> whose); else they are noted there."""
    digest = digest_of(log)
    if digest not in seen:
        seen[digest] = log.source
        return None
    first = seen[digest]
    found = "given twice" if first == log.source else f"the same as those of {first}"
    return LogError(log.source, "rows", found, needed)


def apart_from(
    logs: Sequence[JointLog], others: Sequence[JointLog] = (), what: str = "", needed: str = "each recording once"
) -> tuple[list[JointLog], list[LogError]]:
    """The logs whose rows stand neither in `others` (which are `what`) nor in a log before; a fault for each other."""
    seen = {digest_of(log): f"{log.source}, {what}" for log in others}
    faults = [repeated(log, seen, needed) for log in logs]
    kept = [log for log, fault in zip(logs, faults, strict=True) if fault is None]
    return kept, [fault for fault in faults if fault is not None]
