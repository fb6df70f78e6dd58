"""Records of movement: `Motion` is a reference, `Run` a simulated result; a run file carries its own metadata.

A run file is looked at before its arrays are unpacked, and its record before it is believed. Results show themselves:
a short text, and HTML in a notebook where an optional package makes it.
"""

import copy
import io
import json
import math
import textwrap
import zipfile
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Protocol, Self

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays, read_only, real_array
from lwr_dyn.foundation.errors import FileAccessError, MissingPackageError, OptionError
from lwr_dyn.foundation.files import check_readable, write_file
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.caveats import ALL, DYNAMICS

NOTEBOOK_FORMS: Registry[Callable[[Any], str]] = Registry(
    "notebook_form", {"html": Row("lwr_dyn.pages.document:html_of", "a result as small HTML")}
)
"""How a notebook shows a result."""

RUN_FORMATS: Registry[Callable[[Any], bytes]] = Registry(
    "run_format",
    {
        ".csv": Row("lwr_dyn.model.run_formats:csv_bytes", "text, every number to its last bit"),
        ".parquet": Row("lwr_dyn.model.run_formats:parquet_bytes", "Parquet", "logs", {"package": "pyarrow"}),
        ".mat": Row("lwr_dyn.model.run_formats:matlab_bytes", "MATLAB"),
        ".mcap": Row("lwr_dyn.arms.export.run_bag:mcap_bytes", "ROS 2 bag", "logs", {"package": "rosbags"}),
    },
)
"""Ending of a file -> a run as its bytes; .npz is `Run.save`'s own. The fact `package` is what its extra must bring."""

_WIDTH, _LINES = 110, 5


def format_of(path: str | Path) -> Callable[[Any], bytes] | None:
    """What makes a run the bytes of a file of this ending; None for .npz.

    Raises `FileAccessError` for an ending that no format has, `MissingPackageError` for a format that is not installed.
    """
    suffix = Path(path).suffix
    if suffix != ".npz" and suffix not in RUN_FORMATS.names:
        known = ", ".join((".npz", *RUN_FORMATS.names))
        raise FileAccessError(str(path), f"ends in {suffix or 'nothing'!r}", f"a path that ends in one of {known}")
    if suffix == ".npz":
        return None
    row = RUN_FORMATS[suffix]
    package = row.facts.get("package")
    if package is not None and find_spec(package) is None:
        raise MissingPackageError(package, row.extra)
    return RUN_FORMATS.load(suffix)


def short_repr(value: Any) -> str:
    """A record in at most five lines: arrays by their shape, rows by their number."""
    parts = [f"{f.name}={_shortly(getattr(value, f.name))}" for f in fields(value) if f.repr]
    text = f"{type(value).__name__}({', '.join(parts)})"
    return "\n".join(textwrap.wrap(text, _WIDTH, max_lines=_LINES, subsequent_indent="  ", placeholder=" ...)"))


def _shortly(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"array{value.shape}"
    if value is None or isinstance(value, str | int | float):
        return textwrap.shorten(repr(value), 60)
    if isinstance(value, Mapping | Sequence):
        return f"{len(value)} {'entry' if len(value) == 1 else 'entries'}"
    return type(value).__name__


def repr_html(value: Any) -> str | None:
    """What a notebook shows."""
    return NOTEBOOK_FORMS.load("html")(value)


LARGEST = 2_000_000_000
"""[bytes] The longest run file, and the most that its arrays take in memory."""
PER_TIME = ("t", "energy")
"""Arrays with one number a time; the others have one a joint."""

_META: Mapping[str, type] = {
    "robot": str, "reading": str, "file": str, "digest": str, "plant": dict, "task": str,
    "hint": str, "note": dict, "loaded_with": dict, "audit": dict, "payload": dict, "joint_units": list,
}  # fmt: skip
"""Entries of the record that other modules read, if they are there."""


def check_headers(path: Path, names: tuple[str, ...]) -> None:
    """Raise `ValueError`, before anything is unpacked, unless the arrays fit together and are not too large."""
    with zipfile.ZipFile(path) as archive:
        shapes = {name.removesuffix(".npy"): _shape(archive, name) for name in archive.namelist()}
    k, n = shapes["q"]
    expected = {name: (k,) if name in PER_TIME else (k, n) for name in names}
    expected |= {name: (k,) for name in shapes if name.startswith("work_")}
    expected |= {name: (k, shapes[name][-1]) for name in shapes if name.startswith("signal_")}
    wrong = [name for name, shape in expected.items() if shapes[name] != shape]
    if wrong or n < 1 or 8 * sum(map(math.prod, shapes.values())) > LARGEST:
        raise ValueError("shapes")


def _shape(archive: zipfile.ZipFile, name: str) -> tuple[int, ...]:
    with archive.open(name) as stream:
        version = np.lib.format.read_magic(stream)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, dtype = read(stream)
    if dtype.kind not in "fiu":
        raise ValueError(name)
    return tuple(shape)


def checked_record(record: Any, n: int) -> tuple[list[tuple[float, str, int | None, float | None]], dict[str, Any]]:
    """Events and facts of a record; raises `ValueError` or `TypeError` for a value of another kind."""
    events = [_event(row, n) for row in record["events"]]
    meta = {} | record["meta"]
    for name, kind in _META.items():
        if not isinstance(meta.get(name), kind | None):
            raise TypeError(name)
    if len(meta.get("joint_units") or range(n)) != n:
        raise ValueError("joint_units")
    return events, meta


def _event(row: Any, n: int) -> tuple[float, str, int | None, float | None]:
    t, kind, joint, value = row
    if not (isinstance(kind, str) and math.isfinite(t) and (value is None or math.isfinite(value))):
        raise ValueError("event")
    if joint is not None and not (type(joint) is int and 0 <= joint < n):
        raise ValueError("joint")
    return float(t), kind, joint, None if value is None else float(value)


RUN_SCHEMA = 1
_ARRAYS = ("t", "q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction", "energy")

_UNITS = {
    "q": {"rad": " [rad]", "m": " [m]"}, "d": {"rad": " [rad/s]", "m": " [m/s]"}, "t": {"rad": " [N m]", "m": " [N]"}
}  # fmt: skip
"""First letter of an array -> the unit in the name of its column, for a joint that turns or slides."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Joint motion over time with its derivatives: t (k,) [s], q (k, n) [rad or m], dq and ddq (k, n) [per s, per s^2].

    What `Reference.sample` returns; the arrays are copied, and read-only.
    """

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


def reference_argument(reference: Any) -> None:
    """Raise `OptionError` for anything but a `Reference`; of a function it says how it becomes one."""
    if callable(reference) and not hasattr(reference, "sample"):
        name = getattr(reference, "__name__", type(reference).__name__)
        raise OptionError("reference", f"the function {name}", "lwr_dyn.reference(function, arm, duration=...)")
    if not hasattr(reference, "sample"):
        raise OptionError("reference", repr(reference), "a Reference, with `sample(t)` and `duration`")


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a run, at one joint (0-based) or at none: impact, stick, slip, ..."""

    t: Annotated[float, "s."]
    kind: Annotated[str, "Its name: stop, release, stick, slip, ..."]
    joint: Annotated[int | None, "From 0; null of none."] = None
    value: Annotated[float | None, "Of its kind, as the speed at an impact."] = None


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
        hint = f"; {self.hint}" if self.hint else ""
        return f"Run({robot}, n={self.n}, {self.t.size} samples to t = {end:g} s, {len(self.events)} events{hint})"

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.q.shape[1])

    @property
    def audit(self) -> Mapping[str, Any]:
        """The audit of energy and inverse dynamics that `simulate` recorded; empty for a run without one."""
        audit: Mapping[str, Any] = self.meta.get("audit", {})
        return audit

    @property
    def hint(self) -> str:
        """Which option would make such a run at least 5 times as fast, and how many times; empty for none."""
        return str(self.meta.get("hint", ""))

    def with_meta(self, meta: Mapping[str, Any]) -> Self:
        """The run with another record; its arrays, which are read-only, are shared."""
        out = copy.copy(self)
        object.__setattr__(out, "meta", meta)
        return out

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
        """Write as .npz without pickle, or by its ending in one of `lwr_dyn.model.run.RUN_FORMATS`.

        Only .npz keeps events and the record and can be loaded. Raises `FileAccessError`, `MissingPackageError`.
        """
        other = format_of(path)
        if other is not None:
            return write_file(path, other(self))
        write_file(path, self.to_npz())

    def to_npz(self) -> bytes:
        """What `save` writes as .npz; most of its time other threads can run."""
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {f"work_{name}": value for name, value in self.work.items()}
        arrays |= {f"signal_{name}": value for name, value in self.signals.items()}
        events = [[e.t, e.kind, e.joint, e.value] for e in self.events]
        record = {"schema": RUN_SCHEMA, "events": events, "meta": dict(self.meta)}
        arrays["record"] = np.frombuffer(json.dumps(record, sort_keys=True).encode(), dtype=np.uint8)
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **arrays)
        return buffer.getvalue()

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
        if not (np.diff(run.t) > 0.0).all():
            raise FileAccessError(str(path), "times that do not rise from sample to sample", allowed)
        return run


def run_used(run: Run) -> Collection[str]:
    """The numbers of its arm that a run stands on: those of the gears too where joints are elastic."""
    return DYNAMICS if run.meta.get("elasticity") is None else ALL
