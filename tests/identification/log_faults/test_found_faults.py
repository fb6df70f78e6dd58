"""Wrong signs, order and units of columns are named, saturated torques cut out, still and silent joints named."""

import re
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.log_faults import found_faults
from lwr_dyn.identification.log_faults.column_trials import column_changes, column_faults, trial_samples
from lwr_dyn.identification.log_faults.found_faults import log_faults
from lwr_dyn.identification.logs.joint_log import JointLog, write_log
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.cover_truths import cover_arm
from tests.identification.log_fault_study import recognised
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

OF_THE_LWR = ("lwr4plus", "--reading", "physical")
BOUNDS = np.array([8.0, 8.0, 8.0, 8.0, 100.0, 100.0, 100.0])
"""[N m] Clipped there no instant of the log `near` has all torques."""


@pytest.fixture(scope="module")
def plant(lwr, columns):
    return perturbed_plant(columns, lwr, np.random.default_rng(4))


@pytest.fixture(scope="module")
def motion(lwr):
    return random_motion(lwr, 10.0, np.random.default_rng(5))


@pytest.fixture(scope="module")
def log(plant, motion):
    return simulated_log(plant, motion, 0.1, np.random.default_rng(6), encoder=1e-5)


@pytest.fixture(scope="module")
def near(lwr, columns):
    """Of an arm 1 % off its table, at 500 Hz."""
    rng = np.random.default_rng(11)
    plant = perturbed_plant(columns, lwr, rng, 0.01)
    return simulated_log(plant, random_motion(lwr, 8.0, rng, rate=500.0), 0.1, rng, encoder=1e-5)


@pytest.mark.slow
def test_most_faults_are_recognised_and_whole_logs_raise_no_alarm():
    """A share of the soak line `log-faults`."""
    counts = recognised("lwr4plus", "physical", plants=2, each=4)
    assert (counts.alarms, counts.wrong <= 1, counts.right >= 6) == (0, True, True)


def wrong(log, q=(), tau=(), order=range(7)):
    """The log with some joints (from 1) of the opposite sign, in q and in tau, and columns in another order."""
    q_sign, tau_sign = (np.where(np.isin(np.arange(1, 8), [*joints]), -1.0, 1.0) for joints in (q, tau))
    return replace(log, q=(log.q * q_sign)[:, order], tau=(log.tau * tau_sign)[:, order])


CASES = {
    "a torque": ({"tau": (2,)}, "sign", (2,), "with tau2 with the opposite sign"),
    "an encoder": ({"q": (4,)}, "sign", (4,), "with q4 with the opposite sign"),
    "an axis": ({"q": (3,), "tau": (3,)}, "sign", (3,), "with q3 and tau3 with the opposite sign"),
    "all torques": ({"tau": range(1, 8)}, "sign", (), "all torques with the opposite sign"),
    "two joints": ({"order": [1, 0, 2, 3, 4, 5, 6]}, "order", (1, 2), "q1 and tau1 exchanged with q2 and tau2"),
    "reversed": ({"order": [6, 5, 4, 3, 2, 1, 0]}, "order", (), "all positions and torques in reverse order"),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_wrong_sign_or_order_is_named(case, log, lwr):
    change, kind, joints, text = CASES[case]
    (fault,) = log_faults([wrong(log, **change)], lwr)
    assert (fault.kind, fault.joints, fault.severe) == (kind, joints, True)
    assert text in fault.found
    assert str(fault).startswith("simulated: the arm explains the log with ")
    assert "the residual of joint" in fault.found


@pytest.mark.slow
def test_two_faults_at_once_are_both_named(log, lwr):
    found = log_faults([wrong(log, tau=(2,), q=(4,))], lwr)
    assert {(x.kind, x.joints) for x in found} == {("sign", (2,)), ("sign", (4,))}


@pytest.mark.slow
def test_friction_of_the_wrong_sign_betrays_a_torque_without_inertia(plant, motion, lwr):
    """Joint 7 alone: its link weighs nothing, its torque is friction."""
    still = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.0])
    q, dq, ddq = (np.where(np.arange(7) == 6, x, 0.0) for x in (motion.q, motion.dq, motion.ddq))
    log = simulated_log(plant, replace(motion, q=q + still, dq=dq, ddq=ddq), 0.02, np.random.default_rng(7), 1e-5)
    assert {x.kind for x in log_faults([log], lwr)} == {"still"}
    (fault,) = (x for x in log_faults([wrong(log, tau=(7,))], lwr) if x.kind == "sign")
    assert "q7" in fault.found or "tau7" in fault.found


SINGLE_CHANGES = {
    "q2 with the opposite sign": ("sign", (2,), "q", [1, -2, 3, 4], None),
    "tau4 with the opposite sign": ("sign", (4,), "tau", None, [1, 2, 3, -4]),
    "q1 and tau1 with the opposite sign": ("sign", (1,), "both", [-1, 2, 3, 4], [-1, 2, 3, 4]),
    "all torques with the opposite sign": ("sign", (), "tau", None, [-1, -2, -3, -4]),
    "q1 exchanged with q3": ("order", (1, 3), "q", [3, 2, 1, 4], None),
    "all positions in reverse order": ("order", (), "q", [4, 3, 2, 1], None),
    "all torques one joint further up": ("order", (), "tau", None, [4, 1, 2, 3]),
    "all positions and torques one joint further down": ("order", (), "both", [2, 3, 4, 1], [2, 3, 4, 1]),
    "q4 0.01745 times as large (in deg, read as rad)": ("unit", (4,), "q", [1, 2, 3, 4 * np.pi / 180], None),
    "all positions 57.3 times as large (in rad, read as deg)":
        ("unit", (), "q", np.degrees([1, 2, 3, 4]).tolist(), None),
}  # fmt: skip
"""Some of the single changes: kind, joints, side, and what becomes of positions and torques 1, 2, 3, 4."""


def test_changes_are_all_different_and_do_what_they_say():
    changes, row = list(column_changes(4)), np.arange(1.0, 5.0)
    assert len({(c.Q.tobytes(), c.T.tobytes()) for c in changes}) == len(changes) == len({c.text for c in changes})
    assert (len(changes), len(list(column_changes(3)))) == (3 * (5 + 9) + 10, 3 * (4 + 3) + 8)
    by_text = {c.text: (c.kind, c.joints, c.side, row @ c.Q, row @ c.T) for c in changes}
    for text, (*what, q, tau) in SINGLE_CHANGES.items():
        *found, found_q, found_tau = by_text[text]
        assert found == what
        np.testing.assert_allclose((found_q, found_tau), (row if q is None else q, row if tau is None else tau))


@pytest.fixture(scope="module")
def few(log):
    """50 instants of a log."""
    return trial_samples([log]).select(slice(0, 400, 8))


def test_of_fifty_instants_a_wrong_sign_is_told_with_what_is_left_and_the_right_ones_are_not(few, lwr):
    (fault,) = column_faults(replace(few, tau=few.tau * [1, -1, 1, 1, 1, 1, 1]), lwr)
    assert (fault.kind, fault.joints, fault.severe) == ("sign", (2,), True)
    before, after = map(float, re.fullmatch(
        r"simulated: the arm explains the log with tau2 with the opposite sign: the residual of joint 2 falls from "
        r"(\S+) to (\S+); needed: columns as the arm's axes have them", str(fault),
    ).groups())  # fmt: skip
    assert before > 40.0 > 0.2 > after


def test_instants_are_taken_evenly_where_enough_torques_are_known(near):
    """From 50 of them on, and where half of the log has all; fewer are taken where no torque is cut out."""
    t = trial_samples([near]).t
    assert (len(t), np.diff(t).max() < 2.1 * np.diff(t).min()) == (400, True)  # of 760
    for rows, known, count in ((300, 300, 20), (500, 350, 50), (500, 345, None), (4001, 2101, 400), (4001, 1901, None)):
        tau = near.tau[:rows].copy()
        tau[known:, 3] = np.nan
        taken = trial_samples([replace(near, t=near.t[:rows], q=near.q[:rows], tau=tau)])
        assert (None if taken is None else len(taken)) == count


@pytest.mark.parametrize("seed", [100, 101])
def test_published_friction_that_drives_is_no_wrong_sign(seed, wam):
    """The WAM's friction of joint 4 falls below 0 above 0.6 rad/s: in 2 s of noise it looks like a turned torque."""
    columns, rng = TorqueColumns(wam.chain, stribeck_velocity=np.full(7, 0.05)), np.random.default_rng(seed)
    plant = perturbed_plant(columns, wam, rng, 0.3)
    assert log_faults([simulated_log(plant, random_motion(wam, 2.0, rng), 0.5, rng, encoder=1e-5)], wam) == ()


@pytest.mark.slow
def test_a_joint_that_hardly_carries_weight_has_no_wrong_unit():
    """The last link of an iiwa has its centre 4 micrometres off the axis: what turns it is no gravity in mN m."""
    arm = cover_arm("iiwa14")
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), lwr_dyn.reference("move", arm))
    log = JointLog("run", tuple(range(1, 8)), run.t, run.q, run.tau_applied)
    assert log_faults([log], arm) == ()


UNITS = {
    "mN m": (1e3, range(7), "all torques in mN m, read as N m: times the gravity of the table "),
    "N m": (1e-3, range(7), "all torques in N m, read as mN m: times the gravity of the table 0.00"),
    "one": (1e3, [1], "tau2 in mN m, read as N m: times the gravity of the table 1"),
}


@pytest.mark.parametrize("case", UNITS)
def test_torques_in_the_wrong_unit_are_named(case, log, lwr):
    factor, joints, text = UNITS[case]
    scale = np.where(np.isin(np.arange(7), [*joints]), factor, 1.0)
    (fault,) = log_faults([replace(log, tau=log.tau * scale)], lwr)
    assert (fault.kind, fault.severe, fault.found.startswith(text)) == ("unit", True, True)


@pytest.mark.slow
def test_positions_in_the_wrong_unit_are_named(log, lwr):
    (fault,) = log_faults([replace(log, q=np.radians(log.q))], lwr)
    assert (fault.kind, fault.joints) == ("unit", ())
    assert "all positions 57.3 times as large (in rad, read as deg)" in fault.found


@pytest.mark.parametrize("counts", [0.0, 0.05])
def test_saturated_torques_are_cut_out_and_the_fit_is_as_good_as_before(counts, log, lwr, columns):
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
    whole, left, spoilt = (information_of(samples_of([x]), columns) for x in (log, cut, clipped))
    away = [float(np.abs((x.values - whole.values) / left.sigma).max()) for x in (left, spoilt)]
    assert away[0] < 6.0 < 20.0 < away[1]


def test_torques_beyond_the_joints_limit_are_saturated(log, lwr):
    """A commanded torque may be written down although the motor cannot give it."""
    tau = log.tau.copy()
    tau[100:120, 4] = 101.0 + np.arange(20)
    rows = found_faults.saturated_rows(replace(log, tau=tau), lwr)
    assert np.argwhere(rows).tolist() == [[k, 4] for k in range(100, 120)]
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
        assert rows.any(axis=0).tolist() == [True, False]
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


@pytest.fixture
def identify(near, tmp_path, lwr_dyn_command):
    """A command on the log with other torques."""

    def run(change, command, *options):
        write_log(tmp_path / "a.csv", replace(near, tau=change(near.tau)))
        return lwr_dyn_command("identify", command, *OF_THE_LWR, str(tmp_path / "a.csv"), *options)

    return run


@pytest.mark.slow
@pytest.mark.parametrize("command", ["motion", "table"])
def test_clipped_torques_are_fitted_by_joint(command, identify):
    code, out, err = identify(lambda tau: np.clip(tau, -BOUNDS, BOUNDS), command)
    assert (code in (0, 1), bool(out), "column tau2: " in err) == (True, True, True), err
    assert "signs, order and units of columns were not checked" in err


@pytest.mark.parametrize("bound", [8.0, 2.0])
@pytest.mark.parametrize("command", ["motion", "table"])
def test_torques_always_at_a_bound_are_refused(command, bound, identify):
    code, out, err = identify(lambda tau: np.clip(tau, -bound, bound), command)
    last = err.splitlines()[-1]
    assert (code, out, "never change" in last, f"-{bound:g} or {bound:g}" in last) == (2, "", True, True)
    assert "one joint further" not in err


@pytest.mark.slow
def test_of_few_cut_torques_columns_are_still_tried(near, lwr):
    flipped = replace(near, tau=np.clip(near.tau, -40.0, 40.0) * [1, -1, 1, 1, 1, 1, 1])
    ready, cut = found_faults.cut_saturated(flipped, lwr)
    (fault,) = log_faults([ready], lwr)
    assert (bool(cut), fault.kind, fault.joints) == (True, "sign", (2,))


DEAD = {
    "all zero": (lambda tau: 0.0 * tau, "tau1, tau2, tau3, tau4, tau5, tau6, tau7 never change (0, "),
    "all constant": (lambda tau: 0.0 * tau + 3.3, "tau1, tau2, tau3, tau4, tau5, tau6, tau7 never change (3.3, "),
    "one": (lambda tau: tau * [1, 1, 0, 1, 1, 1, 1], "tau3 never changes (0 N m or N) while the joint moved"),
}


@pytest.mark.parametrize("options", [("motion", "--as-logged"), ("table",), ("payload",)])
@pytest.mark.parametrize("case", DEAD)
def test_torques_that_never_change_are_refused_in_one_line(case, options, identify):
    change, text = DEAD[case]
    code, out, err = identify(change, *options)
    (line,) = err.splitlines()
    assert (code, out, text in line, "a.csv" in line) == (2, "", True, True), line


@pytest.mark.slow
def test_a_still_joint_may_have_one_torque(near, lwr):
    q, tau = near.q.copy(), near.tau.copy()
    q[:, 2], tau[:, 2] = 0.3, 0.0
    kinds = {fault.kind for fault in log_faults([replace(near, q=q, tau=tau)], lwr)}
    assert kinds & {"silent", "still"} == {"still"}


def test_torque_that_changes_in_another_log_is_not_silent(near, lwr):
    assert log_faults([replace(near, tau=0.0 * near.tau), near], lwr) == ()


@pytest.mark.slow
def test_a_large_deviation_is_fitted(identify):
    code, out, _ = identify(np.array, "motion", "--deviation", "10")
    assert (code, bool(out)) == (0, True)
