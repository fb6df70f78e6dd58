"""Reading a URDF: our own comes back as it was, a foreign one as the format says."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.chain import Body, JointKind, lock_joint
from lwr_dyn.model.spatial import from_rpy
from tests.arms.urdf.small_files import LIMIT, LINK, joint, robot, written
from tests.random_arms import random_arm
from tests.tolerances import EXACT, METRES


def close(a, b, scale=0.0):
    return np.abs(a - b).max() <= EXACT * max(np.abs(b).max(), scale)


def same_motion(a, b):
    q = np.random.default_rng(3).uniform(-2, 2, (20, a.n))
    return np.abs(lwr_dyn.forward_kinematics(a, q) - lwr_dyn.forward_kinematics(b, q)).max() <= METRES


def same_dynamics(a, b):
    """B, C, g and the flange; a single joint has C = 0, which is compared on the scale of B."""
    q, dq = np.random.default_rng(3).uniform(-2, 2, (2, 20, a.n))
    one, two = newton_euler_dynamics(a.chain), newton_euler_dynamics(b.chain)
    mass = two.mass_matrix(q)
    return (
        close(one.mass_matrix(q), mass)
        and close(one.coriolis_matrix(q, dq), two.coriolis_matrix(q, dq), np.abs(mass).max())
        and close(one.gravity_vector(q), two.gravity_vector(q))
        and same_motion(a, b)
    )


CASES = [(robot, reading) for robot in studied() for reading in lwr_dyn.readings(robot)]


@pytest.mark.slow
@pytest.mark.parametrize("case", [*CASES, *range(12)], ids=str)
def test_what_we_wrote_of_any_arm_comes_back_whole(tmp_path, case):
    arm = random_arm(case) if isinstance(case, int) else lwr_dyn.load(*case)
    back = read_urdf(written(tmp_path, urdf_text(arm)))
    assert (back.joint_names, back.limits) == (arm.joint_names, arm.limits)
    assert list(back.chain.gravity) == list(arm.chain.gravity)
    for one, two in zip(back.chain.links, arm.chain.links, strict=True):
        assert (one.link, one.kind, one.rotor, one.body is None) == (two.link, two.kind, two.rotor, two.body is None)
    assert same_motion(back, arm)
    assert arm.chain.bodies is None or same_dynamics(back, arm)


def test_stand_ins_are_unknown_and_names_taken_under_our_own_header_only(tmp_path):
    text = urdf_text(lwr_dyn.load("lwr4"))
    assert read_urdf(written(tmp_path, text)).limits[0].upper is None
    edited = text.replace('upper="6.283185307179586"', 'upper="1.5"', 1)
    assert read_urdf(written(tmp_path, edited)).limits[0].upper == 1.5
    foreign = text.replace("written by lwr_dyn", "written by somebody")
    assert read_urdf(written(tmp_path, foreign)).limits[0].effort == 1e9
    text = robot(joint("flange_joint", "x", "base"), joint("j2", "base", "flange"), x="", base=LINK, flange=LINK)
    arm = read_urdf(written(tmp_path, text))
    assert arm.joint_names == ("flange_joint", "j2")
    assert [x.link for x in arm.chain.links] == ["base_", "flange_"]
    assert same_dynamics(read_urdf(written(tmp_path, urdf_text(arm), "again.urdf")), arm)
    taken = robot(joint("j1", "x", "base"), joint("j2", "base", "base_"), x="", base=LINK, base_=LINK)
    assert [x.link for x in read_urdf(written(tmp_path, taken)).chain.links] == ["base__", "base_"]


def test_zeros_on_a_welded_frame_say_nothing_about_the_link_that_carries_it(tmp_path):
    zeros = '<inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0"/></inertial>'
    tool = joint("t", "b", "tool", "fixed", "")
    bare, framed = (
        read_urdf(written(tmp_path, robot(joint("j", "a", "b"), tool, a="", b=inside, tool=zeros))).chain.links[0].body
        for inside in ("", LINK)
    )
    assert bare is None
    alone = read_urdf(written(tmp_path, robot(joint("j", "a", "b"), a="", b=LINK))).chain.links[0].body
    assert (framed.mass, list(framed.com)) == (alone.mass, list(alone.com))
    assert np.array_equal(framed.inertia_com, alone.inertia_com)


def test_an_axis_has_a_direction_and_no_length_and_unknown_shapes_do_not_matter(tmp_path, caplog):
    text = robot(joint("j", "a", "b", axis="1 2 -2"), a="", b=LINK)
    one, two = (read_urdf(written(tmp_path, t)) for t in (text, text.replace("1 2 -2", "10 20 -20")))
    assert same_dynamics(one, two)
    turned = lwr_dyn.forward_kinematics(one, [1.0]) @ np.linalg.inv(lwr_dyn.forward_kinematics(one, [0.0]))
    axis = lwr_dyn.forward_kinematics(one, [0.0])[:3, :3] @ np.array([1, 2, -2]) / 3
    assert np.abs(turned[:3, :3] @ axis - axis).max() <= METRES
    shapes = (
        '<visual><geometry><capsule radius="1"/></geometry></visual>'
        '<collision><geometry><mesh filename="no.stl"/></geometry></collision>'
    )
    assert read_urdf(written(tmp_path, robot(joint("j", "a", "b"), a=shapes, b=LINK + shapes))).n == 1
    assert not caplog.records


def test_a_link_welded_on_adds_its_body_and_an_inertial_frame_may_be_turned(tmp_path):
    text = robot(joint("j", "a", "b"), joint("weld", "b", "c", "fixed", ""), a="", b=LINK, c=LINK)
    heavy = read_urdf(written(tmp_path, text))
    light = read_urdf(written(tmp_path, robot(joint("j", "a", "b"), a="", b=LINK)))
    body, found = light.chain.links[0].body, heavy.chain.links[0].body
    turn = from_rpy((0.3, -0.2, 0.1))
    assert close(body.inertia_com, turn @ np.diag([0.02, 0.03, 0.04]) @ turn.T)
    expected = body + body.seen_from(heavy.chain.flange)
    assert found.mass == 4.0
    assert close(found.com, expected.com)
    assert close(found.inertia_com, expected.inertia_com)
    b, c = (f"/robot/link[@name='{name}']/inertial" for name in "bc")
    assert [(x.cell, x.conversion) for x in heavy.sources["b.mass"]] == [(b, "welded to b"), (c, "welded to b")]
    j, actuator = "/robot/joint[@name='j']", "/robot/transmission[joint/@name='j']/actuator"
    elements = {f"j.{x}": f"{j}/limit/@{x}" for x in ("lower", "upper", "velocity", "effort")}
    elements |= {"j.viscous": f"{j}/dynamics/@damping", "j.coulomb": f"{j}/dynamics/@friction"}
    elements |= {f"j.{x}": f"{actuator}/drake:{x}" for x in ("gear_ratio", "rotor_inertia")}
    elements |= dict.fromkeys(("b.mass", "b.com", "b.inertia"), b)
    expected = {name: [(cell, "as written")] for name, cell in elements.items()} | {
        "flange": [], "j.before": [(f"{j}/origin", "origins and locked joints multiplied")],
        "j.after": [(f"{j}/axis", "z turned onto the axis")]}  # fmt: skip
    assert {name: [(x.cell, x.conversion) for x in found] for name, found in light.sources.items()} == expected


def test_a_lock_in_the_chain_is_the_locked_chain(tmp_path):
    text = robot(joint("j1", "a", "b"), joint("j2", "b", "c", axis="1 0 1"), joint("j3", "c", "d", "prismatic"),
                 a="", b=LINK, c=LINK, d=LINK)  # fmt: skip
    path = written(tmp_path, text)
    whole = read_urdf(path)
    for k, (name, value) in enumerate({"j1": 0.3, "j2": -0.4, "j3": 0.2}.items()):
        locked = read_urdf(path, lock={name: value})
        expected = replace(whole, chain=lock_joint(whole.chain, k, value), limits=whole.limits[:2])
        assert name not in locked.joint_names
        assert same_dynamics(locked, expected)


def test_a_moving_branch_is_held_at_a_lock_or_at_0_and_counts(tmp_path):
    """A mimic follows the joint that it mimics; what hangs on the root is left out."""
    mimic = LIMIT + '<mimic joint="finger" multiplier="-2" offset="0.1"/>'
    text = robot(joint("j", "a", "b"), joint("tool", "b", "t", "fixed", ""), joint("finger", "b", "f", "prismatic"),
                 joint("nail", "f", "n"), joint("twin", "b", "g", "prismatic", mimic), joint("other", "a", "c"),
                 a=LINK, b=LINK, t="", f=LINK, n=LINK, g=LINK, c=LINK)  # fmt: skip
    path = written(tmp_path, text)
    held, same, locked, follows, apart = (read_urdf(path, tip="t", lock=lock) for lock in (
        {}, {"finger": 0.0, "nail": 0.0, "twin": 0.1}, {"finger": 0.3, "nail": 0.0},
        {"finger": 0.3, "nail": 0.0, "twin": -0.5}, {"finger": 0.3, "nail": 0.0, "twin": 0.5}))  # fmt: skip
    assert held.notes == ("held: finger at 0, nail at 0, twin at 0.1; other values: --lock JOINT=VALUE",)
    assert (held.joint_names, held.chain.links[0].body.mass, locked.notes) == (("j",), 8.0, ())
    assert same_dynamics(held, same)
    assert same_dynamics(locked, follows)
    assert not same_dynamics(held, locked)
    assert not same_dynamics(locked, apart)


@pytest.mark.parametrize(
    ("kind", "inside", "expected"),
    [
        ("continuous", '<limit effort="9" velocity="3"/>', (None, None, 3.0, 9.0, None, None)),
        ("continuous", LIMIT, (None, None, 3.0, 9.0, None, None)),
        ("revolute", '<limit lower="-1" upper="inf" effort="0" velocity="0"/>', (-1.0, None, None, None, None, None)),
        ("revolute", LIMIT + '<dynamics damping="0.5" friction="0.25"/>', (-2.0, 2.0, 3.0, 9.0, 0.5, 0.25)),
        ("prismatic", LIMIT + '<dynamics damping="0"/>', (-2.0, 2.0, 3.0, 9.0, 0.0, None)),
    ],
)
def test_limits_and_friction(tmp_path, kind, inside, expected):
    arm = read_urdf(written(tmp_path, robot(joint("j", "a", "b", kind, inside), a="", b=LINK)))
    found = arm.limits[0]
    assert (found.lower, found.upper, found.velocity, found.effort, found.viscous, found.coulomb) == expected
    assert arm.chain.links[0].kind is (JointKind.PRISMATIC if kind == "prismatic" else JointKind.REVOLUTE)


def test_a_link_without_inertial_is_massless_only_if_mass_hangs_on_it(tmp_path):
    joints = joint("j1", "a", "b"), joint("j2", "b", "c", axis="1 0 0")
    inner = read_urdf(written(tmp_path, robot(*joints, a="", b="", c=LINK)))
    assert inner.chain.links[0].body.mass == Body.massless().mass
    assert np.linalg.eigvalsh(newton_euler_dynamics(inner.chain).mass_matrix([0.1, 0.2]))[0] > 0.0
    outer = read_urdf(written(tmp_path, robot(*joints, a=LINK, b=LINK, c="")))
    assert outer.chain.links[1].body is None
    with pytest.raises(MissingDataError):
        lwr_dyn.dynamics_of(outer)
