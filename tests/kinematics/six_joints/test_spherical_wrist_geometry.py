"""Which six-joint arms have a spherical wrist, and the constants that follow from their axes."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.six_joints.spherical_wrist import planar_arm, require_wrist_arm, six_axes, wrist_arm_geometry
from tests.random_arms import random_arm

KR30 = lwr_dyn.load("kr30ha")


def test_constants_of_the_kr30_are_those_of_its_table():
    g = wrist_arm_geometry(KR30.chain)
    assert g.lengths == pytest.approx((0.85, np.hypot(0.145, 0.82)), rel=1e-14)
    assert (abs(g.lateral), np.hypot(*g.lever)) == pytest.approx((0.0, 0.0), abs=1e-14)
    assert abs(g.straight) == pytest.approx(np.arctan2(0.145, 0.82))
    assert planar_arm(six_axes(KR30.chain), ball_starts=4) is None


def test_arms_without_a_spherical_wrist_are_refused_by_name():
    with pytest.raises(OptionError, match="lwr4plus"):
        require_wrist_arm(lwr_dyn.load("lwr4plus"))
    assert six_axes(random_arm(1, "RRPRRR").chain) is None
    bent = replace(KR30.chain.links[3], after=KR30.chain.links[0].after)
    other = KR30.with_chain(replace(KR30.chain, links=(*KR30.chain.links[:3], bent, *KR30.chain.links[4:])))
    assert wrist_arm_geometry(other.chain) is None
    with pytest.raises(OptionError, match="only for an S-R-S arm"):
        lwr_dyn.inverse_kinematics(KR30, np.eye(4), arm_angle=0.1)
