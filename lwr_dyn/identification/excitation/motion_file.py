"""A designed motion as a file: columns of CSV or Parquet, or a run."""

from pathlib import Path

import numpy as np

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import mechanical_energy
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.column_files import table_bytes
from lwr_dyn.foundation.errors import FileAccessError
from lwr_dyn.foundation.files import check_writable, write_file
from lwr_dyn.identification.excitation.design import Excitation
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.friction import friction_torque
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.setup import arm_record

SUFFIXES = (".csv", ".parquet", ".npz")


def check_target(path: str | Path) -> None:
    """Raise `FileAccessError` where no motion can be written."""
    if Path(path).suffix not in SUFFIXES:
        raise FileAccessError(str(path), f"does not end in {', '.join(SUFFIXES)}", "a path that ends so")
    check_writable(path)


def write_excitation(path: str | Path, excitation: Excitation, rate: float = 100.0) -> None:
    """Write a motion at `rate` [Hz]: .csv or .parquet as columns, .npz as a `Run`.

    The columns are time, q1 ... qn, dq1 ... dqn, ddq1 ... ddqn, each with its unit. The task `csv` of the simulation
    and the reader of logs take such a table as it is. Of a motion that may not be run, .csv says why in lines with `#`
    above the names, .parquet in its metadata (`column_files.NOTES`), .npz in the `task` of the run.

    Raises
    ------
    FileAccessError
        Another ending, or the file cannot be written.
    OptionError
        A rate that is not above 0.
    MissingPackageError
        .parquet without pyarrow.
    """
    check_target(path)
    if Path(path).suffix == ".npz":
        run_of_excitation(excitation, rate).save(path)
    else:
        names, columns = excitation_columns(excitation, rate)
        said = [f"DO NOT RUN IT: {fault}" for fault in excitation.faults]
        write_file(path, table_bytes(names, columns, Path(path).suffix, said))


def excitation_columns(excitation: Excitation, rate: float) -> tuple[list[str], list[Array]]:
    """Names with units, and columns (k,), of a motion at `rate` [Hz]."""
    motion = excitation.sampled(rate)
    names, columns = ["time [s]"], [motion.t]
    for name, values, per in (("q", motion.q, ""), ("dq", motion.dq, "/s"), ("ddq", motion.ddq, "/s^2")):
        for j, link in enumerate(excitation.arm.chain.links):
            unit = "rad" if link.kind is JointKind.REVOLUTE else "m"
            names.append(f"{name}{j + 1} [{unit}{per}]")
            columns.append(values[:, j])
    return names, columns


def run_of_excitation(excitation: Excitation, rate: float) -> Run:
    """The motion as a run in which the joints follow it exactly, with the torques of the arm's own table."""
    arm, m = excitation.arm, excitation.sampled(rate)
    dynamics = dynamics_of(arm)
    friction = friction_torque(arm.friction_models(), m.dq)
    tau = np.asarray(dynamics.inverse_dynamics(m.q, m.dq, m.ddq)) + friction
    task = f"excitation ({'; '.join([excitation.objective, *excitation.faults])})"
    meta = {**arm_record(arm), "task": task, "controller": {"name": "none: as designed"}}
    return Run(
        t=m.t, q=m.q, dq=m.dq, q_ref=m.q, dq_ref=m.dq, tau_command=tau, tau_applied=tau, tau_friction=friction,
        energy=mechanical_energy(dynamics, m.q, m.dq), work={}, meta=meta,
    )  # fmt: skip
