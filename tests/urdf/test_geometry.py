"""Default shapes of an arm: on links that exist, hinges across limbs, rings around them."""

import numpy as np
import pytest
from hypothesis import given

from lwr_dyn.urdf.geometry import COLOURS, primitives
from tests.arms import arms


@given(arms)
def test_any_arm_has_shapes_that_can_be_drawn(arm):
    shapes = primitives(arm)
    assert {shape.link for shape in shapes} <= {"base", *(link.link for link in arm.chain.links), "flange"}
    assert shapes[-1].link == "flange"
    for shape in shapes:
        assert shape.radius > 0.0
        assert shape.length > 0.0
        assert shape.colour in COLOURS
        np.testing.assert_allclose(shape.pose.rotation @ shape.pose.rotation.T, np.eye(3), atol=1e-12)


def test_limbs_reach_from_joint_to_joint(arm):
    limbs = {s.link: s for s in primitives(arm) if s.colour == "orange"}
    assert {link: limb.length for link, limb in limbs.items()} == pytest.approx(
        {"link_3": 0.4, "link_5": 0.39, "link_7": 0.078}
    )
    for i, joint in enumerate(arm.joints()[1:], start=1):
        limb = limbs.get(f"link_{i}")
        if limb is not None:
            end = limb.pose.position + limb.pose.rotation[:, 2] * limb.length / 2
            np.testing.assert_allclose(end, joint.origin.position, atol=1e-12)


def test_hinges_lie_across_and_rings_about_the_limbs(arm):
    dark = {s.link: s for s in primitives(arm) if s.colour == "dark"}
    for link in ("link_2", "link_4", "link_6"):
        assert dark[link].length > 2 * dark[link].radius
    for link in ("link_3", "link_5"):
        assert dark[link].length < dark[link].radius
        assert dark[link].pose.position @ np.array([0.0, 0.0, 1.0]) > 0.0
