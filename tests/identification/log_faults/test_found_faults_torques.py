"""Logs whose torques are mostly cut out, or never change: fitted by joint, or refused in one line."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.log_faults.found_faults import cut_saturated, log_faults
from lwr_dyn.identification.logs.joint_log import JointLog, write_log
from lwr_dyn.identification.motion.motion_result import MotionRule
from lwr_dyn.identification.regression.information import equations_of, grouped
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.cover_truths import cover_arm
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

OF_THE_LWR = ("lwr4plus", "--reading", "physical")
BOUNDS = np.array([8.0, 8.0, 8.0, 8.0, 100.0, 100.0, 100.0])
"""[N m] Clipped there no instant of the log has all torques."""


@pytest.fixture(scope="module")
def log(lwr):
    rng = np.random.default_rng(11)
    plant = perturbed_plant(TorqueColumns(lwr.chain), lwr, rng, 0.01)
    return simulated_log(plant, random_motion(lwr, 8.0, rng, rate=500.0), 0.1, rng, encoder=1e-5)


def with_torques(log, path, change):
    write_log(path, replace(log, tau=change(log.tau)))
    return str(path)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["motion", "table"])
def test_clipped_torques_are_fitted_by_joint(command, log, tmp_path, lwr_dyn_command):
    path = with_torques(log, tmp_path / "a.csv", lambda tau: np.clip(tau, -BOUNDS, BOUNDS))
    code, out, err = lwr_dyn_command("identify", command, *OF_THE_LWR, path)
    assert code in (0, 1), err
    assert out
    assert "column tau2: " in err
    assert "signs, order and units of columns were not checked" in err


@pytest.mark.parametrize("bound", [8.0, 2.0])
@pytest.mark.parametrize("command", ["motion", "table"])
def test_torques_always_at_a_bound_are_refused(command, bound, log, tmp_path, lwr_dyn_command):
    path = with_torques(log, tmp_path / "a.csv", lambda tau: np.clip(tau, -bound, bound))
    code, out, err = lwr_dyn_command("identify", command, *OF_THE_LWR, path)
    assert (code, out) == (2, "")
    last = err.splitlines()[-1]
    assert "never change" in last
    assert f"-{bound:g} or {bound:g}" in last
    assert "one joint further" not in err


@pytest.mark.slow
def test_of_few_cut_torques_columns_are_still_tried(log, lwr):
    wrong = replace(log, tau=np.clip(log.tau, -40.0, 40.0) * [1, -1, 1, 1, 1, 1, 1])
    ready, cut = cut_saturated(wrong, lwr)
    assert cut
    (fault,) = log_faults([ready], lwr)
    assert (fault.kind, fault.joints) == ("sign", (2,))


DEAD = {
    "all zero": (lambda tau: 0.0 * tau, "tau1, tau2, tau3, tau4, tau5, tau6, tau7 never change ("),
    "all constant": (lambda tau: 0.0 * tau + 3.3, "tau1, tau2, tau3, tau4, tau5, tau6, tau7 never change (3.3, "),
    "one": (lambda tau: tau * [1, 1, 0, 1, 1, 1, 1], "tau3 never changes (0 N m or N) while the joint moved"),
}


@pytest.mark.parametrize("options", [("motion", "--as-logged"), ("table",), ("payload",)])
@pytest.mark.parametrize("case", DEAD)
def test_torques_that_never_change_are_refused_in_one_line(case, options, log, tmp_path, lwr_dyn_command):
    change, text = DEAD[case]
    path = with_torques(log, tmp_path / "dead.csv", change)
    code, out, err = lwr_dyn_command("identify", options[0], *OF_THE_LWR, path, *options[1:])
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert text in line
    assert "dead.csv" in line


@pytest.mark.slow
def test_a_still_joint_may_have_one_torque(log, lwr):
    q, tau = log.q.copy(), log.tau.copy()
    q[:, 2], tau[:, 2] = 0.3, 0.0
    kinds = [fault.kind for fault in log_faults([replace(log, q=q, tau=tau)], lwr)]
    assert "silent" not in kinds
    assert "still" in kinds


def test_torque_that_changes_in_another_log_is_not_silent(log, lwr):
    assert log_faults([replace(log, tau=0.0 * log.tau), log], lwr) == ()


def test_a_group_of_zeros_has_noise_that_others_bear():
    rows = equations_of(np.ones((5, 2, 1)), np.array([[0.0, 1.0]] * 5), np.ones((5, 2), dtype=bool))
    fit = grouped(rows, np.ones(2))
    assert (fit.noise >= 1e-9).all()
    assert np.isfinite(rows.weighted(fit.noise)[0]).all()
    assert np.square(fit.sigma).item() > 0.0


@pytest.mark.parametrize("deviation", [0.0, -1.0, 100.0, 1e9, np.inf, np.nan])
def test_a_deviation_out_of_bounds_is_refused(deviation):
    with pytest.raises(OptionError, match=f"deviation: {deviation}; allowed: a share above 0 and up to"):
        MotionRule(deviation=deviation)


@pytest.mark.slow
@pytest.mark.parametrize("deviation", ["10", "100"])
def test_large_deviation_is_fitted_or_refused_in_one_line(deviation, log, tmp_path, lwr_dyn_command):
    path = with_torques(log, tmp_path / "a.csv", lambda tau: tau)
    code, out, err = lwr_dyn_command("identify", "motion", *OF_THE_LWR, path, "--deviation", deviation)
    if deviation == "10":
        assert (code, bool(out)) == (0, True)
    else:
        assert (code, out, len(err.splitlines())) == (2, "", 1)


@pytest.mark.slow
def test_a_joint_that_hardly_carries_weight_has_no_wrong_unit():
    """The last link of an iiwa has its centre 4 micrometres off the axis: what turns it is no gravity in mN m."""
    arm = cover_arm("iiwa14")
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), lwr_dyn.reference("move", arm))
    log = JointLog("run", tuple(range(1, 8)), run.t, run.q, run.tau_applied)
    assert log_faults([log], arm) == ()
