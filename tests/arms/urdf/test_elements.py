"""Elements of a URDF: zeros of a frame, a copied element with its numbers, limits of a joint without a range."""

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import lwr_dyn
from lwr_dyn.arms.urdf import elements
from lwr_dyn.arms.urdf.elements import SIGMOID, UNKNOWN, SourcedText, compact, header, write_limits
from lwr_dyn.model.arm import JointLimits, Source
from lwr_dyn.model.chain import Rotor
from lwr_dyn.model.friction import Direction, JointFriction, Sigmoid


def test_a_copy_is_the_element_indented_with_its_numbers_and_a_frame_weighs_nothing():
    xml = '<visual name="1e" id="1_0"><origin xyz="1 2  3" rpy="1e999 0 0"/><text> a &lt; b /&gt;</text></visual>'
    out = SourcedText()
    out.copied(2, compact(ElementTree.fromstring(xml)), "/v")
    assert compact(ElementTree.fromstring("\n".join(out.text))) == compact(ElementTree.fromstring(xml))
    assert '      <origin xyz="1 2  3" rpy="1e999 0 0"/>' in "\n".join(out.text).split("\n")
    assert {path: x.written for path, x in out.attributes.items()} == {"/v/origin/@xyz": (1.0, 2.0, 3.0)}
    assert out.attributes["/v/origin/@xyz"].word == elements.COPIED
    out = SourcedText()
    elements.write_weightless(out, "/x/inertial")
    inertial = ElementTree.fromstring("".join(out.text))
    assert {float(v) for element in inertial for v in element.attrib.get("value", "0").split()} == {0.0}
    assert out.attributes["/x/inertial/inertia/@ixy"].word == elements.WEIGHTLESS


def test_the_header_says_what_the_file_cannot_hold_and_what_is_not_known():
    arm = lwr_dyn.load("lwr4plus")
    plain = "\n".join(header(arm))
    links = [replace(x, body=replace(x.body, unknown=(4,)) if k == 2 else x.body, rotor=Rotor(1.0, 0.2, k < 2))
             for k, x in enumerate(arm.chain.links)]  # fmt: skip
    changed = replace(arm, chain=replace(arm.chain, links=tuple(links)), digest="", title="a -- b")
    lines = [line.strip() for line in header(changed)]
    assert lines[0] == "<!--"
    assert lines[1].startswith("a - - b; robot lwr4plus, reading physical")
    assert "source file sha256: none" in lines
    assert f"{elements.PARTLY_KNOWN.strip()} link_3" in lines
    assert f"{elements.REFLECTED}joint_1, joint_2" in lines
    assert lines[-1] == "-->"
    assert f"source file sha256: {arm.digest}" in plain
    assert f"{elements.GRAVITY}0.0 0.0 -9.81" in plain
    assert SIGMOID not in plain
    rubbed = JointFriction(Direction(1.0, 0.0), Direction(2.0, 0.0))
    for friction in (rubbed, replace(rubbed, sigmoid=Sigmoid(1, 1, 0))):
        text = "\n".join(header(replace(arm, friction=(None,) * 6 + (friction,))))
        assert (SIGMOID in text, elements.ONE_SIDED in text) == (friction is not rubbed, friction is rubbed)


def test_estimates_are_listed_by_their_method():
    cells = {"link_1.mass": "A", "link_2.mass": "A", "link_2.com": "A", "link_3.mass": "B", "pedestal": "A"}
    sources = {name: (Source("c", how, "estimated", 1.0, "kg", ""),) for name, how in cells.items()}
    sources["link_4.mass"] = (Source("c", "A", "printed", 1.0, "kg", ""),)
    arm = replace(lwr_dyn.load("lwr4plus"), sources=sources)
    assert elements.estimates(arm) == ["mass of link_1, link_2; com of link_2 (how: A)", "mass of link_3 (how: B)"]


def test_limits_and_rotors_have_stand_ins_where_they_are_unknown_but_not_a_joint_without_end():
    out = SourcedText()
    write_limits(out, "/j", "j", JointLimits(lower=-1.0, velocity=2.0, viscous=0.5))
    assert out.text == [
        f'    <limit lower="-1.0" upper="{2 * math.pi!r}" effort="1000000000.0" velocity="2.0"/>',
        '    <dynamics damping="0.5"/>',
    ]
    words = {path.rpartition("@")[2]: (x.quantities, x.word) for path, x in out.attributes.items()}
    assert words == {"lower": (("j.lower",), ""), "upper": ((), UNKNOWN), "effort": ((), UNKNOWN),
                     "velocity": (("j.velocity",), ""), "damping": (("j.viscous",), "")}  # fmt: skip
    for reflected, word, quantities in ((True, UNKNOWN, ()), (False, "", ("j.gear_ratio",))):
        out = SourcedText()
        elements.write_rotor(out, "/a", "j", Rotor(50.0, 1e-4, reflected))
        ratio, inertia = out.attributes.values()
        assert (ratio.written, ratio.word, ratio.quantities) == ((50.0,), word, quantities)
        assert inertia.written == (1e-4,)
        lines = ['<drake:gear_ratio value="50.0"/>', '<drake:rotor_inertia value="0.0001"/>']
        assert [line.strip() for line in out.text] == lines
    out = SourcedText()
    write_limits(out, "/j", "j", JointLimits(), unlimited=True)
    assert out.text == []
    write_limits(out, "/j", "j", JointLimits(effort=3.0), unlimited=True)
    assert out.text == ['    <limit effort="3.0" velocity="1000000000.0"/>']
    assert out.attributes["/j/limit/@velocity"].word == UNKNOWN
