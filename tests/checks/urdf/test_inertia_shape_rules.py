"""Each rule is silent on the arm of boxes and finds the fault that it is for."""

import pytest

from lwr_dyn.checks.urdf import inertia_shape_rules as rules
from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.judgement import judgements
from lwr_dyn.checks.urdf.undoings import log_distance
from tests.checks.urdf.box_arm import BoxArm

ARM = BoxArm()
SIX, MASS, COM = ARM.boxes[1].six, ARM.boxes[1].mass, ARM.boxes[1].com


def scaled(factor):
    return {"six": tuple(factor * v for v in SIX)}


RULES = [rules.spread, rules.bound, rules.slip, rules.density, rules.mass_fit, rules.centre, rules.centre_slip]


@pytest.mark.parametrize("rule", RULES)
def test_silent_on_a_good_arm(rule):
    assert list(rule(ARM.document())) == []


@pytest.mark.parametrize(
    ("rule", "values", "severity"),
    [
        (rules.spread, scaled(19.0), "error"),
        (rules.spread, scaled(5.0), "warning"),
        (rules.spread, scaled(0.019), "error"),
        (rules.spread, scaled(0.3), "warning"),
        (rules.bound, scaled(4.4), "warning"),
        (rules.density, {"mass": MASS / 300.0}, "error"),
        (rules.density, {"mass": MASS / 25.0}, "warning"),
        (rules.density, {"mass": MASS * 4.5}, "warning"),
        (rules.density, {"mass": MASS * 11.0}, "error"),
        (rules.density, {"mass": MASS / 7.0}, "note"),
        (rules.density, {"mass": MASS / 13.0}, "warning"),
        (rules.centre, {"com": (COM[0], COM[1], 0.5), "shapes": ARM.boxes[1].box()}, "warning"),
        (rules.centre, {"com": (COM[0], COM[1], 0.9), "shapes": ARM.boxes[1].box()}, "error"),
    ],
)
def test_a_fault_has_its_severity(rule, values, severity):
    found = list(rule(ARM.with_link(1, **values).document()))
    assert [(f.severity, f.subject, f.link) for f in found] == [(severity, "link l1", "l1")]
    assert found[0].place.line > 1


def test_a_tensor_that_no_body_has_is_not_called_narrow():
    (found,) = rules.spread(ARM.with_link(1, six=(-0.2, 0.0, 0.0, 0.01, 0.0, 0.01)).document())
    assert found.what == "its inertia is that of no body: its spread in one direction is below 0"


def test_one_fault_of_the_tensor_has_one_finding():
    for factor in (1e-4, 0.03, 4.4, 5.0, 30.0):
        document = ARM.with_link(1, **scaled(factor)).document()
        assert sum(len(list(rule(document))) for rule in (rules.spread, rules.bound, rules.slip)) == 1


def test_a_slip_of_small_size_is_a_note():
    ixx, _, _, iyy, _, izz = ARM.boxes[0].six
    wide = (0.75 * izz, 0.0, 0.0, iyy, 0.0, 1.0 * izz)
    found = list(rules.slip(ARM.with_link(0, six=wide).document()))
    assert all(f.severity in ("note", "warning") for f in found)
    assert ixx < izz


def test_a_slip_tells_how_much_nearer_it_brings_the_tensor_and_what_is_not_counted():
    document = ARM.with_link(1, rpy=(0.0, 0.0, 0.7)).document()
    (found,) = rules.slip(document)
    (judged,) = (x for x in judgements(document) if x.body.link.name == "l1")
    whole = float(log_distance(judged.ratios))  # nothing is left: the box is a full body
    assert judged.cut == pytest.approx(whole - judged.tensor_slip.prior, abs=0.02)
    assert judged.tensor_slip.prior == 0.1
    assert f"nearer to those of a full body by {whole:.2g}; 0.1 of it is not counted for this slip" in found.why


def test_a_mass_in_pounds_and_what_else_is_too_large_for_both():
    found = list(rules.mass_fit(ARM.with_link(2, mass=ARM.boxes[2].mass / 0.45359237).document()))
    assert [(f.cause, f.instead) for f in found] == [("masses in lb", f'<mass value="{ARM.boxes[2].mass:.6g}"/>')]
    found = list(rules.mass_fit(ARM.with_link(2, mass=1.6 * ARM.boxes[2].mass).document()))
    assert [f.what for f in found] == ["the mass looks 1.6 times too large"]
    hollow = ARM.with_link(2, mass=2.0 * ARM.boxes[2].mass, six=tuple(2.0 * v for v in ARM.boxes[2].six))
    assert list(rules.mass_fit(hollow.document())) == []


def test_a_centre_inside_the_body_with_the_wrong_sign():
    shape = ARM.boxes[1].changed(com=(0.0, 0.0, 0.05)).box()
    there = ARM.with_link(1, com=(0.0, 0.0, 0.05), shapes=shape)
    assert list(rules.centre_slip(there.document())) == []
    found = list(rules.centre_slip(there.with_link(1, com=(0.0, 0.0, -0.05)).document()))
    assert [(f.cause, f.instead) for f in found] == [
        ("signs of centres of mass", '<origin xyz="0 0 0.05" rpy="0 0 0"/>')
    ]


def drawn_at_a_cover(cover_mass, cover_size="0.1 0.16 0.5", com="0.02 0 0.23"):
    """The second link as a thin shaft with the mass of the whole body, which is drawn at a cover fixed to it."""
    shaft = '<visual><geometry><cylinder radius="0.015" length="0.1"/></geometry></visual>\n'
    centre = tuple(float(v) for v in com.split())
    text = ARM.with_link(1, shapes=shaft, com=centre).text()
    inertial = f'<inertial><mass value="{cover_mass}"/><inertia ixx="1e-2" iyy="1e-2" izz="1e-2"/></inertial>'
    body = f'<visual><origin xyz="0.02 0 0.23"/><geometry><box size="{cover_size}"/></geometry></visual>'
    joint = '<joint name="weld" type="fixed"><parent link="l1"/><child link="cover"/></joint>'
    cover = f'<link name="cover">{inertial if cover_mass else ""}{body}</link>{joint}'
    return document_of(text.replace("</robot>", cover + "</robot>"), "f")


def severities(document):
    return {(f.subject, f.severity) for rule in RULES for f in rule(document) if f.subject == "link l1"}


def test_a_body_that_is_drawn_at_a_link_fixed_to_it_is_no_fault():
    assert severities(drawn_at_a_cover(0)) == {("link l1", "note")}
    assert severities(drawn_at_a_cover(0.4 * MASS)) == {("link l1", "note")}


def test_a_fault_stays_one_where_the_link_fixed_to_it_does_not_explain_it():
    assert ("link l1", "error") in severities(drawn_at_a_cover(0.6 * MASS))  # it has a mass of its own
    assert ("link l1", "error") in severities(drawn_at_a_cover(0, "0.02 0.02 0.5"))  # too small
    assert ("link l1", "error") in severities(drawn_at_a_cover(0, com="0.2 0 0.23"))  # the centre is beside it
