"""Rules of drives: efforts, speeds, losses, rotors and travel; what they say, and that they stay silent."""

import re

import numpy as np
import pytest

from lwr_dyn.checks.urdf.document import document_of, link_poses
from lwr_dyn.checks.urdf.drive_rules import (
    armatures_unread,
    effort_against_weight,
    joints_before,
    losses_negative,
    travels_long,
    unlike_others,
    velocities_in_rpm,
)
from lwr_dyn.checks.urdf.inertia_shape_rules import largest_weight
from lwr_dyn.checks.urdf.lint import lint_document
from tests.checks.urdf.box_arm import CENTRES, BoxArm
from tests.tolerances import EXACT

ARM = BoxArm()


def test_the_weight_of_the_last_link():
    document = ARM.document()
    joint = document.joint_into("l3")
    moment, least = largest_weight(document, joint, link_poses(document))
    weight = 9.81 * ARM.boxes[3].mass
    assert moment == pytest.approx(weight * CENTRES[3][2], rel=EXACT)
    assert least == pytest.approx(weight * 0.05, rel=EXACT)


def test_the_weight_behind_the_first_joint_turns_with_the_mounting():
    document = ARM.document()
    moment, _ = largest_weight(document, document.joint_into("l1"), link_poses(document))
    assert moment > 9.81 * ARM.boxes[2].mass * 0.2  # with its axis level


@pytest.mark.parametrize("effort", [0.02, 9e5])
def test_efforts_that_are_too_small_or_too_large(effort):
    found = list(effort_against_weight(BoxArm(effort=effort).document()))
    assert [f.subject for f in found] == ["joint j1", "joint j2", "joint j3"]


def test_silent_on_a_good_arm_and_where_there_is_no_effort():
    assert list(effort_against_weight(ARM.document())) == []
    assert list(effort_against_weight(BoxArm(effort=0.0).document())) == []
    assert list(effort_against_weight(BoxArm(effort=np.nan).document())) == []


@pytest.mark.parametrize("effort", ["4.0", "5000.0"])
def test_an_effort_far_from_all_others(effort):
    assert list(unlike_others(ARM.document())) == []
    text = ARM.text()
    start = text.index("effort", text.index('"j2"'))
    changed = text[:start] + f'effort="{effort}"' + text[text.index(" velocity", start) :]
    assert [f.subject for f in unlike_others(document_of(changed, "f"))] == ["joint j2"]


def test_an_effort_over_a_link_of_almost_no_weight_is_held_against_what_it_says():
    """A link of a microgram whose centre is on the axis: HEBI's files gave a ratio and a weight that contradicted."""
    arm = BoxArm().with_link(3, mass=1.6e-6, com=(0.0, 0.0, 0.0), shapes=" ")
    text = arm.text().replace('effort="150.0"', 'effort="2.5"')
    (found,) = [f for f in effort_against_weight(document_of(text, "f")) if f.subject == "joint j3"]
    ratio = float(re.search(r"is (\S+) times", found.what)[1])
    weight = float(re.search(r"weigh (\S+) N m", found.why)[1])
    assert ratio * weight == pytest.approx(2.5, rel=0.05)
    assert found.why.startswith("5 cm from the axis")


def test_efforts_say_how_often_they_hold_the_weight_that_they_name():
    for effort in (0.02, 9e5):
        for found in effort_against_weight(BoxArm(effort=effort).document()):
            ratio = float(re.search(r"is (\S+) times", found.what)[1])
            weight = float(re.search(r"(\S+) N m", found.why)[1])
            assert ratio * weight == pytest.approx(effort, rel=0.05)


def with_dynamics(attributes, joint="j2"):
    """The arm with a `<dynamics>` in one joint."""
    return document_of(
        re.sub(rf'(<joint name="{joint}".*?)<limit', rf"\1<dynamics {attributes}/><limit", ARM.text()), "f"
    )


@pytest.mark.parametrize("name", ["damping", "friction"])
def test_a_loss_below_zero(name):
    (found,) = losses_negative(with_dynamics(f'{name}="-0.5"'))
    assert (found.subject, found.what) == ("joint j2", f"{name} -0.5")
    assert found.instead.startswith(f'<dynamics {name}="0.5"/>')
    report = lint_document(with_dynamics(f'{name}="-0.5"'))
    assert [(f.code, f.level) for f in report.findings if f.level == "error"] == [("damping-negative", "error")]
    assert list(losses_negative(with_dynamics(f'{name}="0.5"'))) == []


def test_a_rotor_inertia_that_nothing_reads_is_a_note():
    found = [f for f in lint_document(with_dynamics('armature="0.1"')).findings if f.code == "armature-unread"]
    assert [(f.subject, f.level) for f in found] == [("joint j2", "note")]
    assert "nothing reads it" in found[0].why
    assert list(armatures_unread(with_dynamics('armature="0" damping="1"'))) == []


def sliding(joint, low, up):
    """The arm with a joint that slides."""
    text = re.sub(rf'(name="{joint}" type=)"revolute"', r'\1"prismatic"', ARM.text())
    return document_of(re.sub(rf'(name="{joint}".*?)lower="-2" upper="2"', rf'\1lower="{low}" upper="{up}"', text), "f")


def test_a_slide_that_travels_further_than_its_arm_is_long():
    (found,) = travels_long(sliding("j3", 0, 4))
    assert (found.subject, found.why) == ("joint j3", "from joint to joint the whole arm is 1 m long")
    assert list(travels_long(sliding("j3", 0, 0.4))) == []
    assert list(travels_long(sliding("j1", 0, 4))) == []  # a rail


def with_speeds(*speeds, origins=(0.1, 0.45, 0.45)):
    """An arm of turning joints with these speeds."""
    out = '<robot name="r"><link name="l0"/>'
    for k, (speed, far) in enumerate(zip(speeds, origins, strict=True), start=1):
        out += f'<link name="l{k}"/><joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
        out += f'<origin xyz="{far} 0 0"/><axis xyz="0 0 1"/>'
        out += f'<limit lower="-1" upper="1" effort="9" velocity="{speed}"/></joint>'
    return document_of(out + "</robot>", "f")


def test_a_speed_in_turns_a_minute_or_degrees_a_second():
    near = (0.1, 0.2, 0.2, 0.1)
    (found,) = velocities_in_rpm(with_speeds(2.5, 20, 2, 2.5, origins=near))
    assert (found.subject, found.cause) == ("joint j2", "velocity limits in rpm")
    assert 'velocity="2.0944"' in found.instead
    (found,) = velocities_in_rpm(with_speeds(0.5, 30, 0.4, 0.5, origins=near))
    assert found.cause == "velocity limits in deg/s"
    assert list(velocities_in_rpm(with_speeds(2.5, 8, 2, 2.5, origins=near))) == []  # a fast wrist
    assert list(velocities_in_rpm(with_speeds(0.5, 5, 0.4, 0.5, origins=near))) == []  # slow all the same
    assert list(velocities_in_rpm(with_speeds(1, 1, 6, origins=near[:3]))) == []  # too few others to tell


def test_a_whole_file_in_turns_a_minute_shows_in_the_speed_of_the_tip():
    found = list(velocities_in_rpm(with_speeds(30, 30, 30, 30, origins=(0.1, 0.3, 0.5, 0.4))))
    assert [f.subject for f in found] == ["joint j1", "joint j2"]
    assert "36 m/s" in found[0].why


def test_a_speed_of_many_digits_was_converted_already():
    """A humanoid's motors turn at 395 rpm, written as 41.3433333333333 rad/s: its leg's tip would move at 30 m/s."""
    lengths = (0.1, 0.3, 0.5, 0.4)
    found = list(velocities_in_rpm(with_speeds(23.55, 30.3433333333333, 30.3, 23.55, origins=lengths)))
    assert [(f.subject, f.severity) for f in found] == [("joint j1", None), ("joint j2", "note")]
    (found,) = velocities_in_rpm(with_speeds(2.5, 20.9439510239, 2, 2.5, origins=(0.1, 0.2, 0.2, 0.1)))
    assert found.severity is None  # far above the others of its chain, whatever its digits


def test_fingers_may_be_faster_than_the_arm():
    text = with_speeds(1, 1, 1, 20, origins=(0.1, 0.2, 0.2, 0.1)).content.decode()
    assert [f.subject for f in velocities_in_rpm(document_of(text, "f"))] == ["joint j4"]
    finger = text[text.index('<link name="l4"') : text.index("</robot>")]
    text = text.replace("</robot>", finger.replace("l4", "l5").replace("j4", "j5") + "</robot>")
    assert list(velocities_in_rpm(document_of(text, "f"))) == []


def test_the_joints_before_a_joint_and_a_loop():
    document = ARM.document()
    assert [x.name for x in joints_before(document, document.joint_into("l3"))] == ["j2", "j1"]
    loop = document_of(ARM.text().replace('parent link="l0"', 'parent link="l3"'), "f")
    assert [x.name for x in joints_before(loop, loop.joint_into("l3"))] == ["j2", "j1"]


def test_an_effort_that_holds_the_arm_as_it_stands_is_a_note():
    """The first axis is vertical: hung on a wall it would hold the weight, as it stands none."""
    document = ARM.document()
    moment, _ = largest_weight(document, document.joint_into("l1"), link_poses(document))
    assert largest_weight(document, document.joint_into("l1"), link_poses(document), upright=True)[0] < 1e-9
    levels = {}
    for share in (0.3, 0.05):
        text = ARM.text().replace('effort="150.0"', f'effort="{share * moment}"', 1)
        found = [f for f in lint_document(document_of(text, "f")).findings if f.code == "effort-weight"]
        levels[share] = [(f.subject, f.level) for f in found]
    assert levels == {0.3: [("joint j1", "note")], 0.05: [("joint j1", "warning")]}


def test_a_round_effort_of_three_joints_stands_for_unknown():
    def levels(*efforts):
        text = ARM.text()
        for effort in efforts:
            text = text.replace('effort="150.0"', f'effort="{effort}"', 1)
        found = lint_document(document_of(text, "f")).findings
        return {f.level for f in found if f.code == "effort-weight"}

    assert levels("900000", "900000", "900000") == {"note"}
    assert levels("900000", "900001", "900002") == {"warning"}
    assert levels("910000", "910000", "910000") == {"warning"}
