"""Logs of a moving arm: read from CSV files, Parquet files or ROS 2 bags, written, and taken from simulated runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.column_files import SUFFIXES, read_columns, read_head, table_bytes
from lwr_dyn.foundation.errors import FileAccessError, LogError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.identification.logs.bag_columns import bag_table
from lwr_dyn.identification.logs.column_map import NO_MAP, ColumnMap
from lwr_dyn.identification.logs.log_checks import check_arm, check_log
from lwr_dyn.identification.logs.log_columns import SI, Layout, LogColumn, check_kinds, layout_of
from lwr_dyn.identification.logs.ros_bags import is_bag
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.model.shown import short_repr

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
    layout = layout_of(str(path), mapped.names, {**mapped.units, **(units or {})}, needs, mapped.own)
    quantities = [*needs, *(x for x in ("q", "tau", *also) if x not in needs and layout.has(x))]
    taken = [layout.columns[x] for x in ("time", *(f"{quantity}{j}" for quantity in quantities for j in layout.joints))]
    _check_joints(str(path), layout, arm)
    return _made(str(path), layout, taken, read_columns(place, head, [c.index for c in taken]), head.lines, arm)


def _of_run_file(path: Path, arm: Arm | None, needs: Sequence[str]) -> JointLog:
    run = Run.load(path)
    log = log_of_run(run, 1.0 / float(run.t[1] - run.t[0]), str(path))
    for quantity in (x for x in needs if x not in ("q", "tau")):
        raise LogError(str(path), "columns", f"no {quantity}1.. in a run", "a log that has them")
    if arm is not None:
        check_arm(str(path), log.joints, arm)
    return log


def _check_joints(file: str, layout: Layout, arm: Arm | None) -> None:
    if arm is not None:
        check_arm(file, layout.joints, arm)
        check_kinds(file, layout, [link.kind for link in arm.chain.links])


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
    names, columns = [f"time [{SI['time']}]"], [log.t]
    for quantity, field in FIELDS.items():
        values = getattr(log, field)
        if values is None or np.isnan(values).all():
            continue
        for i, joint in enumerate(log.joints):
            names.append(f"{quantity}{joint} [{SI[quantity]}]")
            columns.append(values[:, i])
    write_file(path, table_bytes(names, columns, suffix))


def log_of_run(run: Run, rate: float = 100.0, source: str = "run") -> JointLog:
    """What a log of a simulated run at `rate` [Hz] holds: exact positions and applied torques, no velocity.

    At a sample of the controller the held torque jumps; a row has the mean of what was held before and after it, as any
    transducer of finite speed shows. `lwr_dyn.identification.logs.simulated_logs` adds noise and rounding.
    """
    step = max(1, round(1.0 / (rate * float(run.t[1] - run.t[0]))))
    rows = slice(0, None, step)
    joints = tuple(range(1, run.n + 1))
    held = run.tau_applied
    tau = np.concatenate([held[:1], (held[1:] + held[:-1]) / 2])
    theta = run.signals.get("theta")  # of elastic joints: the motors, seen at the joints
    motors = None if theta is None else theta[rows]
    return JointLog(source, joints, run.t[rows], run.q[rows], tau[rows], motor_q=motors)
