"""Rules of drives: efforts, speeds, losses, rotors and travel; what they say, and that they stay silent."""

import re

import numpy as np
import pytest

from lwr_dyn.checks.urdf import drive_rules as rules
from lwr_dyn.checks.urdf.document import document_of, link_poses
from lwr_dyn.checks.urdf.inertia_shape_rules import largest_weight
from lwr_dyn.checks.urdf.lint import lint_document
from tests.checks.urdf.box_arm import BoxArm

ARM = BoxArm()
MASSES = np.array([box.mass for box in ARM.boxes[1:]])


def changed(joint, pattern, written):
    """The arm with a piece of one joint exchanged."""
    text, count = re.subn(rf'(<joint name="{joint}".*?){pattern}', rf"\g<1>{written}", ARM.text())
    assert count == 1
    return document_of(text, "f")


def efforts(*values):
    """The arm with these efforts, from the first joint on."""
    text = ARM.text()
    for value in values:
        text = text.replace('effort="150.0"', f'effort="{value}"', 1)
    return document_of(text, "f")


def weights(text, name, upright=False):
    document = document_of(text, "f")
    return largest_weight(document, document.joint_into(name), link_poses(document), upright)


def test_the_weight_behind_each_joint():
    """By hand, all joints at 0: in any mounting, as the file stands, at 5 cm; a slide lifts all, no axis nothing."""
    held = ARM.text().replace('lower="-2" upper="2"', 'lower="-1e-12" upper="1e-12"')
    x, y, z = 9.81 * MASSES * [[0.02, 0.22, 0.45], [0.0, 0.01, 0.0], [0.0, 0.0, 0.09]]
    weight, along = 9.81 * MASSES, x[1:].sum()
    rows = {"l1": (np.hypot(x.sum(), y.sum()), 0.0), "l2": (np.hypot(along, z[2]), along), "l3": (z[2], 0.0)}
    for k, (name, (any_mounting, standing)) in enumerate(rows.items()):
        expected = (any_mounting, 0.05 * weight[k:].sum(), standing, 0.05 * weight[k:].sum())
        assert (*weights(held, name), *weights(held, name, True)) == pytest.approx(expected, rel=1e-9, abs=1e-9)
    slide, still = held.replace("revolute", "prismatic"), held.replace('"0 1 0"', '"0 0 0"')
    assert weights(slide, "l2") == pytest.approx((weight[1:].sum(),) * 2, rel=1e-12)
    assert weights(still, "l2") == (0.0, 0.0)


FIRST, LAST = weights(ARM.text(), "l1")[0], weights(ARM.text(), "l3")[0]
ALL = ("joint j1", "joint j2", "joint j3")


@pytest.mark.parametrize(
    ("values", "subjects", "level"),
    [
        # it holds the arm as it stands at 0; the first axis is vertical: on a wall it would hold the weight
        ((0.02,) * 3, ALL, "warning"), ((150, 150, 0.59 * LAST), ALL[2:], "note"), ((150, 150, 0.61 * LAST), (), ""),
        ((150, 150, 19_900 * LAST), (), ""), ((150, 150, 20_100 * LAST), ALL[2:], "warning"),
        ((0.0, np.nan, 1e6), (), ""), ((3e7,) * 3, (), ""),
        ((0.59 * FIRST,), ALL[:1], "note"), ((0.11 * FIRST,), ALL[:1], "note"), ((0.09 * FIRST,), ALL[:1], "warning"),
        ((150, 0.3 * FIRST), ALL[1:2], "warning"),
        # a round number of three joints stands for "unknown"
        ((900000,) * 3, ALL, "note"), ((900000, 900001, 900002), ALL, "warning"), ((910000,) * 3, ALL, "warning"),
        ((900000, 900000), ALL[:2], "warning"),
    ],
)  # fmt: skip
def test_an_effort_is_held_against_the_weight(values, subjects, level):
    found = [(f.subject, f.level) for f in lint_document(efforts(*values)).findings if f.code == "effort-weight"]
    assert found == [(subject, level) for subject in subjects]


def test_an_effort_says_how_often_it_holds_the_weight_that_it_names():
    """The second has a link of a microgram, its centre on the axis: HEBI's gave a ratio and a weight at odds."""
    *_, weak = rules.effort_against_weight(efforts(*[0.02] * 3))
    text = BoxArm().with_link(3, mass=1.6e-6, com=(0.0, 0.0, 0.0), shapes=" ").text().replace("150.0", "2.5")
    *_, light = rules.effort_against_weight(document_of(text, "f"))
    assert [f.message for f in (weak, light)] == [
        "joint j3: effort 0.02 N m is 0.024 times the weight that it holds; the links behind the joint weigh up to "
        "0.848 N m, any mounting",
        "joint j3: effort 2.5 N m is 3.2e+06 times the weight that it holds; 5 cm from the axis the links behind the "
        "joint weigh 7.85e-07 N m",
    ]


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ((150, 4.9, 150), "effort 4.9 is 0.033 times that of the nearest other joint"),
        ((150, 4600, 152), "effort 4600 is 30 times that of the nearest other joint"),
        ((150, 5.1, 150), ""), ((150, 4400, 150), ""), ((150, 1e9, 150), ""), ((150, 4, 0), ""),
    ],
)  # fmt: skip
def test_an_effort_far_from_all_others(values, says):
    found = [f.message for f in rules.unlike_others(efforts(*values))]
    assert found == [f"joint j2: {says}; the other 2 joints of its type have 150 to {values[2]}"] * bool(says)


DRAKE = "write <drake:rotor_inertia> and <drake:gear_ratio> in the <actuator> of a <transmission>"


@pytest.mark.parametrize(
    ("rule", "name", "value", "says", "code", "level"),
    [
        *((rules.losses_negative, name, "-0.5",
           f'{name} -0.5; it would drive the joint; write <dynamics {name}="0.5"/>, if only the sign is wrong',
           "damping-negative", "error") for name in ("damping", "friction")),
        (rules.armatures_unread, "armature", "0.1",
         f"armature 0.1 of <dynamics>; nothing reads it: the arm counts as one without rotors; {DRAKE}",
         "armature-unread", "note"),
    ],
)  # fmt: skip
def test_what_dynamics_may_not_hold(rule, name, value, says, code, level):
    bad, zero = (changed("j2", "<limit", f'<dynamics {name}="{x}"/><limit') for x in (value, 0))
    assert [f.message for f in rule(bad)] == [f"joint j2: {says}"]
    assert [(f.subject, f.level) for f in lint_document(bad).findings if f.code == code] == [("joint j2", level)]
    assert list(rule(zero)) == list(rule(changed("j2", "<limit", '<dynamics damping="0.5" friction="1"/><limit'))) == []


@pytest.mark.parametrize(
    ("joint", "low", "up", "says"),
    [("j3", 0, 1.01, "a travel of 1.01 m"), ("j3", -4, -4, "a limit of -4 m"), ("j3", -0.4, 1.1, "a travel of 1.5 m"),
     ("j3", -0.5, 0.49, ""), ("j3", 0, 1, ""), ("j1", 0, 4, ""), ("j3", 0, 2e3, "")],
)  # fmt: skip
def test_a_slide_that_travels_further_than_its_arm_is_long(joint, low, up, says):
    """The arm is 1 m long; a slide before all turning joints is a rail, and what travels kilometres has a rule."""
    document = changed(joint, 'revolute"(.*?)lower="-2" upper="2"', rf'prismatic"\g<2>lower="{low}" upper="{up}"')
    says = f"joint j3: {says}; from joint to joint the whole arm is 1 m long; limits in m" if says else ""
    assert [f.message for f in rules.travels_long(document)] == [says] * bool(says)


FAR = (0.1, 0.3, 0.5, 0.4)


def with_speeds(*speeds, origins=(0.1, 0.2, 0.2, 0.1)):
    """A stretched arm of joints that turn in its plane, with these speeds."""
    out = '<robot name="r"><link name="l0"/>'
    for k, (speed, far) in enumerate(zip(speeds, origins, strict=False), start=1):
        out += f'<link name="l{k}"/><joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
        out += f'<origin xyz="{far} 0 0"/><axis xyz="0 0 1"/>'
        out += f'<limit lower="-1" upper="1" effort="9" velocity="{speed}"/></joint>'
    return out + "</robot>"


@pytest.mark.parametrize(
    ("speeds", "found"),
    [
        ((2.5, 20, 2, 2.5), "j2 rpm 2.0944: 8"), ((0.5, 30, 0.4, 0.5), "j2 deg/s 0.523599: 60"),
        ((1.04, 30, 1, 1), "j2 deg/s 0.523599: 29"), ((1.06, 30, 1, 1), "j2 rpm 3.14159: 28"),
        ((0.26, 30, 0.2, 0.2), "j2 rpm 3.14159: 1.2e+02"), ((2, 9.1, 2, 2), "j2 rpm 0.95295: 4.5"), ((2, 9, 2, 2), ""),
        ((1, 6.1, 1, 1), "j2 rpm 0.638791: 6.1"), ((1, 6, 1, 1), ""),  # slow all the same
        ((1, 50, 1, 1), "j2 deg/s 0.872665: 50"), ((1, 51, 1, 1), ""),  # of another rule
        ((2.5, 20.9439510239, 2, 2.5), "j2 rpm 2.19325: 8.4"), ((1, 1, 6.5), ""), ((1, 20, 1, 1e6), ""),  # few others
    ],
)  # fmt: skip
def test_a_speed_in_turns_a_minute_or_degrees_a_second(speeds, found):
    findings = list(rules.velocities_in_rpm(document_of(with_speeds(*speeds), "f")))
    joint, unit, written, times = re.split(": | ", found) if found else [""] * 4
    cause, why = f"velocity limits in {unit}", f"{times} times the fastest of the 3 other joints of its chain"
    expected = [(f"joint {joint}", cause, why, None)] * bool(found)
    assert [(f.subject, f.cause, f.why, f.severity) for f in findings] == expected
    assert all(f'velocity="{written}"' in f.instead and f"which looks like {unit}" in f.what for f in findings)


def test_a_joint_that_follows_another_and_fingers_are_left_alone():
    """Fingers have other motors: several last joints on one link."""
    alone, odd = with_speeds(1, 1, 1, 20), with_speeds(1, 20, 1, 1)
    assert [f.subject for f in rules.velocities_in_rpm(document_of(alone, "f"))] == ["joint j4"]
    finger = alone.partition('<link name="l4"')[2].replace("l4", "l5").replace("j4", "j5")
    two = alone.replace("</robot>", f'<link name="l5"{finger}')
    follow = [text.replace("</joint></robot>", '<mimic joint="j1"/></joint></robot>') for text in (alone, odd)]
    assert [list(rules.velocities_in_rpm(document_of(text, "f"))) for text in (two, *follow)] == [[], [], []]


@pytest.mark.parametrize(
    ("speeds", "origins", "found"),
    [
        ((30, 30, 30, 30), FAR, [("j1", "36", None), ("j2", "27", None)]),  # 1.2 m and 0.9 m from the tip
        # 395 rpm of a humanoid's motors, written as 41.3433333333333 rad/s: converted already
        ((23.55, 30.3433333333333, 30.3, 23.55), FAR, [("j1", "28", None), ("j2", "27", "note")]),
        ((21.9, 1, 1), (0.1, 0.5, 0.5), []), ((22.1, 1, 1), (0.1, 0.5, 0.5), [("j1", "22", None)]),
    ],
)  # fmt: skip
def test_a_whole_file_in_turns_a_minute_shows_in_the_speed_of_the_tip(speeds, origins, found):
    findings = rules.velocities_in_rpm(document_of(with_speeds(*speeds, origins=origins), "f"))
    expected = [(f"joint {x}", f"the farthest link would move at {tip} m/s", level) for x, tip, level in found]
    assert [(f.subject, f.why, f.severity) for f in findings] == expected


@pytest.mark.parametrize("parent", ["l0", "l3"])
def test_the_joints_before_a_joint_and_in_a_loop(parent):
    document = document_of(ARM.text().replace('parent link="l0"', f'parent link="{parent}"'), "f")
    assert [x.name for x in rules.joints_before(document, document.joint_into("l3"))] == ["j2", "j1"]
