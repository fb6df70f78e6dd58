"""Messages of ROS 2 bags (extra `logs`): the `sensor_msgs/JointState` topics of a bag as arrays.

A bag is a folder with its metadata.yaml, or one file, .mcap or .db3. Times are those of the messages' headers, or of
reception where a header has none.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, LogError, MissingPackageError
from lwr_dyn.foundation.files import check_readable

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
