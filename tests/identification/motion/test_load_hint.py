"""Friction that grows with the load: suggested to logs that ask for it and to no others, printed, written."""

import json
import tomllib
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.identification.fitted import fitted_values
from lwr_dyn.identification.fitted_files import write_fitted
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.identification.motion.friction_rows import load_shares, load_words
from lwr_dyn.identification.motion.load_hint import LoadHint, load_hint
from lwr_dyn.identification.motion.motion_fit import identify_motion, said_by
from lwr_dyn.identification.motion.motion_result import MotionRule, motion_document
from lwr_dyn.identification.regression.load_friction import load_indices, rigid_values
from lwr_dyn.model.friction import friction_torque
from lwr_dyn.model.transmission import Transmission
from tests.identification.cover_study import case, cover_log, folds_of
from tests.identification.gain_study import gain_log
from tests.identification.plants import rms

TRAIN = 0.6


def said(folds):
    return said_by(folds)[0]


def of_log(arm, samples, columns=None):
    folds = folds_of(arm, samples, columns)
    return load_hint(folds, said(folds), said)


def loaded(arm, noise, run):
    gains, _, samples = gain_log(arm, "natural", noise, run, load=True)
    return replace(samples, tau=samples.tau / gains)


def here(arm):
    path = files("lwr_dyn.identification.ranking") / "logs" / f"{arm.name}_salerno.csv"
    return read_log(str(path), {}, arm)


@pytest.fixture(scope="module")
def ur10():
    return lwr_dyn.load("ur10")


@pytest.fixture(scope="module")
def logs(ur10):
    """The log of a real UR10 in two."""
    whole = here(ur10)
    split = round(TRAIN * len(whole.t))
    parts = slice(0, split), slice(split, None)
    return [replace(whole, t=whole.t[p], q=whole.q[p], dq=whole.dq[p], tau=whole.tau[p]) for p in parts]


@pytest.fixture(scope="module")
def fits(ur10, logs):
    return [identify_motion(logs[:1], ur10, MotionRule(load_friction=load)) for load in (False, True)]


def left(fit, log):
    """RMS over joints of unseen torques left by least squares and by bodies."""
    unseen = fit.validated_on([log])
    return np.array([rms([getattr(one, x) for one in unseen]) for x in ("held_out", "consistent")])


def test_the_log_of_a_ur10_asks_for_it_and_is_better_with_it(fits, logs):
    """0.91 in place of 1.98 N m, and 0.90 in place of 1.78."""
    without, with_load = (left(fit, logs[1]) for fit in fits)
    assert (with_load < 0.6 * without).all()
    joint, share, error = load_shares(fits[1].information)[1]
    assert joint == 2  # it bears the most
    assert share > 3.0 * error


def test_what_it_would_gain_is_said_once(ur10):
    found = identify_motion([here(ur10)], ur10)
    hint, document = found.load_hint, motion_document(found)
    assert (hint.joint, 0.1 < hint.gain < 0.3) == (2, True)
    assert document.record()["load_friction_gain"] == hint.gain == 1.0 - hint.with_load / hint.without
    assert f"in place of {hint.without:.3g}, {100 * hint.gain:.0f} % less (joint 2: 0.048 +- 0.004" in document.text()
    assert document.text().count("--load-friction") == 1


def test_shares_stand_in_the_text_and_in_the_record(fits):
    without, found = (motion_document(fit) for fit in fits)
    record, text, shares = found.record(), found.text(), load_shares(fits[1].information)
    assert record["load_friction_gain"] is None
    assert list(zip(record["load_friction"], record["load_friction_error"], strict=True)) == [x[1:] for x in shares]
    for words in (
        "friction that grows with the torque of bodies and rotors",
        f"2      {shares[1][1]:.5g} +- {shares[1][2]:.2g}",
        "a data file has it as friction.load; simulations leave it out and say so",
    ):
        assert words in text
    assert "--load-friction" not in text
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


@pytest.mark.slow
def test_the_log_of_a_panda_does_not():
    arm = lwr_dyn.load("panda")
    assert identify_motion([here(arm)], arm).load_hint is None


def test_what_is_left_of_unseen_torques_is_that_of_the_rows():
    samples = loaded("ur10", "white", 0)
    folds = folds_of("ur10", samples)
    information = said(folds)
    hint = load_hint(folds, information, said)
    grown = folds.with_columns(replace(folds.columns, carried=rigid_values(folds.columns, information.values)))
    for one, wanted in ((folds, hint.without), (grown, hint.with_load)):
        rows = np.where(samples.used, one.held_out(information.noise), np.nan)
        assert wanted == pytest.approx(rms(rows[samples.used]), rel=1e-6)


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
