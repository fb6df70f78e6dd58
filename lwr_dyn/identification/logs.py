"""A log: what a recording of an arm holds, in SI, with the place of every row in its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import FileAccessError
from lwr_dyn.files import write_file
from lwr_dyn.identification.columns import SI, check_kinds, layout_of
from lwr_dyn.identification.log_files import SUFFIXES, read_columns, read_head, table_bytes
from lwr_dyn.identification.log_gate import check_arm, check_log
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run


@dataclass(frozen=True, slots=True, eq=False)
class JointLog:
    """A recording: t (k,) [s]; q, tau and, where measured, dq (k, n) of the joints numbered in `joints` (from 1).

    Turning joints in rad, rad/s, N m; sliding ones in m, m/s, N.
    """

    source: str
    joints: tuple[int, ...]
    t: Array
    q: Array
    tau: Array
    dq: Array | None = None

    def __post_init__(self) -> None:
        for name in ("t", "q", "tau", "dq"):
            array = getattr(self, name)
            if array is not None:  # read-only views: a log may be large, so nothing is copied
                view = np.asarray(array, dtype=np.float64).view()
                view.flags.writeable = False
                object.__setattr__(self, name, view)


def read_log(path: str | Path, units: Mapping[str, str] | None = None, arm: Arm | None = None) -> JointLog:
    """A log from a CSV or Parquet file, checked and in SI.

    Parameters
    ----------
    path : str or path
        Ends in .csv or .parquet; the columns are those of `lwr_dyn.identification.columns`.
    units : mapping, optional
        Quantity -> unit of the columns that declare none, such as {"q": "deg"}.
    arm : Arm, optional
        The robot: all its joints must be there, inside their limits of position and torque.

    Returns
    -------
    JointLog

    Raises
    ------
    FileAccessError
        The file cannot be read.
    LogError
        Missing columns, units that cannot be, NaN, times unsorted or repeated: with file, row or column.
    MissingPackageError
        A Parquet file without pyarrow.
    """
    place = Path(path)
    head = read_head(place)
    layout = layout_of(str(path), head.names, units)
    quantities = ("q", "tau", "dq") if layout.has_speed else ("q", "tau")
    names = ["time", *(f"{quantity}{j}" for quantity in quantities for j in layout.joints)]
    columns = [layout.columns[name] for name in names]
    if arm is not None:
        check_arm(str(path), layout.joints, arm)
        check_kinds(str(path), layout, [link.kind for link in arm.chain.links])
    table = read_columns(place, head, [c.index for c in columns])
    check_log(str(path), head.lines, columns, table, arm)
    table *= np.array([c.factor for c in columns])
    n = len(layout.joints)
    dq = table[:, 1 + 2 * n :] if layout.has_speed else None
    return JointLog(str(path), layout.joints, table[:, 0], table[:, 1 : 1 + n], table[:, 1 + n : 1 + 2 * n], dq)


def write_log(path: str | Path, log: JointLog) -> None:
    """Write a log as .csv or .parquet, in SI with the units in the names; raises `FileAccessError`."""
    suffix = Path(path).suffix
    if suffix not in SUFFIXES:
        raise FileAccessError(str(path), f"ends in {suffix or 'nothing'!r}", "a path that ends in .csv or .parquet")
    names, columns = [f"time [{SI['time']}]"], [log.t]
    for quantity in ("q", "tau", "dq"):
        values = getattr(log, quantity)
        for i, joint in enumerate(log.joints if values is not None else ()):
            names.append(f"{quantity}{joint} [{SI[quantity]}]")
            columns.append(values[:, i])
    write_file(path, table_bytes(names, columns, suffix))


def log_of_run(run: Run, rate: float = 100.0, source: str = "run") -> JointLog:
    """What a log of a simulated run at `rate` [Hz] holds: exact positions and applied torques, no velocity.

    At a sample of the controller the held torque jumps; a row has the mean of what was held before and after it, as any
    transducer of finite speed shows. `lwr_dyn.identification.generator` adds what sensors add.
    """
    step = max(1, round(1.0 / (rate * float(run.t[1] - run.t[0]))))
    rows = slice(0, None, step)
    joints = tuple(range(1, run.n + 1))
    held = run.tau_applied
    tau = np.concatenate([held[:1], (held[1:] + held[:-1]) / 2])
    return JointLog(source, joints, run.t[rows], run.q[rows], tau[rows])
