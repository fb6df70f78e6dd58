import pytest

from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.judgement import USUAL_DENSITY, judgements
from tests.checks.urdf.box_arm import BoxArm
from tests.tolerances import EXACT

ARM = BoxArm()


def test_full_boxes_have_ratios_of_one_and_their_density():
    for found in judgements(ARM.document()):
        assert found.ratios == pytest.approx([1.0, 1.0, 1.0], rel=1e-9)
        assert found.density == pytest.approx(1200.0, rel=EXACT)
        assert found.usual == pytest.approx(1200.0, rel=EXACT)
        assert found.off == pytest.approx(0.0, abs=1e-9)
        assert (found.tensor_slip, found.centre_slip) == (None, None)


def test_links_without_mass_or_shape_are_passed_over():
    arm = ARM.with_link(1, mass=0.0).with_link(2, shapes="<visual/>")
    assert [x.body.link.name for x in judgements(arm.document())] == ["l0", "l3"]


def test_the_usual_density_is_that_of_an_arm_where_the_file_has_none():
    arm = ARM
    for k, box in enumerate(ARM.boxes):
        arm = arm.with_link(k, mass=1000.0 * box.mass)
    assert {x.usual for x in judgements(arm.document())} == {USUAL_DENSITY}


def test_light_links_do_not_count_for_the_median():
    arm = ARM
    for k in (0, 1, 2):
        arm = arm.with_link(k, mass=0.04)
    assert judgements(arm.document())[0].usual == pytest.approx(1200.0, rel=EXACT)


def test_a_fixed_joint_to_a_link_that_is_not_there_adds_no_body():
    joint = '<joint name="weld" type="fixed"><parent link="l3"/><child link="missing"/></joint></robot>'
    text = ARM.text().replace("</robot>", joint)
    assert len(judgements(document_of(text, "x.urdf"))) == len(ARM.boxes)
