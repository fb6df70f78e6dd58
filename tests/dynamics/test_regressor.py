"""The regressor times the parameters is the recursion; the PUMA 560: what no torque depends on may be unknown."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.checks.arm.model_laws import not_judged
from lwr_dyn.checks.arm.run_checks import check_arm
from lwr_dyn.dynamics.regressor import Regressor, chain_parameters, chain_with_dynamics, friction_columns
from lwr_dyn.foundation.errors import MissingDataError, PaperError
from lwr_dyn.model.chain import is_physical, with_payload
from tests.random_arms import random_arm
from tests.tolerances import RANDOM_ARM


@given(st.integers(0, 10**6))
def test_the_regressor_times_the_parameters_is_the_recursion(seed):
    arm = random_arm(seed)
    q, dq, ddq = np.random.default_rng(seed).uniform(-2, 2, (3, 4, arm.n))
    expected = lwr_dyn.dynamics_of(arm, "newton-euler").inverse_dynamics(q, dq, ddq)
    friction_free = Regressor(arm.chain)(q, dq, ddq) @ chain_parameters(arm.chain)
    assert np.abs(friction_free - expected).max() <= RANDOM_ARM * max(1.0, np.abs(expected).max())


def test_friction_is_one_up_another_down_and_none_at_rest():
    Y = friction_columns(np.array([0.5, -0.5, 0.0]), np.array([2.0, 3.0, 4.0]))
    assert Y.tolist() == [[2.0, 1.0, 0.5, 0.0, 0.0], [3.0, 0.0, 0.0, -1.0, -0.5], [4.0, 0.0, 0.0, 0.0, 0.0]]
    names = "m mx my mz Ixx Ixy Ixz Iyy Iyz Izz", "armature coulomb+ viscous+ coulomb- viscous-"
    wanted = [f"{x}_{i}" for group in names for i in (1, 2) for x in group.split()]
    assert list(Regressor(random_arm(1, "RP").chain).names) == wanted


TEXT = (Path(__file__).parent / "puma560.toml").read_text(encoding="utf-8")
OPEN = "m, my, Ixx, Ixy, Ixz, Iyz, Izz"


def arm_of(text):
    return arm_from_paper(parse_paper(text, "puma560.toml"))


def changed(old, new):
    assert old in TEXT
    return arm_of(TEXT.replace(old, new))


def test_what_no_torque_depends_on_is_accepted_and_listed():
    arm = arm_of(TEXT)
    report = check_arm(arm, states=50)
    # a finding about the published numbers: 0.086 > 0.066 + 0.0125
    assert [v.name for v in report.verdicts if not v.holds] == ["link_3: triangle inequality, I3 over I1 + I2, less 1"]
    line = f"link_1: inertia known in part; no torque depends on {OPEN} about its frame's origin"
    assert report.not_judged == (line,) == tuple(not_judged(arm))
    assert is_physical(arm.chain.links[0].body)
    assert arm.sources["link_1.mass"][0].value == "unknown"
    assert "inertia given in part, the unknown part written as 0: link_1" in lwr_dyn.urdf_text(arm)


def test_the_torques_are_those_of_any_value_in_its_place():
    arm, rng = arm_of(TEXT), np.random.default_rng(3)
    filled = arm_of(TEXT.replace('["unknown", 17.4', "[13.0, 17.4").replace('"unknown"', "0.25"))
    x = rng.uniform(-2, 2, (3, 40, 6))
    ours, theirs = (lwr_dyn.dynamics_of(a).inverse_dynamics(*x) for a in (arm, filled))
    assert np.abs(ours - theirs).max() <= 1e-12 * np.abs(ours).max()


ABOUT = "about its frame's origin is not given; needed for the torque of"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('[0, "unknown", 0]', '"unknown"', f"Iyy of link_1 {ABOUT} joint_1"),
        ('["unknown", 0.35, "unknown"]', '["unknown", "unknown", "unknown"]', f"Iyy of link_1 {ABOUT} joint_1"),
        ("17.4, 4.8", '17.4, "unknown"', f"m of link_3 {ABOUT} joint_2"),
        ("[0, 0, 0.032]", '[0, 0, "unknown"]', f"mz of link_6 {ABOUT} joint"),
    ],
)
def test_what_a_torque_depends_on_is_refused_with_the_joint(old, new, message):
    arm = changed(old, new)
    for engine in ("pinocchio", "newton-euler"):
        with pytest.raises(MissingDataError) as fault:
            lwr_dyn.dynamics_of(arm, engine)
        assert message in str(fault.value)
        words = str(fault.value).partition(": up to ")[2].split(maxsplit=4)
        assert words[1:4] == ["N", "m", "per"]
        assert words[4] == {"m": "kg", "mz": "kg m", "Iyy": "kg m^2"}[message.split()[0]]
        if message.startswith("Iyy"):  # a torque of 1 kg m^2 is the acceleration, of which some are drawn up to pi
            assert 0.8 * np.pi < float(words[0]) <= np.pi
    assert lwr_dyn.forward_kinematics(arm, np.zeros(6)).shape == (4, 4)


def test_where_it_is_mounted_decides():
    """A first moment across the axis of joint 1 is at rest where that axis is vertical, and hangs on a wall."""
    across = TEXT.replace('about = "com"', 'about = "origin"').replace('[0, "unknown", 0]', '"unknown"')
    standing = arm_of(across)
    assert 1 in chain_with_dynamics(standing).links[0].body.unknown
    wall = standing.with_chain(replace(standing.chain, gravity=np.array([9.81, 0.0, 0.0])))
    with pytest.raises(MissingDataError, match=r"mx of link_1 .* needed for the torque of joint_1"):
        chain_with_dynamics(wall)


def test_a_payload_and_a_locked_joint_keep_what_is_unknown():
    arm = arm_of(TEXT)
    assert with_payload(arm.chain, 2.0).links[0].body.unknown == arm.chain.links[0].body.unknown
    assert arm.with_locked_joint("joint_2", 0.1).chain.links[0].body.unknown
    assert lwr_dyn.dynamics_of(arm.with_locked_joint("joint_2", 0.1)).mass_matrix(np.zeros(5)).shape == (5, 5)


def test_a_gear_ratio_below_zero_turns_the_rotor_the_other_way():
    arm, other = arm_of(TEXT), changed("-53.7063", "53.7063")
    q, dq = np.array([0.3, -0.4, 0.5, 0.2, 0.7, 0.1]), np.full(6, 0.8)
    one, two = (lwr_dyn.dynamics_of(a, "newton-euler", rotors="full") for a in (arm, other))
    assert np.array_equal(arm.armature, other.armature)
    assert np.abs(one.inverse_dynamics(q, dq, dq) - two.inverse_dynamics(q, dq, dq)).max() > 1e-3
    with pytest.raises(PaperError, match="a number other than 0"):
        changed("-62.6111", "0")


def test_a_massless_link_is_read_and_its_tensor_is_judged():
    arm = arm_of(TEXT.replace('"unknown", 17.4', "0, 17.4").replace('"unknown"', "0"))
    assert "link_1: mass of a link with a tensor" in [v.name for v in check_arm(arm, states=5).verdicts if not v.holds]


def test_the_armature_of_a_sliding_joint_is_a_mass():
    sliding = template("x.toml", "x", "RP")
    column = '[rotors]\narmature = {{ values = [0.1, 2.5], unit = {}, where = "x", kind = "assumed" }}\n'
    arm = arm_of(sliding + column.format('["kg m^2", "kg"]'))
    assert arm.armature.tolist() == [0.1, 2.5]
    with pytest.raises(PaperError, match="'kg m\\^2' for joint_2; allowed: a unit of a prismatic joint"):
        arm_of(sliding + column.format('"kg m^2"'))
