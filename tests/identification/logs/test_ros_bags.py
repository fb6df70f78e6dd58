"""A bag gives the log that was written into it, topics of unequal rates too; what it leaves open is refused by name."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError, LogError, MissingPackageError
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.identification.logs.log_columns import ColumnMap, column_map
from lwr_dyn.identification.logs.ros_bags import joint_states
from tests.identification.bags import write_bag

NAMES = tuple(f"joint_{j}" for j in range(1, 8))
T = np.arange(0, 1000, 5) * 1e-3


def motion(t, n=7):
    w = np.arange(1, n + 1)
    return np.sin(np.outer(t, w)), np.outer(np.cos(3 * t), w), np.cos(np.outer(t, w)) * w


@pytest.mark.slow
@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("stamped", [True, False])
def test_a_bag_gives_back_what_was_written(storage, stamped, wam, tmp_path):
    q, tau, dq = motion(T)
    q = 0.5 * q + [0, 0, 0, 1.0, -1.0, 0, 0]
    mixed = [3, 1, 0, 2, 6, 5, 4]
    fields = {"position": q[:, mixed], "velocity": 0.5 * dq[:, mixed], "effort": 0.3 * tau[:, mixed]}
    arm = ("/joint_states", [NAMES[j] for j in mixed], T, fields)
    hand = ("/joint_states", ["finger"], T, {"position": T[:, None]})
    bag = write_bag(tmp_path / "bag", [arm, hand], storage, stamped)
    log = read_log(bag, arm=wam)
    assert np.array_equal([log.q, log.tau, log.dq], [q, 0.3 * tau, 0.5 * dq])
    assert (np.abs(log.t - T).max() < 1e-9, log.notes) == (True, ())
    (file,) = bag.glob("*.mcap") if storage == "mcap" else bag.glob("*.db3")
    assert (read_log(file, arm=wam).q == q).all()


def rates(fast, slow, slow_is, tmp_path, hole=False):
    t, s = np.arange(0, 3, 1 / fast), np.arange(0.0017, 2.9, 1 / slow)
    if hole:
        s = s[(s < 1.0) | (s > 1.5)]
    at = {"q": s if slow_is == "q" else t, "tau": s if slow_is == "tau" else t}
    topics = [
        ("/positions", ("a", "b"), at["q"], {"position": motion(at["q"], 2)[0]}),
        ("/torques", ("a", "b"), at["tau"], {"effort": motion(at["tau"], 2)[1]}),
    ]
    return read_log(write_bag(tmp_path / "bag", topics), columns=ColumnMap({}, joints=("a", "b")))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fast", "slow", "slow_is", "clock"), [(500, 333, "tau", 500), (500, 100, "tau", 100), (500, 100, "q", 100)]
)
def test_topics_of_unequal_rates_come_to_one_clock(fast, slow, slow_is, clock, tmp_path):
    log = rates(fast, slow, slow_is, tmp_path)
    assert np.median(np.diff(log.t)) == pytest.approx(1 / clock, rel=1e-3)
    start = 0.0017 if clock == 100 else 0.0
    q, tau, _ = motion(log.t + start, 2)
    assert np.abs(log.q - q).max() < 1e-7
    assert (
        np.abs(log.tau - tau).max() < 2 * 9 / 8 / (slow if slow_is == "tau" else fast) ** 2
    )  # a parabola between two rows
    assert any("interpolated at the times of" in note and " Hz)" in note for note in log.notes)
    assert log.t[-1] <= 2.9


def test_where_a_topic_has_a_hole_there_are_no_rows(tmp_path):
    log = rates(500, 333, "tau", tmp_path, hole=True)
    assert not ((log.t > 1.003) & (log.t < 1.497)).any()
    assert any("rows left out, where a topic has no messages" in note for note in log.notes)
    assert np.abs(log.tau - motion(log.t, 2)[1]).max() < 1e-4


def states(**fields):
    return ("/joint_states", ("a", "b"), T, {name: values[:, :2] for name, values in fields.items()})


Q, TAU, _ = motion(T)
TWICE = np.sort(np.concatenate([T, T[50:60]]))
SAME = np.concatenate([np.arange(50), np.repeat(np.arange(50, 60), 2), np.arange(60, T.size)])
BAD = {
    "no effort": ([states(position=Q)], "tau: effort in no such topic; needed: a topic with the joints a, b"),
    "other joints": (
        [("/s", ("x", "b"), T, {"position": Q[:, :2], "effort": TAU[:, :2]})],
        "q: position in /s: x, b; needed: a topic with the joints a, b",
    ),
    "two topics": (
        [states(position=Q, effort=TAU), ("/copy", ("a", "b"), T, {"position": Q[:, :2]})],
        "q: position of these joints in /joint_states, /copy; needed: one topic: --columns q=TOPIC",
    ),
    "contradiction": (
        [("/s", ("a", "b"), TWICE, {"position": Q[np.argsort(np.argsort(TWICE)) % 200, :2], "effort": TAU[SAME, :2]})],
        "/s.position, messages 51 and 52: 0.247404 and 0.252245 at the same time",
    ),
    "nan": ([states(position=Q, effort=np.where(T[:, None] == 0.5, np.nan, TAU))], "row 101, column tau1 (/joint_sta"),
    "one message": ([("/s", ("a",), T[:1], {"position": Q[:1, :1], "effort": Q[:1, :1]})], "topic /s: 1 message"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bag_that_cannot_be_used_is_refused(case, tmp_path):
    topics, message = BAD[case]
    names = topics[0][1] if case == "one message" else ("a", "b")
    with pytest.raises(LogError) as caught:
        read_log(write_bag(tmp_path / "bag", topics), columns=ColumnMap({}, joints=names))
    assert message in str(caught.value)


def test_the_map_chooses_topic_and_field_and_messages_that_came_twice_count_once(tmp_path):
    topics = [
        ("/s", ("a", "b"), TWICE, {"position": Q[SAME, :2], "effort": TAU[SAME, :2]}),
        ("/copy", ("a", "b"), T, {"position": 2 * Q[:, :2], "effort": 2 * TAU[:, :2]}),
    ]
    bag = write_bag(tmp_path / "bag", topics)
    log = read_log(bag, columns=ColumnMap({"q": ("/s",), "tau": ("/s",)}, joints=("a", "b")))
    assert (log.q == Q[:, :2]).all()
    assert sum("10 messages of /s" in note and "came twice and count once" in note for note in log.notes) == 2
    chosen = ColumnMap({"q": ("/copy",), "i": ("/s.effort",), "tau": ("/copy",)}, joints=("b", "a"))
    log = read_log(bag, columns=chosen, needs=("q", "tau", "i"))
    assert np.array_equal([log.q, log.tau, log.current], [2 * Q[:, 1::-1], 2 * TAU[:, 1::-1], TAU[:, 1::-1]])
    with pytest.raises(LogError, match="tau of --columns: field 'torque'; needed: position, velocity, effort"):
        read_log(bag, columns=ColumnMap({"q": ("/s",), "tau": ("/s.torque",)}, joints=("b", "a")))
    with pytest.raises(LogError, match=r"joints: a, b; their order is not known; needed: a robot, or joints"):
        read_log(bag, columns=column_map("q=/s,tau=/s"))


def test_what_is_no_bag(tmp_path, monkeypatch):
    bag = write_bag(tmp_path / "bag", [states(position=Q, effort=TAU)])
    (file,) = bag.glob("*.db3")
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2])
    (tmp_path / "x.mcap").write_bytes(b"\x89MCAP0\r\nand nothing")
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "metadata.yaml").write_text("rosbag2_bagfile_information: [")
    for path in (bag, tmp_path / "x.mcap", tmp_path / "none"):
        with pytest.raises(FileAccessError, match="not a whole ROS 2 bag; allowed: a ROS 2 bag: the folder with its"):
            joint_states(path)
    monkeypatch.setitem(__import__("sys").modules, "rosbags.highlevel", None)
    with pytest.raises(MissingPackageError, match=r"pip install 'lwr_dyn\[logs\]'"):
        joint_states(bag)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_damaged_bags_are_refused_by_name_or_read(storage, tmp_path):
    """Bytes changed anywhere, in the metadata too: an error of ours, never one of the storage."""
    bag = write_bag(tmp_path / "bag", [states(position=Q, effort=TAU)], storage)
    whole = {file: file.read_bytes() for file in sorted(bag.iterdir())}
    rng, refused = np.random.default_rng(0), 0
    for _ in range(25):
        for file, data in whole.items():
            changed = np.frombuffer(data, dtype=np.uint8).copy()
            changed[rng.integers(changed.size, size=5)] = rng.integers(256, size=5)
            file.write_bytes(changed.tobytes())
        try:
            read_log(bag, columns=ColumnMap({}, joints=("a", "b")))
        except (LogError, FileAccessError):
            refused += 1
    assert refused > 10
