"""Elements of a URDF: zeros of a frame, a copied element with its numbers, limits of a joint without a range."""

import xml.etree.ElementTree as ElementTree

from lwr_dyn.arms.urdf.elements import COPIED, UNKNOWN, WEIGHTLESS, SourcedText, compact, write_limits, write_weightless
from lwr_dyn.model.arm import JointLimits


def test_a_frame_weighs_nothing():
    out = SourcedText()
    write_weightless(out, "/x/inertial")
    inertial = ElementTree.fromstring("".join(out.text))
    assert {float(v) for element in inertial for v in element.attrib.get("value", "0").split()} == {0.0}
    assert out.attributes["/x/inertial/inertia/@ixy"].word == WEIGHTLESS


def test_a_copy_is_the_element_indented_and_its_numbers_are_listed():
    xml = '<visual name="1e"><origin xyz="1 2  3" rpy="1e999 0 0"/><text> a &lt; b /&gt;</text></visual>'
    out = SourcedText()
    out.copied(2, compact(ElementTree.fromstring(xml)), "/v")
    assert compact(ElementTree.fromstring("\n".join(out.text))) == compact(ElementTree.fromstring(xml))
    assert {path: x.written for path, x in out.attributes.items()} == {"/v/origin/@xyz": (1.0, 2.0, 3.0)}
    assert out.attributes["/v/origin/@xyz"].word == COPIED


def test_a_joint_that_turns_without_end_has_no_range_and_no_stand_in():
    out = SourcedText()
    write_limits(out, "/j", "j", JointLimits(), unlimited=True)
    assert out.text == []
    write_limits(out, "/j", "j", JointLimits(effort=3.0), unlimited=True)
    assert out.text == ['    <limit effort="3.0" velocity="1000000000.0"/>']
    assert out.attributes["/j/limit/@velocity"].word == UNKNOWN
