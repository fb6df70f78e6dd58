"""Friction that grows with the load, as it is printed and written, and what it is worth on the log of a real arm."""

import json
import tomllib
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.fitted import fitted_values
from lwr_dyn.identification.fitted_files import write_fitted
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.identification.motion.friction_rows import load_shares, load_words
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionRule, motion_document
from lwr_dyn.identification.regression.load_friction import load_indices
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.model.friction import friction_torque
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
    assert "a data file has it as friction.load; simulations leave it out and say so" in text
    assert without.record()["load_friction"] is None
    assert "grows with the torque of bodies" not in without.text()


def test_a_written_model_has_the_shares_with_their_errors(fits, ur10, tmp_path):
    words = load_words(fits[1].information)
    assert words.endswith("of the load")
    assert words.count("+-") == 6
    values, columns = fitted_values(fits[1]), fits[1].columns
    assert words in values.about
    shares = fits[1].consistent.parameters[load_indices(columns)]
    given = [model.load for model in values.friction]
    assert given == pytest.approx(np.clip(shares, 0.0, 0.99))
    assert given[1] == shares[1] > 0.04
    write_fitted(tmp_path / "arm.toml", fits[1], open_paper("ur10"))
    raw = tomllib.loads((tmp_path / "arm.toml").read_text(encoding="utf-8"))["friction"]["load"]
    assert (raw["kind"], raw["unit"]) == ("fitted", "1")
    assert raw["sigma"][1] == pytest.approx(fits[1].consistent.sigma[load_indices(columns)[1]])
    arm = lwr_dyn.load(tmp_path / "arm.toml")
    assert [model.load for model in arm.friction] == given
    again = columns.own(arm)[load_indices(columns)]
    assert again.tolist() == given
    assert f"{given[1]:.2g} of it at joint_2" in arm.caveat()
    q, dq, ddq = np.random.default_rng(4).uniform(-1.0, 1.0, (3, 6, 6))
    rigid = lwr_dyn.dynamics_of(arm, "newton-euler").inverse_dynamics(q, dq, ddq)
    parameters = fits[1].consistent.parameters.copy()
    parameters[load_indices(columns)] = given
    of_the_written = replace(columns, carried=parameters[columns.table_indices])
    wanted = of_the_written.torques(q, dq, ddq, parameters)
    assert rigid + friction_torque(arm.friction, dq, rigid) == pytest.approx(wanted, abs=1e-9)
    write_fitted(tmp_path / "plain.toml", fits[0], open_paper("ur10"))
    assert "load" not in tomllib.loads((tmp_path / "plain.toml").read_text(encoding="utf-8"))["friction"]
    write_fitted(tmp_path / "arm.urdf", fits[1], None)
    sidecar = json.loads((tmp_path / "arm.provenance.json").read_text(encoding="utf-8"))
    assert sidecar["friction"]["joint_2"]["load"] == given[1]
    assert sidecar["quantities"]["joint_2.friction.load"][0]["sigma"] == raw["sigma"][1]


def test_what_does_not_go_with_it_is_refused(ur10, logs):
    matrix = np.diag(np.full(6, 100.0))
    MotionRule(SampleRule(transmission=Transmission(matrix)), load_friction=True)
    matrix[5, 4] = 20.0
    with pytest.raises(OptionError, match="load friction: given for motors that turn joints together"):
        MotionRule(SampleRule(transmission=Transmission(matrix)), load_friction=True)
    with pytest.raises(OptionError, match="load friction: given; allowed: none with instruments"):
        identify_motion(logs[:1], ur10, MotionRule(load_friction=True), logs[:1])
