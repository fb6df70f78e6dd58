"""Which six-joint arms have a closed form, exactly or snapped, and the constants that follow from their axes."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.errors import OptionError
from lwr_dyn.kinematics.six_joint_geometry import parallel_arm_geometry, require_wrist_arm, wrist_arm_geometry
from tests.kinematics.six_joint_arms import PARALLEL, TABLES, six_joint_arm

RECOGNISERS = {True: parallel_arm_geometry, False: wrist_arm_geometry}


@pytest.mark.parametrize("name", TABLES)
def test_each_arm_is_of_one_kind_exactly_or_snapped(name):
    exact, calibrated = six_joint_arm(name), six_joint_arm(name, error=1e-4)
    of_kind, other = (RECOGNISERS[is_parallel == (name in PARALLEL)] for is_parallel in (True, False))
    assert of_kind(calibrated.chain) is None
    assert of_kind(calibrated.chain, snap=True).snapped
    assert of_kind(exact.chain, snap=True).snapped == (name in ("m1013", "lite6"))
    assert other(exact.chain, snap=True) is None


def test_constants_of_a_ur10e_are_those_of_its_table():
    g = parallel_arm_geometry(six_joint_arm("ur10e").chain)
    assert g.lengths == pytest.approx((0.6127, 0.57155), abs=1e-15)
    assert abs(g.lateral) == pytest.approx(0.17415, abs=1e-15)
    assert np.hypot(*g.lever) == pytest.approx(0.11985, abs=1e-15)
    assert abs(g.straight) < 1e-12
    rounded = parallel_arm_geometry(six_joint_arm("ur10e", error=1e-4).chain, snap=True)
    assert rounded.lengths == pytest.approx(g.lengths, abs=1e-3)


def test_arms_without_a_spherical_wrist_are_refused_by_name():
    kr30 = lwr_dyn.load("kr30ha")
    with pytest.raises(OptionError, match="lwr4plus"):
        require_wrist_arm(lwr_dyn.load("lwr4plus"))
    bent = replace(kr30.chain.links[3], after=kr30.chain.links[0].after)
    other = kr30.with_chain(replace(kr30.chain, links=(*kr30.chain.links[:3], bent, *kr30.chain.links[4:])))
    assert wrist_arm_geometry(other.chain, snap=True) is None
    with pytest.raises(OptionError, match="only for an S-R-S arm"):
        lwr_dyn.inverse_kinematics(kr30, np.eye(4), arm_angle=0.1)


@pytest.mark.parametrize("error", [0.02, 0.1])
def test_axes_far_from_the_kind_are_not_snapped(error):
    for name in ("ur10e", "kr210"):
        chain = six_joint_arm(name, error).chain
        assert wrist_arm_geometry(chain, snap=True) is parallel_arm_geometry(chain, snap=True) is None
