"""Rankings: the figures of the trial on the logs that are here, planted sets, refusals."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, OptionError, UnknownNameError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.ranking.rank import named_sets, rank
from lwr_dyn.model.friction import friction_torque
from tests.identification.ranking.test_set_fits import ARM, loaded, measured, motion

SETS = ["gaz", "fr3", "fr3v2", "fer", "rtb_python"]
PRINTED = {"gaz": (0.393, 0.373), "fr3": (0.395, 0.374), "fr3v2": (0.434, 0.372), "fer": (1.015, 0.411)}
"""RMS [N m] as published and with a free load, which the trial found on the whole log with code of its own."""


@pytest.fixture(scope="module")
def panda():
    return rank("panda", "panda_salerno", SETS, free=["load"])


@pytest.mark.parametrize("name", PRINTED)
def test_the_trial_is_recomputed_to_one_percent(panda, name):
    fits = panda.of(name).fits
    assert [fit.total for fit in fits] == pytest.approx(PRINTED[name], rel=0.01)


def test_the_floor_the_order_and_the_bodies_are_those_of_the_trial(panda):
    assert panda.floor() == pytest.approx(0.306, rel=0.01)
    assert [one.name for one in panda.scores] == SETS
    assert [bool(one.not_bodies) for one in panda.scores] == [False, False, False, True, False]
    assert panda.of("rtb_python").fits[0].total == pytest.approx(1.413, rel=0.01)
    assert panda.of("fer").fits[1].load[0] == pytest.approx(0.76, abs=0.01)
    for one in panda.scores:
        (low, high), total = one.intervals[0], one.fits[0].total
        assert low < total < high


def test_the_small_form_of_the_ur10_keeps_the_numbers():
    found = rank("ur10", "ur10_salerno", ["maker"], free=["rotor", "gain"])
    assert [fit.total for fit in found.scores[0].fits[::2]] == pytest.approx([2.221, 2.085], rel=0.01)
    assert found.floor(1) == pytest.approx(2.366, rel=0.01)


def of_motion(seed, count=400, step=0.02, **given):
    log = measured(motion(seed, count, step), **given)
    return JointLog(f"log {seed}", tuple(range(1, 7)), log.t, log.q, log.tau)


def test_the_set_that_made_a_log_is_first_and_another_log_tests():
    light = lwr_dyn.load("ur10e")
    found = rank("ur10", of_motion(5, noise=2.0), [ARM, light], test=of_motion(6, noise=2.0))
    assert [one.name for one in found.scores] == ["ur10", "ur10e"]
    assert found.tested_on == "log 6"
    assert found.scores[0].ahead > 0.99


@pytest.mark.slow
def test_a_load_that_turns_the_ranking_round_is_said():
    heavy = loaded()
    wrong = replace(ARM.with_chain(heavy.chain), name="loaded")
    found = rank("ur10", of_motion(7, noise=0.5), [ARM, wrong])
    assert found.with_load == found.scores[0].name
    assert "turns the ranking" not in found.document.text()
    assert "turns the ranking" in replace(found, with_load=found.scores[1].name).document.text()


def test_computed_torques_are_refused():
    with pytest.raises(LogError, match="computed, not measured"):
        rank("ur10", of_motion(5, 2000, 0.004, friction=False), [ARM], cutoff=50.0)
    with pytest.raises(LogError, match="computed, not measured"):
        rank("ur10e", "ur10e_30s_target")
    with pytest.raises(LogError, match="simulated run"):
        rank("ur10", "run.npz")


@pytest.mark.parametrize(
    ("error", "given"),
    [
        (OptionError, {"cutoff": 0.0}),
        (OptionError, {"free": ["lift"]}),
        (OptionError, {"free": ["load", "load"]}),
        (OptionError, {"free": ["coupling"]}),
        (OptionError, {"sets": ["gaz", "gaz"]}),
        (OptionError, {"sets": ["gaz", "ur10:maker"]}),
        (UnknownNameError, {"sets": ["gas"]}),
        (LogError, {"log": "ur10_salerno"}),
    ],
)
def test_what_cannot_be_ranked_is_refused(error, given):
    with pytest.raises(error):
        rank("panda", given.pop("log", "panda_salerno"), given.pop("sets", ["gaz"]), **given)


def test_sets_are_readings_other_robots_files_and_arms(tmp_path):
    path = tmp_path / "my.urdf"
    path.write_text(lwr_dyn.urdf_text(lwr_dyn.load("panda", "fer")))
    found = rank("panda", "panda_salerno", ["fer", str(path)])
    assert found.scores[0].fits[0].total == pytest.approx(found.scores[1].fits[0].total, rel=1e-9)
    assert [name for name, _ in named_sets("ur10", ["maker", "ur10e:maker"])] == ["maker", "ur10e:maker"]
    assert [name for name, _ in named_sets("panda")] == list(lwr_dyn.readings("panda"))


def test_the_same_log_twice_gives_the_same_bits(panda):
    again = rank("panda", "panda_salerno", ["gaz"])
    np.testing.assert_array_equal(again.scores[0].fits[0].left, panda.of("gaz").fits[0].left)


def test_the_friction_of_a_set_stands_beside_the_one_that_is_fitted(panda):
    """The torques are those of sensors behind the gears: rotors are neither fitted nor asked for."""
    gaz = panda.of("gaz")
    dynamics = lwr_dyn.dynamics_of(gaz.arm).inverse_dynamics(panda.test.q, panda.test.dq, panda.test.ddq)
    own = panda.test.tau - dynamics - friction_torque(gaz.arm.friction_models(), panda.test.dq)
    assert gaz.own.total == pytest.approx(float(np.sqrt(np.mean(np.square(own)))), rel=1e-9)
    assert gaz.fits[0].total < gaz.own.total
    assert [len(one.alone) for one in panda.scores] == [2] * len(SETS)
    assert "own friction" in str(panda.document)
    with pytest.raises(OptionError, match="rotor, with torques measured behind the gears"):
        rank("panda", "panda_salerno", ["gaz"], free=["rotor"])
