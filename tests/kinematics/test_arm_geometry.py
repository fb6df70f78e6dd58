"""Which arms have a closed form, and the constants that follow from their axes."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.arm_geometry import require_srs, srs_geometry
from tests.kinematics.srs_arms import random_srs_arm
from tests.random_arms import random_arm

LWR = lwr_dyn.load("lwr4plus")


def test_constants_follow_from_the_axes():
    geometry = srs_geometry(LWR.chain)
    assert geometry.lengths == pytest.approx((0.40, 0.39))
    assert geometry.wrist_in_flange == pytest.approx([0, 0, -0.078])
    assert (geometry.straight, geometry.first.offset, geometry.last.offset) == (0, 0, 0)


def test_arms_that_are_not_s_r_s_are_refused():
    with pytest.raises(OptionError, match="seven-joint"):
        require_srs(random_arm(2, "RRRRRRR"))
    assert srs_geometry(random_srs_arm(5).chain) is not None
    assert srs_geometry(random_srs_arm(5, wrist_off_plane=0.01).chain) is None
    assert srs_geometry(random_arm(2, "RRRRRR").chain) is None
    assert srs_geometry(random_arm(2, "RRRPRRR").chain) is None
    with pytest.raises(OptionError, match="not zero"):
        require_srs(LWR, [0, 0, 0])
    with pytest.raises(ShapeError):
        require_srs(LWR, [0, 0])


def test_lengths_of_the_wam_are_the_hypotenuses_over_the_elbow_offset():
    geometry = srs_geometry(lwr_dyn.load("wam7").chain)
    assert geometry.lengths == pytest.approx((np.hypot(0.55, 0.045), np.hypot(0.3, 0.045)), rel=1e-14)
    assert geometry.straight == pytest.approx(np.arctan2(0.045, 0.55) + np.arctan2(0.045, 0.3), rel=1e-14)
