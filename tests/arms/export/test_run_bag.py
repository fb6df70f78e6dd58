"""A run in a bag of MCAP comes back to the last bit by the reader of MCAP's own authors, and by ours."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import lwr_dyn
from lwr_dyn.arms.export.run_bag import DESCRIPTION, RECORD, mcap_bytes
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.identification.logs.log_columns import column_map
from tests.random_arms import random_arm

FIELDS = ("position", "velocity", "effort")
TOPICS = {
    "/joint_states": ("q", "dq", "tau_applied"),
    "/reference": ("q_ref", "dq_ref", "tau_command"),
    "/friction": (None, None, "tau_friction"),
}


@pytest.fixture(scope="module")
def run(arm):
    move = lwr_dyn.reference("point-to-point", arm, start=[0.0] * 7, end=[0.1] * 7, duration=0.3)
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("pd-gravity", arm), move)
    return replace(run, t=run.t + 2.25)


@pytest.fixture(scope="module")
def bag(run, tmp_path_factory):
    path = tmp_path_factory.mktemp("bag") / "run.mcap"
    run.save(path)
    return path


def messages_of(path, *topics):
    """(topic, message) of some topics, in the order of the file."""
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [(channel.topic, ros) for _, channel, _, ros in reader.iter_decoded_messages(topics)]


def test_the_official_reader_gets_every_bit_of_every_topic_back(run, arm, bag):
    for topic, arrays in TOPICS.items():
        messages = [x for _, x in messages_of(bag, topic)]
        assert len(messages) == run.t.size
        assert {tuple(x.name) for x in messages} == {arm.joint_names}
        stamps = np.array([x.header.stamp.sec + 1e-9 * x.header.stamp.nanosec for x in messages])
        assert np.abs(stamps - run.t).max() < 1e-9
        for field, name in zip(FIELDS, arrays, strict=True):
            rows = np.array([getattr(x, field) for x in messages])
            assert rows.tobytes() == (getattr(run, name).tobytes() if name else b"")


def test_urdf_and_record_come_first_and_wait_for_late_listeners(run, arm, bag):
    texts = {topic: x.data for topic, x in messages_of(bag, DESCRIPTION, RECORD)}
    assert texts[DESCRIPTION] == lwr_dyn.urdf_text(arm)
    assert json.loads(texts[RECORD])["digest"] == run.meta["digest"]
    with open(bag, "rb") as stream:
        summary = make_reader(stream).get_summary()
    forever = "".join(f"  {x}:\n    nsec: {2**32 - 1}\n    sec: {2**31 - 1}\n" for x in ("deadline", "lifespan"))
    for channel in summary.channels.values():
        waits, profile = channel.topic in (DESCRIPTION, RECORD), channel.metadata["offered_qos_profiles"]
        assert ("depth: 1\n  durability: transient_local\n  history: keep_last" in profile) == waits
        assert all((line in profile) == waits for line in forever.splitlines(keepends=True))
    ends = (summary.statistics.message_start_time, summary.statistics.message_end_time)
    assert ends == (0, round(1e9 * run.t[-1])) == (0, 2_550_000_000)
    assert summary.statistics.message_count == 2 + 3 * run.t.size


def test_identify_reads_it_as_a_log_and_a_file_of_the_run_gives_the_same_bytes(run, arm, bag, tmp_path):
    log = read_log(bag, arm=arm, columns=column_map(*(f"{x}=/joint_states" for x in ("q", "dq", "tau"))))
    for name, values in (("q", run.q), ("dq", run.dq), ("tau", run.tau_applied)):
        assert (getattr(log, name) == values).all()
    run.save(tmp_path / "run.npz")
    same = mcap_bytes(lwr_dyn.Run.load(tmp_path / "run.npz")) == bag.read_bytes()
    assert same  # pytest would look for the difference of two long texts for minutes


def test_a_sliding_joint_and_an_arm_made_in_python_have_a_bag(tmp_path):
    own = random_arm(1, "PR")
    hold = lwr_dyn.reference("hold", own, q=[0.1] * own.n, duration=0.01)
    run = lwr_dyn.simulate(own, lambda *_: np.zeros(own.n), hold)
    run.save(tmp_path / "run.mcap")
    first = messages_of(tmp_path / "run.mcap", "/joint_states")[0][1]
    assert list(first.position) == run.q[0].tolist()


def test_without_its_arm_or_package_a_run_is_refused_and_no_file_is_left(run, tmp_path, monkeypatch):
    with pytest.raises(OptionError, match="does not say of which robot"):
        replace(run, setup=None, meta={}).save(tmp_path / "x.mcap")
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(MissingPackageError, match=r"rosbags is not installed.*lwr_dyn\[logs\]"):
        run.save(tmp_path / "x.mcap")
    assert list(tmp_path.iterdir()) == []
