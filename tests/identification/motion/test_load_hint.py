"""Friction with the load is suggested to logs that ask for it, with what it gains, and to no others."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.identification.motion.load_hint import LoadHint, load_hint
from lwr_dyn.identification.motion.motion_fit import identify_motion, said_by
from lwr_dyn.identification.motion.motion_result import MotionRule, motion_document
from lwr_dyn.identification.motion.validation import Folds, rms
from lwr_dyn.identification.regression.load_friction import load_indices, rigid_values
from lwr_dyn.model.transmission import Transmission
from tests.identification.cover_study import case, cover_log
from tests.identification.gain_load_study import gain_load_log

LOGS = files("lwr_dyn.identification.ranking") / "logs"


def said(folds):
    return said_by(folds)[0]


def of_log(arm, samples, columns=None):
    folds = Folds.of(samples, case(arm)[0] if columns is None else columns, 5, samples.used)
    return load_hint(folds, said(folds), said)


def loaded(arm, noise, run):
    gains, _, samples = gain_load_log(arm, "natural", noise, run)
    return replace(samples, tau=samples.tau / gains)


@pytest.fixture(scope="module")
def ur10():
    arm = lwr_dyn.load("ur10")
    return arm, read_log(str(LOGS / "ur10_salerno.csv"), {}, arm)


def test_the_log_of_a_ur10_asks_for_it_and_what_it_would_gain_is_said(ur10):
    arm, log = ur10
    found = identify_motion([log], arm)
    hint = found.load_hint
    assert hint.joint == 2
    assert 0.1 < hint.gain < 0.3
    document = motion_document(found)
    assert document.record()["load_friction_gain"] == hint.gain
    assert f"in place of {hint.without:.3g}, {100 * hint.gain:.0f} % less (joint 2: 0.048 +- 0.004" in document.text()
    assert document.text().count("--load-friction") == 1
    fitted = motion_document(identify_motion([log], arm, MotionRule(load_friction=True)))
    assert fitted.record()["load_friction_gain"] is None
    assert "--load-friction" not in fitted.text()


@pytest.mark.slow
def test_the_log_of_a_panda_does_not():
    arm = lwr_dyn.load("panda")
    assert identify_motion([read_log(str(LOGS / "panda_salerno.csv"), {}, arm)], arm).load_hint is None


def test_what_is_left_of_unseen_torques_is_that_of_the_rows():
    samples = loaded("ur10", "white", 0)
    folds = Folds.of(samples, case("ur10")[0], 5, samples.used)
    information = said(folds)
    hint = load_hint(folds, information, said)
    grown = folds.with_columns(replace(folds.columns, carried=rigid_values(folds.columns, information.values)))
    for one, left in ((folds, hint.without), (grown, hint.with_load)):
        rows = np.where(samples.used, one.held_out(information.noise), np.nan)
        assert left == pytest.approx(rms(rows), rel=1e-6)


@pytest.mark.parametrize("noise", ["white", "coloured"])
def test_simulated_logs_with_shares_ask_for_it_and_those_without_do_not(noise):
    for run in range(2):
        assert of_log("ur10", loaded("ur10", noise, run)).gain > 0.5
        assert of_log("ur10", cover_log("ur10", "natural", noise, run)[1]) is None


def test_a_log_without_noise_asks_where_there_is_something_to_explain():
    plain = case("ur10")[0]
    true, samples = cover_log("ur10", "natural", "white", 0)
    at = samples.q, samples.dq, samples.ddq
    assert of_log("ur10", replace(samples, tau=plain.torques(*at, true))) is None
    grows = replace(plain, carried=true[plain.table_indices])
    share = np.zeros(grows.count)
    share[load_indices(grows)] = 0.1
    assert of_log("ur10", replace(samples, tau=plain.torques(*at, true) + grows.torques(*at, share))).gain > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("arm", ["panda", "ur10", "wam7", "iiwa14"])
def test_none_of_forty_logs_without_shares_asks_for_it(arm):
    for noise in ("white", "coloured"):
        for run in range(5):
            assert of_log(arm, cover_log(arm, "natural", noise, run)[1]) is None
            assert isinstance(of_log(arm, loaded(arm, noise, run)), LoadHint)


def test_motors_that_turn_joints_together_and_columns_with_loads_are_passed_over():
    samples = loaded("ur10", "white", 0)
    matrix = np.diag(np.full(6, 100.0))
    apart = replace(case("ur10")[0], transmission=Transmission(matrix))
    assert of_log("ur10", samples, apart).gain > 0.5
    matrix[5, 4] = 20.0
    assert of_log("ur10", samples, replace(apart, transmission=Transmission(matrix))) is None
    plain = case("ur10")[0]
    assert of_log("ur10", samples, replace(plain, carried=plain.own(lwr_dyn.load("ur10"))[plain.table_indices])) is None
