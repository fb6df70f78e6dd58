"""Records of movement: `Motion` is a reference, `Run` a simulated result; a run file carries its own metadata."""

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, Self

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays, read_only, real_array
from lwr_dyn.foundation.errors import FileAccessError, MissingPackageError
from lwr_dyn.foundation.files import check_readable, write_file
from lwr_dyn.model.run_file import LARGEST, check_headers, checked_record
from lwr_dyn.model.shown import format_of, repr_html, short_repr

RUN_SCHEMA = 1
_ARRAYS = ("t", "q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction", "energy")
_UNITS = {
    "q": {"rad": " [rad]", "m": " [m]"}, "d": {"rad": " [rad/s]", "m": " [m/s]"}, "t": {"rad": " [N m]", "m": " [N]"}
}  # fmt: skip
"""First letter of an array -> the unit in the name of its column, for a joint that turns or slides."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Joint motion over time with exact derivatives."""

    t: Array  # (k,) [s]
    q: Array  # (k, n) [rad or m]
    dq: Array  # (k, n) [rad/s or m/s]
    ddq: Array  # (k, n) [rad/s^2 or m/s^2]
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "t", "q", "dq", "ddq")


class Reference(Protocol):
    """A desired motion that can be sampled at any time."""

    @property
    def duration(self) -> float:
        """Duration [s]."""

    def sample(self, t: Array) -> Motion:
        """The motion at times t (k,) [s]; at rest before 0 and after `duration`."""


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a run, at one joint (0-based) or at none: impact, stick, slip, ..."""

    t: float
    kind: str
    joint: int | None = None
    value: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A simulated run: arrays over k times, joints last."""

    t: Array  # (k,) [s]
    q: Array  # (k, n) [rad or m], as all positions
    dq: Array  # (k, n) [rad/s or m/s], as all velocities
    q_ref: Array
    dq_ref: Array
    tau_command: Array  # (k, n) [N m or N], as all torques
    tau_applied: Array
    tau_friction: Array
    energy: Array  # (k,) [J], kinetic and potential
    work: Mapping[str, Array]  # (k,) [J] each: done by each channel since t = 0
    events: tuple[Event, ...] = ()
    meta: Mapping[str, Any] = field(default_factory=dict)
    signals: Mapping[str, Array] = field(default_factory=dict)
    """(k, m) each: what a sampled controller tells of itself; "tau_external" (k, n) [N m] of a plant that is pushed."""
    setup: Any = None
    """The `lwr_dyn.simulation.setup.Setup` that was run; None for a run from a file."""
    _repr_html_ = repr_html

    def __post_init__(self) -> None:
        for name in _ARRAYS:
            object.__setattr__(self, name, read_only(getattr(self, name)))
        for name in ("work", "signals"):
            object.__setattr__(self, name, {key: read_only(value) for key, value in getattr(self, name).items()})

    def __repr__(self) -> str:
        robot, end = self.meta.get("robot", "unknown robot"), self.t[-1] if self.t.size else 0.0
        return f"Run({robot}, n={self.n}, {self.t.size} samples to t = {end:g} s, {len(self.events)} events)"

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.q.shape[1])

    @property
    def audit(self) -> Mapping[str, Any]:
        """The audit of energy and inverse dynamics that `simulate` recorded; empty for a run without one."""
        audit: Mapping[str, Any] = self.meta.get("audit", {})
        return audit

    def to_columns(self) -> dict[str, Array]:
        """The run as read-only columns (k,) by name, nothing copied: pandas, polars, pyarrow make a table of them.

        Names are "time [s]", "energy [J]", "work_actuator [J]" ..., and of each joint from 1 "q1 [rad]", "dq1 [rad/s]",
        "q_ref1 [rad]", "dq_ref1 [rad/s]", "tau1 [N m]" (applied), "tau_command1 [N m]", "tau_friction1 [N m]"; m, m/s
        and N if it slides. A run whose record does not say which joints slide has no units of joints in its names.
        Signals follow by their names, with 1, 2, ... where they have several numbers.
        """
        kinds, columns = self.meta.get("joint_units") or [""] * self.n, {"time [s]": self.t}
        for name in _ARRAYS[1:-1]:
            for j, kind in enumerate(kinds):
                unit = _UNITS[name[0]].get(kind, "")
                columns[f"{name.removesuffix('_applied')}{j + 1}{unit}"] = getattr(self, name)[:, j]
        columns |= {"energy [J]": self.energy} | {f"work_{name} [J]": x for name, x in self.work.items()}
        for name, x in self.signals.items():
            columns |= {f"{name}{j + 1}" if x.shape[1] > 1 else name: x[:, j] for j in range(x.shape[1])}
        return columns

    def to_dataframe(self) -> Any:
        """The columns as a `pandas.DataFrame`; `MissingPackageError` without the extra `notebook`."""
        try:
            from pandas import DataFrame
        except ModuleNotFoundError:
            raise MissingPackageError("pandas", "notebook", "columns = run.to_columns()") from None
        return DataFrame(self.to_columns())

    def save(self, path: str | Path) -> None:
        """Write as .npz without pickle, or by its ending in one of `lwr_dyn.model.shown.RUN_FORMATS`.

        Only .npz keeps events and the record and can be loaded. Raises `FileAccessError`, `MissingPackageError`.
        """
        other = format_of(path)
        if other is not None:
            return write_file(path, other(self))
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {f"work_{name}": value for name, value in self.work.items()}
        arrays |= {f"signal_{name}": value for name, value in self.signals.items()}
        events = [[e.t, e.kind, e.joint, e.value] for e in self.events]
        record = {"schema": RUN_SCHEMA, "events": events, "meta": dict(self.meta)}
        arrays["record"] = np.frombuffer(json.dumps(record, sort_keys=True).encode(), dtype=np.uint8)
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **arrays)
        write_file(path, buffer.getvalue())

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a run file; raises `FileAccessError` if it is missing, truncated, no run file or of another schema."""
        allowed = "a run file (.npz) of lwr-dyn simulate"
        check_readable(path, allowed, LARGEST)
        try:
            check_headers(Path(path), _ARRAYS)
            with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as stored:
                arrays = {name: stored[name] for name in stored.files}
            record = json.loads(arrays.pop("record").tobytes())
            if record["schema"] != RUN_SCHEMA:
                raise FileAccessError(str(path), f"run file of schema {record['schema']}", f"schema {RUN_SCHEMA}")
            events, meta = checked_record(record, arrays["q"].shape[1])
            run = cls(
                **{name: real_array(name, arrays[name]) for name in _ARRAYS},
                work={name.removeprefix("work_"): x for name, x in arrays.items() if name.startswith("work_")},
                signals={name.removeprefix("signal_"): x for name, x in arrays.items() if name.startswith("signal_")},
                events=tuple(Event(*event) for event in events), meta=meta,
            )  # fmt: skip
        except FileAccessError:
            raise
        except Exception:
            raise FileAccessError(str(path), "not a whole run file", allowed) from None
        return run
