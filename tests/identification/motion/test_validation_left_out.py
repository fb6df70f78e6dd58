"""How well torques that no fit takes are predicted: slow instants, and those beside reversals."""

import numpy as np

import lwr_dyn
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

NOISE = 0.1


def test_stribeck_friction_shows_in_the_torques_that_are_left_out():
    """Three joints have it, at 0.02 rad/s: no fit above 0.06 rad/s sees it, what is left out does."""
    arm = lwr_dyn.load("lwr4plus", "physical")
    speeds = np.array([0.02, 0.02, 0.02, np.nan, np.nan, np.nan, np.nan])
    rng = np.random.default_rng(4)
    plant = perturbed_plant(TorqueColumns(arm.chain, "directions", speeds), arm, rng)
    log = simulated_log(plant, random_motion(arm, 20.0, rng, 1000.0), NOISE, rng, 1e-5)
    found = identify_motion([log], arm)
    for seen in (found.validation, found.validated_on([log])):
        left = np.array([one.left_out for one in seen])
        unseen = np.array([one.held_out for one in seen])
        assert (left[:3] > 2.0 * unseen[:3]).all()
        assert (left[3:] < 1.5 * unseen[3:]).all()
        assert (unseen < 1.4 * NOISE).all()
