import numpy as np
import pytest

from lwr_dyn.checks.urdf.judgement import bodies_of
from lwr_dyn.checks.urdf.shape_rules import axis_slip, origin_slip
from tests.checks.urdf.box_arm import BoxArm

ARM = BoxArm()


def neighbours(arm, name):
    document = arm.document()
    joint, bodies = document.joint_into(name), bodies_of(document)
    return joint, bodies[joint.parent].hull, bodies[name].hull, joint.origin.pose


@pytest.mark.parametrize("name", ["l1", "l2", "l3"])
def test_a_good_origin_is_not_doubted(name):
    found = origin_slip(*neighbours(ARM, name)[1:])
    assert found is None or found.cut < 0.2


def test_a_good_axis_is_not_doubted():
    found = axis_slip(*neighbours(ARM, "l1"))
    assert found is None or found.cut < 0.1


def test_the_sign_of_an_origin_is_named_and_put_right():
    origins = list(ARM.origins)
    origins[2] = (-0.45, 0.0, 0.0)
    _, *bodies = neighbours(BoxArm(origins=tuple(origins)), "l3")
    found = origin_slip(*bodies)
    assert found.says == "x of its origin has the opposite sign"
    assert found.values == pytest.approx([0.45, 0.0, 0.0])
    assert found.cut > 0.5


def test_the_order_of_an_origin_is_named_and_put_right():
    origins = list(ARM.origins)
    origins[1] = (0.45, 0.0, 0.0)
    _, *bodies = neighbours(BoxArm(origins=tuple(origins)), "l2")
    found = origin_slip(*bodies)
    assert found.says == "x, y, z of its origin look permuted"
    assert found.values == pytest.approx([0.0, 0.0, 0.45])


def test_an_axis_that_turns_the_child_into_its_parent():
    text = ARM.text()
    wrong = text.replace('<axis xyz="0 0 1"/>', '<axis xyz="1 0 0"/>')
    assert wrong != text
    from lwr_dyn.checks.urdf.document import document_of

    document = document_of(wrong, "f")
    joint, bodies = document.joint_into("l1"), bodies_of(document)
    found = axis_slip(joint, bodies["l0"].hull, bodies["l1"].hull, joint.origin.pose)
    assert np.argmax(found.values) in (1, 2)
    assert found.cut > 0.1
