"""Wrong signs, order and units of columns are recognised and named, saturated torques cut out, silent joints named."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.identification.log_faults import found_faults
from lwr_dyn.identification.logs.joint_log import JointLog, write_log
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns


@pytest.mark.parametrize(
    ("factor", "joints", "text"),
    [
        (1e3, range(7), "all torques in mN m, read as N m: times the gravity of the table "),
        (1e-3, range(7), "all torques in N m, read as mN m: times the gravity of the table 0.00"),
        (1e3, [1], "tau2 in mN m, read as N m: times the gravity of the table 1"),
    ],
)
def test_torques_in_the_wrong_unit_are_named(factor, joints, text, log, lwr):
    scale = np.ones(7)
    scale[list(joints)] = factor
    (fault,) = found_faults.log_faults([replace(log, tau=log.tau * scale)], lwr)
    assert (fault.kind, fault.severe) == ("unit", True)
    assert fault.found.startswith(text)


@pytest.mark.parametrize("counts", [0.0, 0.05])
def test_saturated_torques_are_cut_out_and_the_fit_is_as_good_as_before(counts, log, lwr):
    """A transducer cut off at 30 and -45 N m, in counts or not: with the rows in, parameters are off by many sigma."""
    tau = log.tau if counts == 0.0 else counts * np.round(log.tau / counts)
    clipped = replace(log, tau=np.clip(tau, -45.0, 30.0))
    cut, faults = found_faults.cut_saturated(clipped, lwr)
    rows = (tau >= 30.0) | (tau <= -45.0)
    assert (np.isnan(cut.tau) == rows).all()
    assert [x.joints[0] for x in faults] == (np.flatnonzero(rows.any(axis=0)) + 1).tolist()
    assert f"{rows[:, 1].sum()} rows" in str(next(x for x in faults if x.joints == (2,)))
    assert "at 30 or beyond, cut out; needed: torques below" in str(faults[0])
    assert cut.notes == tuple(map(str, faults))
    columns = TorqueColumns(lwr.chain)
    whole, left, spoilt = (information_of(samples_of([x]), columns) for x in (log, cut, clipped))
    away = [float(np.abs((x.values - whole.values) / left.sigma).max()) for x in (left, spoilt)]
    assert away[0] < 6.0
    assert away[1] > 20.0


def test_torques_beyond_the_joints_limit_are_saturated(log, lwr):
    """A commanded torque may be written down although the motor cannot give it."""
    tau = log.tau.copy()
    tau[100:120, 4] = 101.0 + np.arange(20)
    rows = found_faults.saturated_rows(replace(log, tau=tau), lwr)
    assert rows[100:120, 4].all()
    assert rows.sum() == 20
    assert not found_faults.saturated_rows(replace(log, tau=tau)).any()


def test_smooth_peaks_in_counts_are_not_saturated(plant, motion):
    tau = plant.torque(motion)
    for counts in (0.01, 0.05, 0.2):
        rounded = JointLog("x", tuple(range(1, 8)), motion.t, motion.q, counts * np.round(tau / counts))
        assert not found_faults.saturated_rows(rounded).any()


def test_joints_that_never_move_are_named(log):
    q = log.q.copy()
    q[:, 2] = 0.4 + np.random.default_rng(0).normal(0.0, 2e-4, len(q))
    one, other = replace(log, q=q, source="a"), replace(log, source="b")
    (fault,) = found_faults.still_joints([one])
    assert (fault.kind, fault.joints, fault.severe) == ("still", (3,), False)
    assert str(fault).startswith("a: column q3: joint 3 never moves (at most 0.0")
    assert "needed: a log in which joint 3 moves both ways" in str(fault)
    assert found_faults.still_joints([one, other]) == ()
    (fault,) = found_faults.still_joints([replace(log, q=0.0 * log.q, source="a")])
    assert str(fault).startswith("a: columns q1..: no joint ever moves; needed: ")


def test_files_are_prepared_and_a_bad_one_is_left_out(log, lwr, tmp_path):
    rng = np.random.default_rng(0)
    t = log.t + rng.uniform(-0.002, 0.002, log.t.size)
    write_log(tmp_path / "a.csv", replace(log, t=np.round(t, 9), tau=np.clip(log.tau, -45.0, 30.0)))
    (tmp_path / "b.csv").write_text("time,q1\n0,0\n")
    found = found_faults.prepared_logs([tmp_path / "a.csv", tmp_path / "b.csv"], arm=lwr)
    (ready,) = found.logs
    assert np.isnan(ready.tau).any()
    assert np.ptp(np.diff(ready.t)) < 1e-9
    assert ["miss an even clock" in note for note in found.notes] == [False] * len(found.faults) + [True]
    assert {x.kind for x in found.faults} == {"saturated"}
    (error,) = found.errors
    assert "b.csv: columns" in str(error)


def stopped(rng, limit=1.0):
    """8 s of one joint that follows a sine beyond its stop, a spring and damper; positions of 1e-5 rad at 250 Hz."""
    dt, k, c, inertia = 2e-4, 1e5 * rng.uniform(0.2, 3.0), rng.uniform(20.0, 400.0), rng.uniform(0.5, 2.0)
    w, size, kept = rng.uniform(1.0, 3.0), rng.uniform(1.05, 1.3), []
    x, v = 0.0, size * w
    for i in range(int(8.0 / dt)):
        angle = w * i * dt
        u = inertia * (900.0 * (size * np.sin(angle) - x) + 60.0 * (size * w * np.cos(angle) - v))
        u -= max(0.0, k * (x - limit) + c * v) if x > limit else 0.0
        v += dt * u / inertia
        x += dt * v
        if i % 20 == 0:
            kept.append((i * dt, x + rng.normal(0.0, 1e-5), u))
    t, q, tau = np.array(kept).T
    return JointLog("stop", (1, 2), t, np.column_stack([q, np.sin(t)]), np.column_stack([tau, np.cos(t)]))


def test_a_joint_that_runs_into_its_stop_is_cut_out_there():
    rng = np.random.default_rng(0)
    for _ in range(6):
        log = stopped(rng)
        rows = found_faults.stop_rows(log)
        assert rows[:, 0].any()
        assert not rows[:, 1].any()
        assert np.abs(log.q[rows[:, 0], 0] - 1.0).max() < 0.02
        cut, (fault,) = found_faults.cut_stops(log)
        gone = np.isnan(cut.tau)
        assert (gone[:, 0] == gone[:, 1]).all()
        assert gone[rows[:, 0]].all()
        assert gone.mean() < 0.6
        assert not (log.q[~gone[:, 0], 0] > 0.999).any()
        assert (fault.kind, fault.joints) == ("stop", (1,))
        assert "joint 1 runs into a stop at " in cut.notes[0]


def test_motions_without_stops_keep_their_torques(log):
    assert not found_faults.stop_rows(log).any()
    assert found_faults.cut_stops(log) == (log, ())
