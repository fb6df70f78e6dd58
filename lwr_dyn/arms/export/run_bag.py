"""A run as a ROS 2 bag in one file, MCAP (extra `logs`): joint states of arm and reference, and the URDF of its arm.

Topics of `sensor_msgs/JointState`, with the joints' names in the URDF and a message a sample:

/joint_states  q, dq, and as effort the torque that the motors applied
/reference     q_ref, dq_ref, and as effort the torque that the controller asked for
/friction      as effort the torque of the joints' friction; no position, no velocity

`/robot_description` holds the URDF, `/lwr_dyn/record` the record of the run as JSON, each as one `std_msgs/String`
that late listeners get too. Every float64 is kept to its last bit; times are the run's own, from 0, in whole
nanoseconds. rosbags writes; the tests read with the reader of MCAP's own authors.

References: MCAP format specification 0; ROS REP 103 (units), REP 149 (message definitions by hash).
"""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.model.run import Run

TOPICS = {
    "/joint_states": ("q", "dq", "tau_applied"),
    "/reference": ("q_ref", "dq_ref", "tau_command"),
    "/friction": ("", "", "tau_friction"),
}
"""Topic -> the arrays of a run that are its positions, velocities and efforts; empty for none."""
DESCRIPTION, RECORD = "/robot_description", "/lwr_dyn/record"
BILLION = 1_000_000_000
_STATE, _STRING = "sensor_msgs/msg/JointState", "std_msgs/msg/String"


def mcap_bytes(run: Run) -> bytes:
    """The file; the same bytes again for the same run and versions of packages.

    Raises
    ------
    OptionError, FileAccessError
        As `lwr_dyn.arms.loading.arm_of`: the arm of the run is not known, or its file is gone or has changed.
    """
    arm, store = arm_of(run), get_typestore(Stores.ROS2_HUMBLE)
    record = json.dumps(dict(run.meta), sort_keys=True)  # as in a run file, so that a loaded run gives the same bytes
    with TemporaryDirectory() as folder:
        bag = Writer(Path(folder) / "run", version=Writer.VERSION_LATEST, storage_plugin=StoragePlugin.MCAP)
        bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with bag:
            _write_texts(bag, store, {DESCRIPTION: urdf_text(arm), RECORD: record})
            _write_states(bag, store, run, arm.joint_names)
        return (Path(folder) / "run" / "run.mcap").read_bytes()


def _write_texts(bag: Any, store: Any, texts: dict[str, str]) -> None:
    """A message each, before all others, kept for listeners that come later."""
    forever = QosTime(2147483647, 4294967295)
    kept = Qos(
        QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL, forever, forever,
        QosLiveliness.AUTOMATIC, forever, False,
    )  # fmt: skip
    for topic, text in texts.items():
        connection = bag.add_connection(topic, _STRING, typestore=store, offered_qos_profiles=[kept])
        bag.write(connection, 0, store.serialize_cdr(store.types[_STRING](data=text), _STRING))


def _write_states(bag: Any, store: Any, run: Run, names: tuple[str, ...]) -> None:
    """A message a sample on each topic."""
    state, header, time = (
        store.types[x] for x in (_STATE, "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )  # fmt: skip
    nothing = np.empty((run.t.size, 0))
    rows = {topic: [getattr(run, x) if x else nothing for x in arrays] for topic, arrays in TOPICS.items()}
    connections = {topic: bag.add_connection(topic, _STATE, typestore=store) for topic in rows}
    for k, ns in enumerate(round(float(t) * BILLION) for t in run.t):
        stamp = header(stamp=time(sec=ns // BILLION, nanosec=ns % BILLION), frame_id="")
        for topic, (position, velocity, effort) in rows.items():
            message = state(
                header=stamp, name=list(names), position=position[k], velocity=velocity[k], effort=effort[k]
            )
            bag.write(connections[topic], ns, store.serialize_cdr(message, _STATE))
