"""ROS 2 bags of joint states, written by rosbags."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array

FIELDS = ("position", "velocity", "effort")


def write_bag(
    path: Path, topics: Sequence[tuple[str, Sequence[str], Array, dict[str, Array]]], storage: str = "sqlite3",
    stamped: bool = True,
) -> Path:  # fmt: skip
    """A bag of topics (name, joints, times (k,) [s], field -> (k, joints)); without stamps the times of reception."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types: Any = store.types
    Time, Header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    JointState = types["sensor_msgs/msg/JointState"]
    connections: dict[str, Any] = {}
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        for topic, joints, times, fields in topics:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, JointState.__msgtype__, typestore=store)
            for k, t in enumerate(times):
                ns = 1_700_000_000_000_000_000 + round(float(t) * 1e9)
                stamp = Time(sec=ns // 10**9 if stamped else 0, nanosec=ns % 10**9 if stamped else 0)
                rows = {x: np.ascontiguousarray(fields[x][k] if x in fields else [], dtype=np.float64) for x in FIELDS}
                message = JointState(header=Header(stamp=stamp, frame_id=""), name=list(joints), **rows)
                writer.write(connections[topic], ns, store.serialize_cdr(message, JointState.__msgtype__))
    return path
