"""Wrong signs, order and units of columns, named."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.identification.log_faults.column_trials import column_changes
from lwr_dyn.identification.log_faults.found_faults import log_faults
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.log_fault_study import recognised
from tests.identification.plants import perturbed_plant, random_motion, simulated_log


@pytest.mark.slow
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
    still = np.zeros((1, 7)) + np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.0])
    q, dq, ddq = (np.where(np.arange(7) == 6, x, 0.0) for x in (motion.q, motion.dq, motion.ddq))
    log = simulated_log(plant, replace(motion, q=q + still, dq=dq, ddq=ddq), 0.02, np.random.default_rng(7), 1e-5)
    assert {x.kind for x in log_faults([log], lwr)} == {"still"}
    (fault,) = (x for x in log_faults([wrong(log, tau=(7,))], lwr) if x.kind == "sign")
    assert "q7" in fault.found or "tau7" in fault.found


@pytest.mark.slow
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


@pytest.mark.parametrize("seed", [100, 101])
def test_published_friction_that_drives_is_no_wrong_sign(seed, wam):
    """The WAM's friction of joint 4 falls below 0 above 0.6 rad/s: in 2 s of noise it looks like a turned torque."""
    columns, rng = TorqueColumns(wam.chain, stribeck_velocity=np.full(7, 0.05)), np.random.default_rng(seed)
    plant = perturbed_plant(columns, wam, rng, 0.3)
    assert log_faults([simulated_log(plant, random_motion(wam, 2.0, rng), 0.5, rng, encoder=1e-5)], wam) == ()
