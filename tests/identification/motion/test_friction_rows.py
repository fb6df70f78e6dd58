"""Friction that grows with the load, as it is printed and written, and what it is worth on the log of a real arm."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.fitted import fitted_values
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.identification.motion.friction_rows import load_shares, load_words
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionRule, motion_document
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.model.transmission import Transmission

TRAIN = 0.6


@pytest.fixture(scope="module")
def ur10():
    return lwr_dyn.load("ur10")


@pytest.fixture(scope="module")
def logs(ur10):
    whole = read_log(str(files("lwr_dyn.identification.ranking") / "logs" / "ur10_salerno.csv"), {}, ur10)
    split = round(TRAIN * len(whole.t))
    parts = slice(0, split), slice(split, None)
    return [replace(whole, t=whole.t[p], q=whole.q[p], dq=whole.dq[p], tau=whole.tau[p]) for p in parts]


@pytest.fixture(scope="module")
def fits(ur10, logs):
    return [identify_motion(logs[:1], ur10, MotionRule(load_friction=load)) for load in (False, True)]


def left(fit, log):
    unseen = fit.validated_on([log])
    return [np.sqrt(np.mean([getattr(one, x) ** 2 for one in unseen])) for x in ("held_out", "consistent")]


def test_the_log_of_a_ur10_asks_for_it(fits, logs):
    (squares, bodies), (with_squares, with_bodies) = (left(fit, logs[1]) for fit in fits)
    assert with_squares < 0.6 * squares  # 0.91 and 1.98 N m
    assert with_bodies < 0.6 * bodies  # 0.90 and 1.78 N m
    joint, share, error = load_shares(fits[1].information)[1]
    assert joint == 2  # it bears the most
    assert share > 3.0 * error


def test_shares_stand_in_the_text_and_in_the_record(fits):
    without, found = (motion_document(fit) for fit in fits)
    record = found.record()
    shares = load_shares(fits[1].information)
    assert record["load_friction"] == [share for _, share, _ in shares]
    assert record["load_friction_error"] == [error for *_, error in shares]
    text = found.text()
    assert "friction that grows with the torque of bodies and rotors" in text
    assert f"2      {shares[1][1]:.5g} +- {shares[1][2]:.2g}" in text
    assert "no model has a place for it: a written one lacks it" in text
    assert without.record()["load_friction"] is None
    assert "grows with" not in without.text()


def test_a_written_model_says_what_it_lacks(fits):
    words = load_words(fits[1].information)
    assert words.endswith("of the load (not in the model)")
    assert words.count("+-") == 6
    values = fitted_values(fits[1])
    assert values.lacks == words
    assert words in values.about
    assert fitted_values(fits[0]).lacks == ""


def test_what_does_not_go_with_it_is_refused(ur10, logs):
    matrix = np.diag(np.full(6, 100.0))
    MotionRule(SampleRule(transmission=Transmission(matrix)), load_friction=True)
    matrix[5, 4] = 20.0
    with pytest.raises(OptionError, match="load friction: given for motors that turn joints together"):
        MotionRule(SampleRule(transmission=Transmission(matrix)), load_friction=True)
    with pytest.raises(OptionError, match="load friction: given; allowed: none with instruments"):
        identify_motion(logs[:1], ur10, MotionRule(load_friction=True), logs[:1])
