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
    """Lengths of the WAM are the hypotenuses over the offset of its elbow."""
    lwr, wam = srs_geometry(LWR.chain), srs_geometry(lwr_dyn.load("wam7").chain)
    assert lwr.lengths == pytest.approx((0.40, 0.39))
    assert lwr.wrist_in_flange == pytest.approx([0, 0, -0.078])
    assert (lwr.straight, lwr.first.offset, lwr.last.offset) == (0, 0, 0)
    assert wam.lengths == pytest.approx((np.hypot(0.55, 0.045), np.hypot(0.3, 0.045)), rel=1e-14)
    assert wam.straight == pytest.approx(np.arctan2(0.045, 0.55) + np.arctan2(0.045, 0.3), rel=1e-14)


def test_arms_that_are_not_s_r_s_are_refused():
    assert srs_geometry(random_srs_arm(5).chain) is not None
    others = [random_arm(2, joints) for joints in ("RRRRRR", "RRRPRRR")]
    for arm in (random_srs_arm(5, wrist_off_plane=0.01), *others):
        assert srs_geometry(arm.chain) is None
    for arm, reference, error, words in (
        (random_arm(2, "RRRRRRR"), None, OptionError, "seven-joint"),
        (LWR, [0, 0, 0], OptionError, "not zero"),
        (LWR, [0, 0], ShapeError, "reference"),
    ):
        with pytest.raises(error, match=words):
            require_srs(arm, reference)
