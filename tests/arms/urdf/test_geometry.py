"""Default shapes of an arm: on links that exist, hinges across limbs, rings around them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied, template
from lwr_dyn.arms.urdf.geometry import COLOURS, floor_height, link_radii, primitives, stand_foot
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Chain, ChainLink, JointKind, Tool, joint_motion
from lwr_dyn.model.file_layout import Drawing, DrawnCylinder
from lwr_dyn.model.spatial import Pose, rot_x, rot_y
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


def test_hinges_lie_across_rings_about_the_limbs_and_lengths_have_no_digits_of_rounding(arm):
    dark = {s.link: s for s in primitives(arm) if s.colour == "dark"}
    for link in ("link_2", "link_4", "link_6"):
        assert dark[link].length > 2 * dark[link].radius
    for link in ("link_3", "link_5"):
        assert dark[link].length < dark[link].radius
        assert dark[link].pose.position @ np.array([0.0, 0.0, 1.0]) > 0.0
    for robot in studied():
        for shape in primitives(lwr_dyn.load(robot)):
            assert max(len(repr(x)) for x in (shape.radius, shape.length)) <= 8


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


def test_the_stand_is_as_high_as_the_table_says_and_without_one_nothing_is_below_the_floor(own_arm):
    assert own_arm.drawing.pedestal == 0.3
    assert floor_height(own_arm) == pytest.approx(-0.3, abs=1e-6)
    assert floor_height(lwr_dyn.load("wam7")) == pytest.approx(-0.35, abs=1e-6)
    endless = replace(own_arm, limits=tuple(replace(x, lower=-1e6, upper=1e6) for x in own_arm.limits))
    assert max(shape.length for shape in primitives(endless)) < 10.0  # a travel without end is not drawn to its end
    bare = replace(own_arm, drawing=Drawing())
    ends, radii = axes_of_shapes(bare, np.zeros(bare.n))
    near = np.linalg.norm(ends, axis=2).min(axis=1) < 0.05
    flat = 1.0 - ((ends[:, 1, 2] - ends[:, 0, 2]) / np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)) ** 2
    lowest = ends[..., 2].min(axis=1) - np.sqrt(np.maximum(flat, 0.0)) * radii
    assert lowest[near].min() >= floor_height(bare) - 1e-6
    assert primitives(bare)[0].link == "base"


def made(*joints, drawing=None, mount=None, tool=None):
    """An arm of (kind, where the joint is in the link before, limits), the last place that of the flange."""
    links = []
    for k, (kind, place, limits) in enumerate(joints[:-1], start=1):
        links.append((ChainLink(f"j{k}", f"l{k}", kind, place, Pose.identity(), None), JointLimits(**limits)))
    chain = Chain(tuple(link for link, _ in links), joints[-1][1], np.array([0.0, 0.0, -9.81]))
    arm = Arm("own", "r", "t", chain, tuple(limits for _, limits in links), drawing=drawing or Drawing())
    return arm.installed(mount, tool or Tool()) if mount or tool else arm


def at(x, y, z, rotation=None):
    return Pose(np.eye(3) if rotation is None else rotation, np.array([x, y, z]))


def shown(arm, *links):
    """Shapes of some links: link, colour, position, direction, radius and length."""
    rows = ((s.link, s.colour, *s.pose.position, *s.pose.rotation[:, 2], s.radius, s.length) for s in primitives(arm))
    return [
        tuple(x if isinstance(x, str) else round(float(x), 6) + 0.0 for x in row) for row in rows if row[0] in links
    ]


TURNS, SLIDES = JointKind.REVOLUTE, JointKind.PRISMATIC
R = 0.1
"""[m] Radius of every link that the file gives."""
ACROSS = rot_x(np.pi / 2)
"""The axis of a joint lies along -y of the link before."""


def test_an_elbow_has_housing_axle_and_limb_and_a_wrist_its_ring():
    arm = made((TURNS, at(0, 0, 0.5), {}), (TURNS, at(0, 0, 0.4, ACROSS), {}), (TURNS, at(0, 0.6, 0, ACROSS.T), {}),
               (None, at(0, 0, 0.8), {}), drawing=Drawing(radius=(R, R, R)))  # fmt: skip
    assert shown(arm, "l1") == [("l1", "orange", 0, 0, 0.2, 0, 0, 1, 0.086, 0.4)]
    assert shown(arm, "l2") == [
        ("l2", "grey", 0, 0, 0, 0, 0, 1, 0.1, 0.22), ("l2", "dark", 0, 0, 0, 0, 0, 1, 0.066, 0.236),
        ("l2", "orange", 0, 0.3, 0, 0, 1, 0, 0.086, 0.6),
    ]  # fmt: skip
    assert shown(arm, "l3") == [
        ("l3", "dark", 0, 0, 0.13, 0, 0, 1, 0.093, 0.03), ("l3", "orange", 0, 0, 0.4, 0, 0, 1, 0.086, 0.8),
    ]  # fmt: skip
    assert shown(arm, "flange") == [("flange", "dark", 0, 0, -0.006, 0, 0, 1, 0.07, 0.012)]
    assert shown(arm, "base") == [
        ("base", "dark", 0, 0, 0.015, 0, 0, 1, 0.16, 0.03), ("base", "grey", 0, 0, 0.25, 0, 0, 1, 0.1, 0.5),
    ]  # fmt: skip
    assert floor_height(arm) == 0.0


def test_a_short_limb_has_no_ring_and_a_bend_without_a_hinge_a_housing():
    """The ring needs 1.6 radii; a limb across its own joint's limb before is closed at the corner."""
    for length, rings in ((0.159, 0), (0.161, 1)):
        arm = made((TURNS, at(0, 0, 0.5), {}), (TURNS, at(0, 0, 0.4), {}), (None, at(0, 0, length), {}),
                   drawing=Drawing(radius=(R, R)))  # fmt: skip
        assert [x[1] for x in shown(arm, "l2")] == ["dark"] * rings + ["orange"]
    bent = made((TURNS, at(0, 0, 0.5), {}), (TURNS, at(0.3, 0, 0, rot_y(0.1)), {}), (None, at(0, 0, 0.4), {}),
                drawing=Drawing(radius=(R, R)))  # fmt: skip
    assert shown(bent, "l2")[0] == ("l2", "grey", 0, 0, 0, 0, 0, 1, 0.1, 0.2)
    assert [x[1] for x in shown(bent, "l2")] == ["grey", "dark", "orange"]
    stub = made((TURNS, at(0, 0, 0.5), {}), (TURNS, at(0, 0, 0.4, ACROSS), {}), (TURNS, at(0, 0, 0), {}),
                (None, at(0, 0, 0.01), {}), drawing=Drawing(radius=(R, R, R)))  # fmt: skip
    assert [x[1] for x in shown(stub, "l2")] == ["grey", "dark"]  # across the limb before it, none of its own
    assert shown(stub, "l3")[-1] == ("l3", "orange", 0, 0, 0.005, 0, 0, 1, 0.0258, 0.01)


@pytest.mark.parametrize(("low", "up", "reach"), [(-0.1, 0.4, 0.25), (None, None, 0.2), (0.0, None, 0.2), (-9, 9, 4.0)])
def test_a_slide_upward_runs_on_a_rail_and_another_in_a_guide(low, up, reach):
    limits = {} if low is None else {"lower": low} if up is None else {"lower": low, "upper": up}
    end = (None, at(0.2, 0, 0), {})
    middle = {-0.1: 0.15, None: 0.2, 0.0: 0.2, -9: 0.0}[low]
    rail = made((SLIDES, at(0, 0, 0.3), limits), end, drawing=Drawing(radius=(R,)))
    long = round(2 * reach, 6)
    assert ("base", "grey", 0, 0, round(0.3 + middle, 6), 0, 0, 1, 0.05, long) in shown(rail, "base")
    assert shown(rail, "l1")[0] == ("l1", "dark", 0, 0, 0, 0, 0, 1, 0.1, 0.14)
    guide = made((SLIDES, at(0, 0, 0.3, rot_x(np.pi)), limits), end, drawing=Drawing(radius=(R,)))
    assert ("base", "dark", 0, 0, 0.3, 0, 0, -1, 0.1, 0.16) in shown(guide, "base")
    assert shown(guide, "l1")[0] == ("l1", "grey", 0, 0, -middle + 0.0, 0, 0, 1, 0.05, long)
    level = made((TURNS, at(0, 0, 0), {}), (SLIDES, at(0, 0, 0.3, ACROSS), limits), end, drawing=Drawing(radius=(R, R)))
    assert shown(level, "l2")[0][1] == "grey"  # a direction that turns has no rail


def test_radii_fall_along_the_arm_and_pedestal_and_cylinders_are_as_given():
    arm = made((TURNS, at(0, 0, 0.5), {}), (TURNS, at(0, 0, 0.3), {}), (None, at(0, 0, 0.2), {}))
    np.testing.assert_allclose(link_radii(arm), [1.0 * 0.045 + 0.03 * 0.5, 0.045 + 0.03 * 0.2])
    short = made((TURNS, at(0, 0, 0.02), {}), (None, at(0, 0, 0.01), {}))
    np.testing.assert_allclose(link_radii(short), [0.0045 + 0.0003])
    high = replace(arm, drawing=Drawing(pedestal=0.5, radius=(R, R)))
    assert shown(high, "base")[:2] == [
        ("base", "dark", 0, 0, -0.47, 0, 0, 1, 0.16, 0.06), ("base", "grey", 0, 0, -0.22, 0, 0, 1, 0.105, 0.44),
    ]  # fmt: skip
    assert floor_height(high) == pytest.approx(-0.5)
    drawn = DrawnCylinder("l1", (0.0, 0.0, 0.1), (0.3, 0.0, 0.5), 0.02, "grey")
    arm = made((TURNS, at(0, 0, 0.5), {}), (None, at(0, 0, 0.8), {}), drawing=Drawing(cylinders=(drawn,)))
    assert shown(arm, "l1", "base", "flange") == [("l1", "grey", 0.15, 0, 0.3, 0.6, 0, 0.8, 0.02, 0.5)]


def test_the_column_clears_what_turns_about_the_origin_of_the_base():
    """A hinge there reaches its radius down: 1.15 of that, and two thicknesses of the plate at least."""
    arm = made((TURNS, at(0, 0, 0), {}), (TURNS, at(0, 0, 0.1, ACROSS), {}), (None, at(0.5, 0, 0), {}),
               drawing=Drawing(radius=(R, 1.5 * R)))  # fmt: skip
    assert shown(arm, "base")[:2] == [
        ("base", "dark", 0, 0, -0.045, 0, 0, 1, 0.16, 0.03), ("base", "grey", 0, 0, -0.015, 0, 0, 1, 0.105, 0.03),
    ]  # fmt: skip
    low = replace(arm, drawing=Drawing(radius=(R, 3.0 * R)))
    assert floor_height(low) == pytest.approx(-1.15 * 0.2)
    apart = made((TURNS, at(0, 0, 0), {}), (TURNS, at(0, 0.21, 0, ACROSS), {}), (None, at(0.5, 0, 0), {}),
                 drawing=Drawing(radius=(R, 3.0 * R)))  # fmt: skip
    assert floor_height(apart) == pytest.approx(-1.15 * 0.086)  # the limb of link 1 alone is near enough


def test_floor_and_foot_of_a_mounted_arm():
    joints = ((TURNS, at(0, 0, 0.5), {}), (None, at(0, 0, 0.8), {}))
    pedestal = Drawing(pedestal=0.4, radius=(R,))
    up = made(*joints, drawing=pedestal, mount=at(1.0, 2.0, 0.7))
    assert floor_height(up) == pytest.approx(0.3)
    np.testing.assert_allclose(stand_foot(up), [1.0, 2.0, 0.3])
    side = made(*joints, drawing=pedestal, mount=at(0, 0, 2.0, rot_y(np.pi / 2)))
    assert floor_height(side) == 0.0
    np.testing.assert_allclose(stand_foot(side), [-0.4, 0.0, 2.0], atol=1e-12)
    assert floor_height(made(*joints, mount=at(0, 0, 0.0, rot_x(np.pi)))) == pytest.approx(-0.8)
    tilted = made(*joints, drawing=pedestal, mount=at(0, 0, 2.0, rot_y(0.4)))  # within 26 deg of upright
    assert floor_height(tilted) == pytest.approx(2.0 - 0.4 * np.cos(0.4) - 0.16 * np.sin(0.4))
    tool = made(*joints, drawing=pedestal, tool=Tool(at(0, 0.3, 0.4)))
    assert shown(tool, "flange")[-1] == ("flange", "dark", 0, 0.15, 0.2, 0, 0.6, 0.8, 0.03, 0.5)


def test_a_lean_a_limb_a_rail_and_a_floor_are_judged_at_their_bounds():
    drawing, first, end = Drawing(radius=(R, R)), (TURNS, at(0, 0, 0.5), {}), (None, at(0, 0, 0.4), {})
    for part, beyond in ((0.95, False), (1.05, True)):
        lean = np.arcsin(0.2 * part)  # up to a sine of 0.2 a limb is along its axis, and a corner is straight
        hand = (None, at(0.8 * np.sin(lean), 0, 0.8 * np.cos(lean)), {})
        arm = made(first, (TURNS, at(0, 0, 0.4), {}), hand, drawing=drawing)
        assert shown(arm, "l2")[0][1] == ("grey" if beyond else "dark")
        arm = made(first, (TURNS, at(0, 0, 0.4, rot_y(lean)), {}), end, drawing=drawing)
        assert shown(arm, "l2")[0][1] == ("grey" if beyond else "dark")
        arm = made(first, (TURNS, at(0, 0, 1e-6 * part, ACROSS), {}), end, drawing=drawing)
        assert (shown(arm, "l1") != []) == beyond
        arm = made((TURNS, at(0, 0, 0), {}), (SLIDES, at(0, 0, 0.3, rot_x(1e-3 * part)), {}), end, drawing=drawing)
        assert shown(arm, "l2")[0][1] == ("grey" if beyond else "dark")  # a rod in a guide, a carriage on a rail
        arm = made((SLIDES, at(0, 0, 0.3, rot_x(np.arccos(-0.5 * part))), {}), end, drawing=Drawing(radius=(R,)))
        assert shown(arm, "l1")[0][1] == ("grey" if beyond else "dark")
        mount = at(0, 0, 2.0, rot_y(np.arccos(0.9 * part)))
        assert (floor_height(made(first, end, drawing=Drawing(pedestal=0.4, radius=(R,)), mount=mount)) > 1.0) == beyond
