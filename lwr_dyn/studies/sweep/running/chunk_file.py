"""The runs of a chunk as columns, and these as a Parquet file that says what they are and what made them.

A column is the number of the run, a value that was varied, a metric, the flag, or whether `simulate` computed the run.
Values with several numbers a run have the columns of their `VariedParameter`, metrics one a joint: `position_rms[3]`.
"""

import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, MissingPackageError
from lwr_dyn.foundation.files import LARGEST, read_bytes
from lwr_dyn.studies.sweep.summary import ControllerRuns

NEEDED = "a chunk of a sweep, as `lwr-dyn sweep` writes it"
_KEY = b"lwr_dyn"


def joined(parts: Sequence[ControllerRuns]) -> ControllerRuns:
    """One after the other; raises `IndexError` for none."""
    first = parts[0]
    run, flags, simulated = (np.concatenate([getattr(p, x) for p in parts]) for x in ("run", "flags", "simulated"))
    values = {name: np.concatenate([part.values[name] for part in parts]) for name in first.values}
    metrics = {name: np.concatenate([part.metrics[name] for part in parts]) for name in first.metrics}
    return ControllerRuns(first.label, run, values, metrics, flags, simulated)


def encoded(runs: ControllerRuns, digest: str, names: Mapping[str, tuple[str, ...]] | None = None) -> bytes:
    """The file of a chunk; the same runs give the same bytes with the same pyarrow.

    `names` are the columns of values with several numbers a run, by path. Raises `MissingPackageError` without pyarrow.
    """
    arrow, parquet = pyarrow()
    flat: dict[str, Array] = {"run": np.asarray(runs.run, dtype=np.int64)}
    said: dict[str, Any] = {"digest": digest, "first": int(flat["run"][0]), "values": {}, "metrics": {}}
    for kind, each in (("values", runs.values), ("metrics", runs.metrics)):
        for name, x in each.items():
            rows = np.asarray(x).reshape(len(x), -1)
            labels = list((names or {}).get(name) or [f"{name}[{i + 1}]" for i in range(rows.shape[1])])
            said[kind][name] = labels if np.ndim(x) > 1 else None
            flat |= dict(zip(labels if np.ndim(x) > 1 else [name], map(_plain, rows.T), strict=True))
    flat |= {"flag": np.asarray(runs.flags, dtype=str), "simulated": np.asarray(runs.simulated, dtype=bool)}
    table = arrow.table(flat).replace_schema_metadata({_KEY: json.dumps(said)})
    sink = io.BytesIO()
    parquet.write_table(table, sink, use_dictionary=False)
    return sink.getvalue()


def decoded(path: Path, label: str) -> ControllerRuns:
    """The runs of a chunk, labelled; raises `FileAccessError` for a file that is not one or is damaged."""
    data = read_bytes(path, NEEDED, LARGEST)
    arrow, parquet = pyarrow()
    try:
        table = parquet.read_table(io.BytesIO(data))
        said = json.loads(table.schema.metadata[_KEY])
        flat = {name: table.column(name).to_numpy() for name in table.column_names}
        values, metrics = (
            {name: _joined(name, labels, flat) for name, labels in said[kind].items()} for kind in ("values", "metrics")
        )
        return ControllerRuns(label, flat["run"], values, metrics, flat["flag"].astype(str), flat["simulated"])
    except (arrow.ArrowException, OSError, KeyError, TypeError, ValueError, AttributeError):
        raise FileAccessError(str(path), "damaged, or no chunk of a sweep", NEEDED) from None


def chunk_digest(path: Path, rows: int) -> str | None:
    """What made a chunk; None for a file that is not one, is damaged at its end, or holds another number of runs."""
    found = chunk_stamp(path)
    return found[0] if found is not None and found[2] == rows else None


def chunk_stamp(path: Path) -> tuple[str, int, int] | None:
    """What made a chunk, its first run and their number; None for a file that is not one or is damaged at its end."""
    arrow, parquet = pyarrow()
    try:
        found = parquet.read_metadata(path)
        said = json.loads(found.metadata[_KEY])
        return str(said["digest"]), int(said["first"]), int(found.num_rows)
    except (arrow.ArrowException, OSError, KeyError, TypeError, ValueError):
        return None


def pyarrow() -> tuple[Any, Any]:
    """pyarrow and its Parquet; raises `MissingPackageError`."""
    try:
        import pyarrow as arrow
        from pyarrow import parquet
    except ImportError:
        raise MissingPackageError("pyarrow", "sweeps") from None
    return arrow, parquet


def _plain(x: Array) -> Array:
    """A column that Parquet knows: texts for objects, whole memory."""
    return np.ascontiguousarray(x.astype(str) if x.dtype == object else x)


def _joined(name: str, labels: list[str] | None, flat: Mapping[str, Array]) -> Array:
    if labels is not None:
        return np.column_stack([flat[label] for label in labels])
    x = flat[name]
    return x.astype(str) if x.dtype == object else x
