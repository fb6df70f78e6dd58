"""Wrong signs, order and units of columns are recognised and named, saturated torques cut out, silent joints named."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.log_faults.column_trials import column_changes
from lwr_dyn.identification.log_faults.found_faults import (
    cut_saturated,
    log_faults,
    prepared_logs,
    saturated_rows,
    still_joints,
)
from lwr_dyn.identification.logs.joint_log import JointLog, write_log
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.log_fault_study import recognised
from tests.identification.plants import perturbed_plant, random_motion, simulated_log


@pytest.fixture(scope="module")
def lwr():
    return lwr_dyn.load("lwr4plus", "physical")


@pytest.fixture(scope="module")
def plant(lwr):
    return perturbed_plant(TorqueColumns(lwr.chain), lwr, np.random.default_rng(4))


@pytest.fixture(scope="module")
def motion(lwr):
    return random_motion(lwr, 10.0, np.random.default_rng(5))


@pytest.fixture(scope="module")
def log(plant, motion):
    return simulated_log(plant, motion, 0.1, np.random.default_rng(6), encoder=1e-5)


def test_most_faults_are_recognised_and_whole_logs_raise_no_alarm():
    """A share of the soak line `log-faults`."""
    counts = recognised("lwr4plus", "physical", plants=2, each=4)
    assert counts.alarms == 0
    assert counts.wrong <= 1
    assert counts.right >= 6


def wrong(log, q=(), tau=(), order=None):
    """The log with some joints (from 1) of the opposite sign, in q and in tau, and columns in another order."""
    q_sign, tau_sign = np.ones(7), np.ones(7)
    q_sign[[j - 1 for j in q]] = -1.0
    tau_sign[[j - 1 for j in tau]] = -1.0
    order = list(range(7)) if order is None else order
    return replace(log, q=(log.q * q_sign)[:, order], tau=(log.tau * tau_sign)[:, order])


CASES = {
    "a torque": ({"tau": (2,)}, "sign", (2,), "with tau2 with the opposite sign"),
    "an encoder": ({"q": (4,)}, "sign", (4,), "with q4 with the opposite sign"),
    "an axis": ({"q": (3,), "tau": (3,)}, "sign", (3,), "with q3 and tau3 with the opposite sign"),
    "all torques": ({"tau": range(1, 8)}, "sign", (), "all torques with the opposite sign"),
    "two joints": ({"order": [1, 0, 2, 3, 4, 5, 6]}, "order", (1, 2), "q1 and tau1 exchanged with q2 and tau2"),
    "reversed": ({"order": [6, 5, 4, 3, 2, 1, 0]}, "order", (), "all positions and torques in reverse order"),
}


@pytest.mark.parametrize("case", CASES)
def test_a_wrong_sign_or_order_is_named(case, log, lwr):
    change, kind, joints, text = CASES[case]
    (fault,) = log_faults([wrong(log, **change)], lwr)
    assert (fault.kind, fault.joints, fault.severe) == (kind, joints, True)
    assert text in fault.found
    assert str(fault).startswith("simulated: the arm explains the log with ")
    assert "the residual of joint" in fault.found


def test_two_faults_at_once_are_both_named(log, lwr):
    found = log_faults([wrong(log, tau=(2,), q=(4,))], lwr)
    assert {(x.kind, x.joints) for x in found} == {("sign", (2,)), ("sign", (4,))}


def test_friction_of_the_wrong_sign_betrays_a_torque_without_inertia(plant, motion, lwr):
    """Joint 7 alone: its link weighs nothing, its torque is friction."""
    still = np.zeros((1, 7)) + np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.0])
    q, dq, ddq = (np.where(np.arange(7) == 6, x, 0.0) for x in (motion.q, motion.dq, motion.ddq))
    log = simulated_log(plant, replace(motion, q=q + still, dq=dq, ddq=ddq), 0.02, np.random.default_rng(7), 1e-5)
    assert {x.kind for x in log_faults([log], lwr)} == {"still"}
    (fault,) = (x for x in log_faults([wrong(log, tau=(7,))], lwr) if x.kind == "sign")
    assert "q7" in fault.found or "tau7" in fault.found


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
    (fault,) = log_faults([replace(log, tau=log.tau * scale)], lwr)
    assert (fault.kind, fault.severe) == ("unit", True)
    assert fault.found.startswith(text)


def test_positions_in_the_wrong_unit_are_named(log, lwr):
    (fault,) = log_faults([replace(log, q=np.radians(log.q))], lwr)
    assert (fault.kind, fault.joints) == ("unit", ())
    assert "all positions 57.3 times as large (in rad, read as deg)" in fault.found


def test_changes_undo_themselves_and_are_all_different():
    changes = list(column_changes(4))
    assert len({(c.Q.tobytes(), c.T.tobytes()) for c in changes}) == len(changes) == len({c.text for c in changes})
    for change in changes:
        assert abs(abs(np.linalg.det(change.Q)) * abs(np.linalg.det(change.T))) > 0.0
        if change.side == "both":
            assert (change.Q == change.T).all()


@pytest.mark.parametrize("counts", [0.0, 0.05])
def test_saturated_torques_are_cut_out_and_the_fit_is_as_good_as_before(counts, log, lwr):
    """A transducer cut off at 30 and -45 N m, in counts or not: with the rows in, parameters are off by many sigma."""
    tau = log.tau if counts == 0.0 else counts * np.round(log.tau / counts)
    clipped = replace(log, tau=np.clip(tau, -45.0, 30.0))
    cut, faults = cut_saturated(clipped, lwr)
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
    rows = saturated_rows(replace(log, tau=tau), lwr)
    assert rows[100:120, 4].all()
    assert rows.sum() == 20
    assert not saturated_rows(replace(log, tau=tau)).any()


def test_smooth_peaks_in_counts_are_not_saturated(plant, motion):
    tau = plant.torque(motion)
    for counts in (0.01, 0.05, 0.2):
        rounded = JointLog("x", tuple(range(1, 8)), motion.t, motion.q, counts * np.round(tau / counts))
        assert not saturated_rows(rounded).any()


def test_joints_that_never_move_are_named(log):
    q = log.q.copy()
    q[:, 2] = 0.4 + np.random.default_rng(0).normal(0.0, 2e-4, len(q))
    one, other = replace(log, q=q, source="a"), replace(log, source="b")
    (fault,) = still_joints([one])
    assert (fault.kind, fault.joints, fault.severe) == ("still", (3,), False)
    assert str(fault).startswith("a: column q3: joint 3 never moves (at most 0.0")
    assert "needed: a log in which joint 3 moves both ways" in str(fault)
    assert still_joints([one, other]) == ()
    (fault,) = still_joints([replace(log, q=0.0 * log.q, source="a")])
    assert str(fault).startswith("a: columns q1..: no joint ever moves; needed: ")


def test_files_are_prepared_and_a_bad_one_is_left_out(log, lwr, tmp_path):
    rng = np.random.default_rng(0)
    t = log.t + rng.uniform(-0.002, 0.002, log.t.size)
    write_log(tmp_path / "a.csv", replace(log, t=np.round(t, 9), tau=np.clip(log.tau, -45.0, 30.0)))
    (tmp_path / "b.csv").write_text("time,q1\n0,0\n")
    found = prepared_logs([tmp_path / "a.csv", tmp_path / "b.csv"], arm=lwr)
    (ready,) = found.logs
    assert np.isnan(ready.tau).any()
    assert np.ptp(np.diff(ready.t)) < 1e-9
    assert ["miss an even clock" in note for note in found.notes] == [False] * len(found.faults) + [True]
    assert {x.kind for x in found.faults} == {"saturated"}
    (error,) = found.errors
    assert "b.csv: columns" in str(error)


@pytest.mark.parametrize("seed", [100, 101])
def test_published_friction_that_drives_is_no_wrong_sign(seed, wam):
    """The WAM's friction of joint 4 falls below 0 above 0.6 rad/s: in 2 s of noise it looks like a turned torque."""
    columns, rng = TorqueColumns(wam.chain, stribeck_velocity=np.full(7, 0.05)), np.random.default_rng(seed)
    plant = perturbed_plant(columns, wam, rng, 0.3)
    assert log_faults([simulated_log(plant, random_motion(wam, 2.0, rng), 0.5, rng, encoder=1e-5)], wam) == ()
