"""Default shapes of an arm: on links that exist, hinges across limbs, rings around them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied, template
from lwr_dyn.arms.urdf.geometry import COLOURS, floor_height, primitives
from lwr_dyn.model.chain import joint_motion
from lwr_dyn.model.file_layout import Drawing
from lwr_dyn.model.spatial import Pose
from tests.random_arms import arms


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


def axes_of_shapes(arm, q):
    """Ends (k, 2, 3) and radii (k,) of all shapes in the base at q."""
    here, frames = Pose.identity(), {"base": Pose.identity()}
    for link, joint, value in zip(arm.chain.links, arm.joints(), q, strict=True):
        here = here @ joint.origin @ joint_motion(joint.kind, float(value))
        frames[link.link] = here
    frames["flange"] = here @ arm.flange()
    ends, shapes = [], primitives(arm)
    for shape in shapes:
        pose = frames[shape.link] @ shape.pose
        half = pose.rotation[:, 2] * shape.length / 2
        ends.append((pose.position - half, pose.position + half))
    return np.array(ends), np.array([shape.radius for shape in shapes])


def pieces(arm, q):
    """Into how many pieces the drawing falls: shapes are joined where their axes are nearer than the larger radius."""
    ends, radii = axes_of_shapes(arm, q)
    along = np.linspace(0.0, 1.0, 41)[:, None]
    points = ends[:, None, 0] + along * (ends[:, None, 1] - ends[:, None, 0])
    gap = np.linalg.norm(points[:, None, :, None] - points[None, :, None], axis=-1).min(axis=(2, 3))
    joined = gap <= np.maximum(radii[:, None], radii)
    for _ in radii:
        joined = joined @ joined
    return len({tuple(row) for row in joined})


@pytest.fixture(params=["RRPR modified", "RRPR standard", "PRRP modified", "RRRRRR standard", "RPRP modified"])
def own_arm(request, tmp_path):
    joints, convention = request.param.split()
    path = tmp_path / "own.toml"
    path.write_text(template("own.toml", "own", joints, convention), encoding="utf-8")
    return lwr_dyn.load(path)


@pytest.mark.slow
def test_an_arm_of_ones_own_has_no_gaps_wherever_it_goes(own_arm):
    for q in np.random.default_rng(4).uniform(own_arm.lower, own_arm.upper, (20, own_arm.n)):
        assert pieces(own_arm, q) == 1


@pytest.mark.parametrize("robot", studied())
def test_our_robots_have_no_gaps_and_stand_on_the_floor(robot):
    arm = lwr_dyn.load(robot)
    assert pieces(arm, np.zeros(arm.n)) == 1
    ends, _ = axes_of_shapes(arm, np.zeros(arm.n))
    assert ends[..., 2].min() >= floor_height(arm) - 1e-6


def test_the_stand_is_as_high_as_the_table_says(own_arm):
    assert own_arm.drawing.pedestal == 0.3
    assert floor_height(own_arm) == pytest.approx(-0.3, abs=1e-6)
    assert floor_height(lwr_dyn.load("wam7")) == pytest.approx(-0.35, abs=1e-6)


def test_without_a_stand_nothing_at_the_base_is_below_the_floor(own_arm):
    bare = replace(own_arm, drawing=Drawing())
    ends, radii = axes_of_shapes(bare, np.zeros(bare.n))
    near = np.linalg.norm(ends, axis=2).min(axis=1) < 0.05
    flat = 1.0 - ((ends[:, 1, 2] - ends[:, 0, 2]) / np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)) ** 2
    lowest = ends[..., 2].min(axis=1) - np.sqrt(np.maximum(flat, 0.0)) * radii
    assert lowest[near].min() >= floor_height(bare) - 1e-6
    assert primitives(bare)[0].link == "base"


def test_drawn_lengths_have_no_digits_of_rounding():
    for robot in studied():
        for shape in primitives(lwr_dyn.load(robot)):
            assert max(len(repr(x)) for x in (shape.radius, shape.length)) <= 8


def test_a_travel_without_end_is_not_drawn_to_its_end(own_arm):
    endless = replace(own_arm, limits=tuple(replace(x, lower=-1e6, upper=1e6) for x in own_arm.limits))
    assert max(shape.length for shape in primitives(endless)) < 10.0
