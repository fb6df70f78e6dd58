"""The whole of `identify motion` on what MuJoCo's arm logs: a road that shares no step of ours."""

import numpy as np
import pytest

from tests.identification.mujoco_study import BIG_ROTORS, mujoco_fit

pytestmark = pytest.mark.slow


def test_large_rotors_of_an_arm_whose_table_has_none_are_found_and_gains_follow():
    fit = mujoco_fit("iiwa14", "rotors", 0)
    assert np.sqrt(np.mean(fit.base**2)) < 1.3
    assert np.abs(fit.base).max() < 4.5
    assert (np.abs(fit.rotors) < 3.0).all()
    assert np.abs(fit.armature / BIG_ROTORS - 1.0).max() < 0.1
    assert (fit.sigma < 0.2 * np.array(BIG_ROTORS)).all()
    assert np.abs(fit.gains - 1.0).max() < 0.2
    assert not fit.refused
