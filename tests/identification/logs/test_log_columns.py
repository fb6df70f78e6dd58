"""A map of columns reads a file with names of its own as the same log; units that are open are asked for."""

import re

import numpy as np
import pytest

from lwr_dyn.foundation.errors import FileAccessError, LogError, LwrDynError, OptionError
from lwr_dyn.identification.logs.joint_log import JointLog, read_log, write_log
from lwr_dyn.identification.logs.log_columns import ColumnMap, column_map
from lwr_dyn.model.friction import symmetric
from tests.identification.simulated import ideal_cruise
from tests.random_arms import random_arm

LOG = ideal_cruise([symmetric(2.0, 0.5), symmetric(1.0, 0.3)], (0.1, -0.2))


def table(names, factors=(1.0, 1.0, 1.0, 1.0, 1.0)):
    columns = np.column_stack([LOG.t, LOG.q, LOG.tau]) * factors
    return "\n".join([",".join(names), *(",".join(repr(float(x)) for x in row) for row in columns)]) + "\n"


MAPS = {
    "counted from 0": (("stamp [s]", "pos_0 [rad]", "pos_1 [rad]", "eff_0 [N m]", "eff_1 [N m]"), "pos_*", "eff_*"),
    "counted from 1": (("stamp (s)", "1.p (rad)", "2.p (rad)", "1.e (N m)", "2.e (N m)"), "*.p", "*.e"),
    "out of order": (("stamp [s]", "pos_1 [rad]", "pos_2 [rad]", "eff_1 [N m]", "eff_2 [N m]"), "pos_*", "eff_*"),
    "by names": (
        ("stamp [s]", "p.base [rad]", "p.arm [rad]", "T base [N m]", "T arm [N m]"), "p.*", ["T base", "T arm"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", MAPS)
def test_a_map_reads_the_same_log(case, tmp_path):
    names, q, tau = MAPS[case]
    text = table(names)
    if case == "out of order":
        rows = [line.split(",") for line in text.splitlines()]
        text = "\n".join(",".join(row[i] for i in (4, 2, 0, 1, 3)) for row in rows) + "\n"
    (tmp_path / "x.csv").write_text(text)
    (tmp_path / "map.toml").write_text(f'time = "stamp"\nq = "{q}"\ntau = {tau!r}\njoints = ["base", "arm"]\n')
    log = read_log(tmp_path / "x.csv", columns=column_map(tmp_path / "map.toml"))
    assert all(np.array_equal(getattr(log, name), getattr(LOG, name)) for name in ("t", "q", "tau"))


def test_a_joint_that_slides_has_no_columns_of_one_that_turns_and_the_other_way_round(tmp_path):
    (tmp_path / "x.csv").write_text(table(("time [s]", "q1 [deg]", "q2 [mm]", "tau1 [N m]", "tau2 [N]")))
    read_log(tmp_path / "x.csv", arm=random_arm(1, "RP"))
    for kinds, fault in (("PP", "q1: [deg], but the joint slides"), ("RR", "q2: [mm], but the joint turns")):
        with pytest.raises(LogError, match=re.escape(fault)):
            read_log(tmp_path / "x.csv", arm=random_arm(1, kinds))


def test_names_of_the_robots_joints_stand_for_the_star(wam, tmp_path):
    log = ideal_cruise(wam.friction, np.full(7, 0.1), wam)
    write_log(tmp_path / "x.csv", log)
    text = (tmp_path / "x.csv").read_text()
    for j in range(7, 0, -1):
        text = text.replace(f"q{j} ", f"position/joint_{j} ").replace(f"tau{j} ", f"effort/joint_{j} ")
    (tmp_path / "x.csv").write_text(text)
    back = read_log(tmp_path / "x.csv", arm=wam, columns=column_map("q=position/*,tau=effort/*"))
    assert (back.q == log.q).all()
    with pytest.raises(LogError, match=r"columns of q: none fits position/\*; the file has time, position/joint_1"):
        read_log(tmp_path / "x.csv", columns=column_map("q=position/*,tau=effort/*"))


def test_units_of_mapped_columns_are_asked_for_and_taken_from_the_map_or_the_command(tmp_path):
    deg = 180 / np.pi
    path = tmp_path / "x.csv"
    path.write_text(table(("stamp", "p1", "p2", "e1", "e2"), (1e3, deg, deg, 1.0, 1.0)))
    text = "time=stamp,q=p*,tau=e*"
    with pytest.raises(LogError, match=r"x.csv: column time \(stamp\): no unit; needed: --units time=UNIT with one of"):
        read_log(path, columns=column_map(text))
    with pytest.raises(LogError, match=r"column tau1 \(e1\): no unit; needed: --units tau=UNIT with one of N m, "):
        read_log(path, {"time": "ms", "q": "deg"}, columns=column_map(text))
    (tmp_path / "map.toml").write_text(
        'time = "stamp"\nq = "p*"\ntau = "e*"\n[units]\ntime = "ms"\nq = "deg"\ntau = "N m"\n'
    )
    for log in (
        read_log(path, {"time": "ms", "q": "deg", "tau": "N m"}, columns=column_map(text)),
        read_log(path, columns=column_map(tmp_path / "map.toml")),
    ):
        assert max(np.abs(log.q - LOG.q).max(), np.abs(log.t - LOG.t).max()) < 1e-15


MISFITS = {
    "columns: joints numbered from 0 and from 1; needed": (("t", "p0", "p1", "e1", "e2"), "time=t,q=p*,tau=e*"),
    "columns of q: two for one joint; needed: one each": (("t", "p1", "p1", "e1", "e2"), "time=t,q=p*,tau=e*"),
    "columns of time: none fits T; the file has t, p1, p2, e1, e2": (("t", "p1", "p2", "e1", "e2"), "time=T"),
    "columns: q1, tau2 missing; the file has time, q2": (("time", "q1", "p2", "e1", "tau1"), "q=p*"),
}


@pytest.mark.parametrize("message", MISFITS)
def test_a_map_that_does_not_fit_is_refused(message, tmp_path):
    names, columns = MISFITS[message]
    (tmp_path / "x.csv").write_text(table(names))
    with pytest.raises(LogError) as caught:
        read_log(tmp_path / "x.csv", {"time": "s", "q": "rad", "tau": "N m"}, columns=column_map(columns))
    assert message in str(caught.value)


BAD_FILES = {
    "q = 5": r"bad.toml: q: 5; allowed: a name, a name with \*, or a list of names",
    'q = ["a", 5]': r"bad.toml: q: \['a', 5\]; allowed: a name",
    'speed = "v*"': "bad.toml: 'speed'; allowed: QUANTITY=NAME with time, q, dq, tau, qm, i",
    'units = "deg"': "bad.toml: units: 'deg'; allowed: a table of quantity = unit",
    'joints = "a"': "bad.toml: joints: 'a'; allowed: a list of names",
    '[units]\nq = "turns"': "units of q: 'turns'; allowed: rad, deg",
    "q = ": "bad.toml: not TOML",
}


@pytest.mark.parametrize("text", BAD_FILES)
def test_a_map_that_is_none_is_refused(text, tmp_path):
    (tmp_path / "bad.toml").write_text(text)
    with pytest.raises(FileAccessError if text == "q = " else OptionError, match=BAD_FILES[text]):
        column_map(tmp_path / "bad.toml")
    with pytest.raises(LwrDynError, match="--columns: q: \\[''\\]; allowed"):
        column_map("q=")
    assert column_map(None) == ColumnMap({})


def test_motor_positions_and_currents_stand_in_for_what_is_not_measured(tmp_path):
    log = JointLog("", (1, 2), LOG.t, LOG.q, LOG.tau, None, 100.0 * LOG.q, 0.5 * LOG.tau)
    bare = JointLog("", (1, 2), LOG.t, LOG.q * np.nan, LOG.tau * np.nan, None, log.motor_q, log.current)
    for suffix in (".csv", ".parquet"):
        path = tmp_path / f"x{suffix}"
        write_log(path, log)
        assert read_log(path).motor_q is None
        back = read_log(path, also=("dq", "qm", "i"))
        write_log(path, bare)
        motors = read_log(path, needs=("qm", "i"))
        assert np.isnan([motors.q, motors.tau]).all()
        for read in (back, motors):
            assert np.array_equal([read.motor_q, read.current], [log.motor_q, log.current])
        with pytest.raises(LogError, match=r"columns: q1, q2, tau1, tau2 missing; the file has time \[s\], qm1"):
            read_log(path)
    (tmp_path / "e.csv").write_text("time,q1\n0,0\n0.1,0.1\n0.2,0.1\n")
    assert np.isnan(read_log(tmp_path / "e.csv", needs=("q",)).tau).all()


def test_maps_that_are_given_one_by_one_are_one_map(tmp_path):
    (tmp_path / "map.toml").write_text('tau = "effort_*"\njoints = ["a", "b"]\n\n[units]\nq = "deg"\n')
    found = column_map("time=stamp,q=pos_*", tmp_path / "map.toml")
    assert found.columns == {"time": ("stamp",), "q": ("pos_*",), "tau": ("effort_*",)}
    assert (found.units, found.joints) == ({"q": "deg"}, ("a", "b"))
    for given in (("q=a", "q=b"), ("q=a,q=b",), ("tau=x", tmp_path / "map.toml")):
        with pytest.raises(OptionError, match=r"--columns: (q|tau) twice; allowed: each quantity once"):
            column_map(*given)


def test_a_table_of_lerobot_is_read(tmp_path):
    import pyarrow
    from pyarrow import parquet

    vectors = {"observation.state": LOG.q, "observation.effort": LOG.tau}
    fixed = pyarrow.list_(pyarrow.float32(), 2)
    columns = {name: pyarrow.array(values.astype(np.float32).tolist(), fixed) for name, values in vectors.items()}
    columns |= {"timestamp": LOG.t, "episode_index": np.zeros(len(LOG.t), dtype=int)}
    parquet.write_table(pyarrow.table(columns), tmp_path / "data.parquet")
    names = column_map("time=timestamp", "q=observation.state.*", "tau=observation.effort.*")
    log = read_log(tmp_path / "data.parquet", {"time": "s", "q": "rad", "tau": "N m"}, columns=names)
    assert log.joints == (1, 2)
    assert (log.q == LOG.q.astype(np.float32)).all()
    assert (log.tau == LOG.tau.astype(np.float32)).all()
