import numpy as np
import pytest

from lwr_dyn.checks.urdf.document import document_of, link_poses
from lwr_dyn.checks.urdf.inertia_shape_rules import largest_weight
from lwr_dyn.checks.urdf.drive_rules import effort_against_weight, unlike_others
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
