"""ROS 2 bags (extra `logs`): the `sensor_msgs/JointState` topics of a bag as columns of a log.

A bag is a folder with its metadata.yaml, or one file, .mcap or .db3. Times are those of the messages' headers, or of
reception where a header has none. Each quantity comes from its topic; topics of unequal rates are brought to one clock.
Units are those of the message: rad, m, N m, N (REP 103).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, LogError, MissingPackageError
from lwr_dyn.foundation.files import check_readable
from lwr_dyn.identification.logs.log_columns import GAP, NO_MAP, SI, ColumnMap, Layout, LogColumn

SUFFIXES = (".mcap", ".db3")
LARGEST = 2_000_000_000
"""[bytes] The longest bag."""
MESSAGE = "sensor_msgs/msg/JointState"
FIELDS = ("position", "velocity", "effort")
NEEDED = "a ROS 2 bag: the folder with its metadata.yaml, or its .mcap or .db3 file"


@dataclass(frozen=True, slots=True, eq=False)
class JointStates:
    """The messages of one topic that name the same joints: t (k,) [ns], and field -> (k, joints) where all have it."""

    topic: str
    names: tuple[str, ...]
    t: NDArray[np.int64]
    fields: dict[str, Array]


@dataclass(slots=True, eq=False)
class _Messages:
    t: list[int] = field(default_factory=list)
    rows: dict[str, list[Array]] = field(default_factory=lambda: {name: [] for name in FIELDS})


def is_bag(path: Path) -> bool:
    """Whether a path has the form of a ROS 2 bag."""
    try:
        return path.suffix in SUFFIXES or (path / "metadata.yaml").is_file()
    except (OSError, ValueError):  # a name that no file can have; reading it says so
        return False


def joint_states(path: Path) -> tuple[JointStates, ...]:
    """All joint states of a bag, by topic and by the joints that its messages name, in the order of their times.

    Raises
    ------
    FileAccessError
        No whole bag.
    LogError
        A message with another number of values than joints.
    MissingPackageError
        Without rosbags.
    """
    for part in sorted(path.iterdir()) if path.is_dir() else [path]:
        check_readable(part, NEEDED, LARGEST)
    found: dict[tuple[str, tuple[str, ...]], _Messages] = {}
    reader = _reader(path)
    try:
        with reader:
            wanted = [x for x in reader.connections if x.msgtype == MESSAGE]
            for connection, received, data in reader.messages(wanted) if wanted else ():
                message = reader.deserialize(data, connection.msgtype)
                key = (connection.topic, tuple(message.name))
                _append(str(path), found.setdefault(key, _Messages()), key, message, received)
    except LogError:
        raise
    except Exception:  # a damaged bag: storages and decoders have exceptions of many kinds
        raise _not_whole(path) from None
    return tuple(_stacked(*key, messages) for key, messages in found.items())


def _append(file: str, to: _Messages, key: tuple[str, tuple[str, ...]], message: Any, received: int) -> None:
    stamp = message.header.stamp
    to.t.append(int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec) or received)
    for name, rows in to.rows.items():
        values = getattr(message, name)
        if values.size == len(key[1]):
            rows.append(values)
        elif values.size:
            where = f"topic {key[0]}, message {len(to.t)}"
            raise LogError(file, where, f"{values.size} values of {name} for {len(key[1])} joints", "one each, or none")


def _stacked(topic: str, names: tuple[str, ...], messages: _Messages) -> JointStates:
    t = np.array(messages.t, dtype=np.int64)
    order = np.argsort(t, kind="stable")
    fields = {name: np.array(rows)[order] for name, rows in messages.rows.items() if len(rows) == t.size}
    return JointStates(topic, names, t[order], {x: rows for x, rows in fields.items() if not np.isnan(rows).all()})


def _reader(path: Path) -> Any:
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise MissingPackageError("rosbags", "logs") from None
    try:
        return AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
    except Exception:  # AnyReaderError, and what its YAML reader raises
        raise _not_whole(path) from None


def _not_whole(path: Path) -> FileAccessError:
    return FileAccessError(str(path), "not a whole ROS 2 bag", NEEDED)


FIELD_OF: Mapping[str, str] = {"q": "position", "qm": "position", "dq": "velocity", "tau": "effort", "i": "effort"}
"""Quantity -> field of the message that has it, if the map of columns names no other."""
SLOWER = 0.5
"""Share of the rate of the positions: a slower topic gives the clock, for between its messages nothing is known."""


@dataclass(frozen=True, slots=True, eq=False)
class BagTable:
    """What a bag holds of the wanted quantities: `table` (k, columns) as `layout` has them, time first; `notes`."""

    layout: Layout
    table: Array
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Track:
    """One quantity of all joints: t (k,) [ns], values (k, n), and where from."""

    t: NDArray[np.int64]
    values: Array
    origin: str

    @property
    def step(self) -> float:
        return float(np.median(np.diff(self.t)))


def bag_table(
    path: Path, columns: ColumnMap = NO_MAP, joint_names: Sequence[str] = (), needs: Sequence[str] = ("q", "tau"),
    also: Sequence[str] = (),
) -> BagTable:  # fmt: skip
    """The quantities of a bag on the clock of its positions, or of a topic less than half as fast, where there is one.

    Parameters
    ----------
    columns : ColumnMap
        Quantity -> topic or topic.field (position, velocity, effort); `joints` are the names in the messages. A
        quantity that is not in it is taken from the only topic that has it.
    joint_names : sequence of str
        The robot's.
    needs, also : sequence of str
        Quantities that must be there, and those that are taken where they are.

    Raises
    ------
    FileAccessError, MissingPackageError
        As `joint_states`.
    LogError
        A quantity or joint is missing, two topics have it, or messages of one time contradict each other.
    """
    file, states = str(path), joint_states(path)
    joints = columns.joints or tuple(joint_names)
    if not joints:
        seen = ", ".join(dict.fromkeys(name for one in states for name in one.names)) or "none"
        raise LogError(file, "joints", f"{seen}; their order is not known", "a robot, or joints in --columns")
    notes: list[str] = []
    tracks: dict[str, _Track] = {}
    for quantity in dict.fromkeys((*needs, *also)):
        track = _track(file, states, quantity, columns, joints, quantity in needs)
        if track is not None:
            tracks[quantity] = _each_time_once(file, track, notes)
    base = next(tracks[quantity] for quantity in ("q", "qm", *tracks) if quantity in tracks)
    slowest = max(tracks.values(), key=lambda track: track.step)
    clock = slowest if base.step < SLOWER * slowest.step else base
    notes += [
        f"{file}: {quantity} of {track.origin} ({1e9 / track.step:.4g} Hz) interpolated at the times of {clock.origin} "
        f"({1e9 / clock.step:.4g} Hz)"
        for quantity, track in tracks.items()
        if not np.array_equal(track.t, clock.t)
    ]
    inside = np.logical_and.reduce([_covered(track.t, clock.t) for track in tracks.values()])
    if not inside.all():
        notes.append(f"{file}: {int((~inside).sum())} of {inside.size} rows left out, where a topic has no messages")
    parts = [_at(track, clock.t, quantity in ("q", "qm"))[inside] for quantity, track in tracks.items()]
    table = np.column_stack([(clock.t[inside] - clock.t[0]) * 1e-9, *parts])
    made = [LogColumn(0, "time", 0, SI["time"], clock.origin)]
    for quantity, track in tracks.items():
        made += [LogColumn(len(made) + j, quantity, j + 1, SI[quantity], track.origin) for j in range(len(joints))]
    layout = Layout(tuple(range(1, len(joints) + 1)), {column.name: column for column in made})
    return BagTable(layout, table, tuple(notes))


def _track(
    file: str, states: Sequence[JointStates], quantity: str, columns: ColumnMap, joints: tuple[str, ...], must: bool
) -> _Track | None:
    """The quantity from the topic of the map, or from the only one that has it for these joints."""
    topic, field = "", FIELD_OF[quantity]
    if quantity in columns.columns:
        topic, _, own = columns.columns[quantity][0].partition(".")
        field = own or field
        if field not in FIELDS:
            raise LogError(file, f"{quantity} of --columns", f"field {field!r}", ", ".join(FIELDS))
    having = [one for one in states if field in one.fields and one.topic == (topic or one.topic)]
    fitting = [one for one in having if set(joints) <= set(one.names)]
    if len(fitting) == 1:
        (one,) = fitting
        if one.t.size < 2:
            raise LogError(file, f"topic {one.topic}", f"{one.t.size} message", "a recording of at least a second")
        order = [one.names.index(name) for name in joints]
        return _Track(one.t, one.fields[field][:, order], f"{one.topic}.{field}")
    if not fitting and not must:
        return None
    if fitting:
        found = f"{field} of these joints in {', '.join(one.topic for one in fitting)}"
        raise LogError(file, quantity, found, f"one topic: --columns {quantity}=TOPIC")
    listed = "; ".join(f"{one.topic}: {', '.join(one.names)}" for one in having) or "no such topic"
    raise LogError(file, quantity, f"{field} in {listed}", f"a topic with the joints {', '.join(joints)}")


def _each_time_once(file: str, track: _Track, notes: list[str]) -> _Track:
    """The track without messages that came twice; two of one time that differ are refused."""
    again = np.flatnonzero(np.diff(track.t) == 0) + 1
    if not again.size:
        return track
    differ = np.flatnonzero((track.values[again] != track.values[again - 1]).any(axis=1))
    if differ.size:
        row = int(again[differ[0]])
        joint = int(np.argmax(track.values[row] != track.values[row - 1]))
        before, after = track.values[row - 1 : row + 1, joint]
        found = f"{before:.6g} and {after:.6g} at the same time, joint {joint + 1}"
        where = f"{track.origin}, messages {row} and {row + 1}"
        more = f" ({differ.size} such pairs)" if differ.size > 1 else ""
        raise LogError(file, where, found + more, "one publisher, and one message a time")
    notes.append(f"{file}: {again.size} messages of {track.origin} came twice and count once")
    return _Track(np.delete(track.t, again), np.delete(track.values, again, axis=0), track.origin)


def _covered(t: NDArray[np.int64], at: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which times lie between two messages that have no gap between them."""
    after = np.searchsorted(t, at)
    exact = t[np.minimum(after, t.size - 1)] == at
    inner = (after > 0) & (after < t.size)
    steps = np.diff(t)
    near = steps[np.clip(after - 1, 0, steps.size - 1)] <= GAP * np.median(steps)
    return np.asarray(exact | (inner & near))


def _at(track: _Track, t: NDArray[np.int64], smooth: bool) -> Array:
    """The values at other times (m, n): positions by cubic splines, the others linearly."""
    if np.array_equal(track.t, t):
        return track.values
    own, other = (track.t - t[0]) * 1e-9, (t - t[0]) * 1e-9
    if smooth:
        return np.asarray(CubicSpline(own, track.values)(other))
    return np.column_stack([np.interp(other, own, column) for column in track.values.T])
