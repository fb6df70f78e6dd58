"""A run as the bytes of a file for other programs: CSV, Parquet (extra `logs`), MATLAB."""

import io
from typing import Any

from scipy.io import savemat

from lwr_dyn.foundation.column_files import table_bytes
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.model.run import Run

MATLAB_HEAD = b"MATLAB 5.0 MAT-file, written by lwr_dyn"
"""In place of scipy's, which holds the time of writing: a run gives the same bytes again."""
_ARRAYS = ("t", "q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction", "energy")


def csv_bytes(run: Run) -> bytes:
    """The columns of `Run.to_columns`, every number to its last bit; `lwr-dyn identify` reads it as a log.

    Its tau is the torque that was held from each sample on: it jumps there, and no transducer would show it so.
    `lwr_dyn.identification.logs.joint_log.log_of_run` makes a log as a transducer would.
    """
    columns = run.to_columns()
    return table_bytes(list(columns), list(columns.values()), ".csv")


def parquet_bytes(run: Run) -> bytes:
    """The same columns as Parquet; raises `MissingPackageError` without the extra `logs`."""
    columns = run.to_columns()
    return table_bytes(list(columns), list(columns.values()), ".parquet")


def matlab_bytes(run: Run) -> bytes:
    """Variables t (k, 1), q, dq, ... (k, n) in SI, energy, work.actuator ..., joint_units, and the record as JSON."""
    values = {name: getattr(run, name) for name in _ARRAYS}
    units = run.meta.get("joint_units") or []
    values |= {"work": dict(run.work), "record": json_text(dict(run.meta))}
    out: Any = io.BytesIO()
    savemat(out, values | ({"joint_units": units} if units else {}), oned_as="column", do_compression=True)
    written: bytes = out.getvalue()
    return MATLAB_HEAD.ljust(116) + written[116:]
