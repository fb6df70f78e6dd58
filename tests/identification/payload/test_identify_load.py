"""Ten parameters of a load on a known arm, or together with the arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.payload.identify_load import LEAST_SHARE, RULES, identify_load, load_shift
from lwr_dyn.identification.payload.possible_load import load_document
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.chain import with_payload
from tests.identification.payload.loaded import ARM, COM, MASS, TENSOR, TRUTH, loaded, logs_of
from tests.identification.plants import Plant, perturbed_plant, random_motion, simulated_log, torques
from tests.identification.table_study import TableStudy


def test_the_load_on_a_known_arm_is_recovered(known):
    """Recovery figure: 10 s, 0.1 N m, friction unknown: mass to 4 g, centre to 0.5 mm, tensor to 2e-3 kg m^2."""
    found = identify_load(logs_of(loaded(known), 2), ARM)
    miss = found.parameters - TRUTH
    assert np.abs(miss / found.sigma).max() < 4.5
    assert abs(miss[0]) < 4e-3
    assert np.abs(found.parameters[1:4] / found.parameters[0] - COM).max() < 5e-4
    assert np.abs(miss[4:]).max() < 2e-3
    assert found.found
    assert found.determined.all()
    assert found.without.max() > 20 * found.left.max()
    assert "coulomb+_1" in found.nuisance
    assert found.systematic == ()


@pytest.mark.slow
def test_errors_cover_where_the_arm_is_fitted_too():
    """Errors of noise alone: an arm off its table does not count."""
    arm, z = TableStudy.of("random6"), []
    for run in range(12):
        log, load, bare = arm.loaded("natural", run)
        found = identify_load([log], arm.arm, RULES[:1], unloaded=[bare])
        z.append((found.parameters - load) / found.sigma)
        assert found.share == 0.0
    assert (np.abs(z) < 3.0).mean() > 0.98
    assert 0.7 < np.mean(np.square(z)) < 1.4


@pytest.mark.slow
@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_errors_cover_loads_on_arms_off_their_tables(name):
    """A seeded share of the soak line `loads_cover`: 5 % of masses and tensors, 3 mm of centres."""
    arm = TableStudy.of(name)
    z = np.array([arm.load_pulls("natural", run) for run in range(8)])
    assert (np.abs(z) < 3.0).mean() > 0.95
    assert np.abs(z).max() < 5.0


def test_an_arm_is_never_taken_to_be_its_table(known):
    """Where what is left is noise, the load was up to 250 of its errors off."""
    found = identify_load(logs_of(loaded(known), 2), ARM)
    assert found.share == LEAST_SHARE
    assert not found.in_doubt
    text = load_document(found).text()
    assert "; its errors are those of an arm 3% off its table" in text
    assert "DOUBT" not in text


def test_unloaded_logs_take_the_arms_own_errors_out():
    """An arm 10 per cent off its table: with its table alone the load is wrong by many sigma, with empty runs not."""
    plant = perturbed_plant(TorqueColumns(ARM.chain), ARM, np.random.default_rng(3), 0.1)
    with_load, empty = logs_of(loaded(plant), 4), logs_of(plant, 5)
    alone = identify_load(with_load, ARM)
    together = identify_load(with_load, ARM, unloaded=empty)
    assert np.abs((together.parameters - TRUTH) / together.sigma).max() < 4.5
    assert np.abs(together.parameters[0] - MASS) < 0.02 < np.abs(alone.parameters[0] - MASS)
    assert alone.systematic
    assert together.systematic == ()
    assert "without the load" in together.known


def test_friction_of_the_arm_itself_is_taken_where_asked(known):
    plant = loaded(known)
    arm = replace(ARM, friction=plant.columns.friction_of(plant.parameters))
    own = identify_load(logs_of(plant, 6), arm, friction="own")
    assert np.abs((own.parameters - TRUTH) / own.sigma).max() < 4.5
    assert own.nuisance == ()
    with pytest.raises(OptionError, match="has none"):
        identify_load(logs_of(plant, 6), ARM, friction="own")
    with pytest.raises(OptionError, match="unloaded"):
        identify_load(logs_of(plant, 6), arm, friction="own", unloaded=logs_of(plant, 7))
    with pytest.raises(OptionError, match="directions, symmetric, own"):
        identify_load(logs_of(plant, 6), arm, friction="none")


def test_no_load_is_not_found(known):
    found = identify_load(logs_of(known, 8), ARM)
    assert not found.found
    assert abs(found.parameters[0]) < 4 * found.sigma[0]


@pytest.mark.slow
def test_columns_of_a_load_are_those_of_a_body_behind_the_flange():
    """Against the recursion: torques with the load, less torques without it, of an arm whose tool is turned."""
    tool = lwr_dyn.load("lwr4plus", "physical", tool={"xyz": [0.05, 0.0, 0.12], "rpy": [0.4, -0.3, 0.7]})
    columns = TorqueColumns(tool.chain)
    motion = random_motion(tool, 2.0, np.random.default_rng(0))
    chains = tool.chain, with_payload(tool.chain, MASS, COM, TENSOR)
    bare, full = (torques(columns, columns.own(replace(tool, chain=chain)), motion) for chain in chains)
    Y = columns(motion.q, motion.dq, motion.ddq)[:, :, columns.bodies - 10 : columns.bodies]
    assert Y @ load_shift(tool.chain.flange) @ TRUTH == pytest.approx(full - bare, abs=1e-11)


def test_an_arm_that_does_not_move_shows_no_load(known):
    log = logs_of(loaded(known), 9)[0]
    still = replace(log, q=np.broadcast_to(log.q[:1], log.q.shape))
    with pytest.raises(LogError, match="mass is not determined"):
        identify_load([still], ARM)


def test_a_slow_motion_takes_a_low_filter(known):
    """At 20 Hz the noise of accelerations biases the load; the colour of the residuals shows it."""
    plant, rng = loaded(known), np.random.default_rng(11)
    slow = simulated_log(plant, random_motion(ARM, 12.0, rng, rate=1000.0, share=0.15), 0.05, rng, 5e-5)
    fits = {rule.cutoff: identify_load([slow], ARM, [rule]) for rule in RULES}
    chi2 = {c: (f.parameters - TRUTH) @ np.linalg.solve(f.covariance, f.parameters - TRUTH) for c, f in fits.items()}
    chosen = identify_load([slow], ARM)
    assert chosen.cutoff in (5.0, 10.0)
    assert chi2[chosen.cutoff] < 35.0 < chi2[20.0]


def test_an_arm_off_its_table_puts_the_load_in_doubt_and_widens_its_errors(known):
    """All bodies 15 per cent heavier and no load: that was a load of 0.5 kg at 94 of its errors."""
    heavier = known.parameters.copy()
    heavier[: known.columns.bodies] *= 1.15
    found = identify_load(logs_of(Plant(known.columns, heavier), 8), ARM)
    assert 0.3 < found.parameters[0] < 4.0 * found.sigma[0]
    assert 0.05 < found.share < 0.3
    said = "IN DOUBT: residuals are not noise alone, its errors are those of an arm"
    assert said in load_document(found).verdict
