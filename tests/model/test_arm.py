"""An arm checks its limits and friction, keeps the sources of what stays, and refuses impossible locks."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import MissingDataError, OptionError, RatingWarning, ShapeError, UnknownNameError
from lwr_dyn.foundation.registry import Option, Quantity
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.model.arm import JointGains, JointLimits, Ratings, arm_with_payload, arm_with_scaled_inertia, si_value
from lwr_dyn.model.chain import Rotor, with_payload
from lwr_dyn.model.friction import symmetric
from tests.random_arms import random_arm

ARM = lwr_dyn.load("lwr4plus")
WAM = lwr_dyn.load("wam7")


def test_unknown_limits_are_infinite_and_friction_per_direction_comes_before_their_pair():
    limits = tuple(replace(x, viscous=0.5) for x in WAM.limits)
    assert replace(WAM, limits=limits).friction_models() == WAM.friction
    limits = (JointLimits(viscous=0.5), JointLimits(coulomb=2.0), *[JointLimits()] * 5)
    plain = replace(WAM, limits=limits, friction=())
    assert plain.friction_models() == (symmetric(0.0, 0.5), symmetric(2.0, 0.0), *[None] * 5)
    known = JointLimits(-1.0, 2.0, 3.0, 4.0)
    arm = replace(ARM, limits=(known, *(JointLimits(),) * 6))
    for found, first, unknown in ((arm.lower, -1.0, -np.inf), (arm.upper, 2.0, np.inf), (arm.velocity, 3.0, np.inf),
                                  (arm.effort, 4.0, np.inf)):  # fmt: skip
        assert found.tolist() == [first, *[unknown] * 6]
    assert arm.friction_models() == (None,) * 7
    assert len(repr(ARM.chain)) < 100


def test_a_payload_changes_one_body_and_drops_its_sources_only():
    loaded = ARM.with_chain(with_payload(ARM.chain, 2.0))
    gone = set(ARM.sources) - set(loaded.sources)
    assert gone == {name for name in ARM.sources if name.startswith("link_7.")}
    assert loaded.chain.bodies[-1].mass == ARM.chain.bodies[-1].mass + 2.0


def test_a_locked_joint_leaves_the_others_with_their_numbers():
    locked = WAM.with_locked_joint("joint_3", 0.5)
    kept = [0, 1, 3, 4, 5, 6]
    assert locked.joint_names == tuple(WAM.joint_names[i] for i in kept)
    assert locked.lower.tolist() == WAM.lower[kept].tolist()
    assert locked.friction == tuple(WAM.friction[i] for i in kept)
    assert locked.gains.Kp.tolist() == WAM.gains.Kp[kept].tolist()
    assert locked.transmission is None
    assert not any(name.startswith(("joint_3.", "link_2.", "link_3.")) for name in locked.sources)


def test_a_lock_leaves_mount_and_tool_where_they_are():
    tool = {"xyz": [0.0, 0.1, 0.2], "mass": 1.5, "inertia": [3e-3, 4e-3, 2e-3]}
    arm = lwr_dyn.load("lwr4plus", mount="wall", tool=tool)
    locked, q = arm.with_locked_joint("joint_3", 0.4), np.linspace(-0.5, 0.5, 6)
    whole = np.insert(q, 2, 0.4)
    there = lwr_dyn.forward_kinematics(arm, whole)
    np.testing.assert_allclose(lwr_dyn.forward_kinematics(locked, q), there, atol=1e-15)
    full = lwr_dyn.dynamics_of(arm).gravity_vector(whole)
    np.testing.assert_allclose(lwr_dyn.dynamics_of(locked).gravity_vector(q), np.delete(full, 2), atol=1e-12)
    assert locked.installation.tool.mass == 0.0
    again = locked.uninstalled()
    assert again.installation is None
    assert again.chain.bodies[-1].mass == arm.chain.bodies[-1].mass
    assert again.uninstalled() is again
    for end in (ARM.lower[0], ARM.upper[0]):
        assert ARM.with_locked_joint("joint_1", float(end)).n == 6
        with pytest.raises(OptionError, match="lock of joint_1"):
            ARM.with_locked_joint("joint_1", float(np.nextafter(end, 9.0 * end)))


def test_a_payload_is_a_point_at_the_flange_where_nothing_else_is_said():
    q = np.linspace(-0.6, 0.9, 7)
    bare, J = lwr_dyn.dynamics_of(ARM).gravity_vector(q), jacobian(ARM.chain, q)[:3]
    weight = lwr_dyn.dynamics_of(arm_with_payload(ARM, 2.0)).gravity_vector(q) - bare
    np.testing.assert_allclose(weight, 2.0 * 9.81 * J[2], atol=1e-12)
    B = lwr_dyn.dynamics_of(arm_with_payload(ARM, 2.0)).mass_matrix(q) - lwr_dyn.dynamics_of(ARM).mass_matrix(q)
    np.testing.assert_allclose(B, 2.0 * J.T @ J, atol=1e-12)
    rated = replace(ARM, ratings=Ratings(payload=2.0))
    assert arm_with_payload(rated, 2.0).chain.bodies[-1].mass == ARM.chain.bodies[-1].mass + 2.0
    with pytest.warns(RatingWarning, match="lwr4plus: a payload of 2.1 kg is over the rated 2 kg"):
        arm_with_payload(rated, 2.1)
    doubled = lwr_dyn.dynamics_of(arm_with_scaled_inertia(ARM, 2.0))
    np.testing.assert_allclose(doubled.gravity_vector(q), 2.0 * bare, atol=1e-12)
    for factor in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(OptionError, match=r"mass factor: .*; allowed: a number above 0"):
            arm_with_scaled_inertia(ARM, factor)
    gains = JointGains(*np.arange(8.0).reshape(4, 2)).of_joints([1])
    assert [x.tolist() for x in (gains.Kp, gains.Kd, gains.Ki, gains.effort)] == [[1.0], [3.0], [5.0], [7.0]]


def test_options_are_given_in_degrees_and_metres():
    sliding = random_arm(1, "RP")
    for kind, given, wanted in (
        (Quantity.ANGLE, 90.0, np.pi / 2), (Quantity.ANGLES, (0.0, 90.0, 180.0), (0.0, np.pi / 2, np.pi)),
        (Quantity.JOINT_POSITIONS, (90.0, 0.5), (np.pi / 2, 0.5)), (Quantity.POINT, (1.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
    ):  # fmt: skip
        assert np.array_equal(si_value(Option(kind, ""), given, sliding, "--x"), wanted)
    assert [si_value(Option(bool, "", default=x), None, sliding, "--x") for x in (True, False)] == [False, True]
    with pytest.raises(ShapeError, match=f"--x: 3 numbers; allowed: 2 numbers: {sliding.name} has 2 joints"):
        si_value(Option(Quantity.JOINT_POSITIONS, ""), (1.0, 2.0, 3.0), sliding, "--x")
    with pytest.raises(ShapeError, match="--x: 2 numbers; allowed: 3 numbers"):
        si_value(Option(Quantity.ANGLES, ""), (1.0, 2.0), sliding, "--x")


def test_impossible_locks_are_refused():
    last = ARM
    for joint in ARM.joint_names[:-1]:
        last = last.with_locked_joint(joint, 0.0)
    for arm, joint, value, error, words in (
        (ARM, "joint_9", 0.0, UnknownNameError, "no joint of lwr4plus named 'joint_9'"),
        (ARM, "joint_1", 9.0, OptionError, r"lock of joint_1: 9\.0; allowed: -2\.96706 to 2\.96706"),
        (last, "joint_7", 0.0, OptionError, "lock of joint_7: the last joint; allowed: at least one joint that moves"),
    ):
        with pytest.raises(error, match=words):
            arm.with_locked_joint(joint, value)


def test_dynamics_without_masses_names_what_is_missing():
    links = (replace(ARM.chain.links[0], body=None), *ARM.chain.links[1:])
    for arm, words in (
        (lwr_dyn.load("lwr4"), "lwr4: masses and inertias not given; needed for dynamics"),
        (replace(ARM, chain=replace(ARM.chain, links=links)), "masses and inertias of link_1 not given"),
    ):
        with pytest.raises(MissingDataError, match=words):
            arm.require_dynamics()


def test_rotors_between_joints_and_friction_with_load_are_said_above_rounding():
    """TX40: 0.0105 kg m^2 between joints 5 and 6; a millionth of the largest armature is rounding."""
    tx40 = lwr_dyn.load("tx40")
    for last, said in ((0.9e-6, False), (1.1e-6, True)):
        armature = (0.1, 0.1, 0.1, 0.1, 1.0, last)
        links = [replace(x, rotor=Rotor(1.0, y, True)) for x, y in zip(tx40.chain.links, armature, strict=True)]
        assert bool(tx40.with_chain(replace(tx40.chain, links=tuple(links))).coupled_rotors) == said
    assert replace(tx40, transmission=None).coupled_rotors == ""
    bare = [replace(x, rotor=None if k in (1, 3) else x.rotor) for k, x in enumerate(ARM.chain.links)]
    said = "lwr4plus (physical): no rotor inertia of joint_2 and joint_4 given (add it): gears make a real arm heavier"
    assert ARM.with_chain(replace(ARM.chain, links=tuple(bare))).rotor_caveat("add it").startswith(said)
    assert ARM.rotor_caveat() == ""
    assert tx40.with_locked_joint("joint_1", 0.0).coupled_rotors == ""
    grows = replace(WAM, friction=(None, replace(WAM.friction[1], load=0.123), *WAM.friction[2:]))
    assert grows.friction_with_load == "left out: friction that grows with the load, 0.12 of it at joint_2"
    assert (WAM.friction_with_load, WAM.has_friction, ARM.has_friction) == ("", True, False)
    assert replace(ARM, limits=(JointLimits(viscous=0.0, coulomb=0.0),) * 7).has_friction is False
