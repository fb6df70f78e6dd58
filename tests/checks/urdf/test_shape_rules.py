import numpy as np
import pytest

from lwr_dyn.checks.urdf import shape_rules as rules
from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.hulls import solid_hull
from lwr_dyn.checks.urdf.judgement import bodies_of
from lwr_dyn.checks.urdf.shape_rules import axis_slip, origin_slip
from tests.checks.urdf.box_arm import ORIGINS, BoxArm

ARM = BoxArm()
RULES = (
    rules.mesh_unreadable, rules.shapes_differ, rules.bodies_apart, rules.joint_off_bodies, rules.origins_doubted,
    rules.axes_doubted,
)  # fmt: skip


def test_points_that_fill_a_hull_are_in_it():
    hull = solid_hull(np.vstack([np.zeros(3), np.eye(3)]))
    points = rules._filled(hull)
    assert len(points) == 16
    assert (points @ hull.planes[:, :3].T + hull.planes[:, 3]).max() <= 1e-12


@pytest.mark.parametrize("rule", RULES)
def test_silent_on_a_good_arm(rule):
    assert list(rule(ARM.document())) == []


def test_a_mesh_that_cannot_be_read(tmp_path):
    (tmp_path / "bad.stl").write_bytes(b"solid x\nnothing")
    mesh = '<visual><geometry><mesh filename="bad.stl"/></geometry></visual>'
    document = ARM.with_link(1, shapes=mesh).document(str(tmp_path / "arm.urdf"))
    found = list(rules.mesh_unreadable(document))
    assert [(f.subject, f.why) for f in found] == [("link l1", "without points")]


def test_visual_and_collision_in_different_units():
    box = ARM.boxes[1]
    small = box.changed(size=tuple(0.001 * v for v in box.size)).box("collision")
    found = list(rules.shapes_differ(ARM.with_link(1, shapes=box.box() + small).document()))
    assert [f.subject for f in found] == ["link l1"]
    half = box.changed(size=tuple(0.6 * v for v in box.size)).box("collision")
    assert list(rules.shapes_differ(ARM.with_link(1, shapes=box.box() + half).document())) == []


def test_bodies_apart_and_a_joint_off_both():
    origins = (*ORIGINS[:1], tuple(np.array(ORIGINS[1]) * -1.0), ORIGINS[2])
    document = BoxArm(origins=origins).document()
    assert [f.subject for f in rules.bodies_apart(document)] == ["joint j2"]
    assert [f.subject for f in rules.joint_off_bodies(document)] == []
    thousand = BoxArm(origins=(*ORIGINS[:2], tuple(1000.0 * v for v in ORIGINS[2]))).document()
    assert [f.subject for f in rules.bodies_apart(thousand)] == ["joint j3"]


def test_what_a_body_lacks_may_fill_the_gap():
    origins = (*ORIGINS[:1], tuple(np.array(ORIGINS[1]) * -1.0), ORIGINS[2])
    arm = BoxArm(origins=origins)
    assert [f.severity for f in rules.bodies_apart(arm.document())] == [None]
    lost = '<collision><geometry><mesh filename="lost.stl"/></geometry></collision>'
    for k in (1, 2):
        partial = arm.with_link(k, shapes=arm.boxes[k].box() + lost).document()
        assert [f.severity for f in rules.bodies_apart(partial)] == ["note"]


def test_remarks_on_links_without_shapes():
    bare = ARM
    for k in range(4):
        bare = bare.with_link(k, shapes="<visual/>")
    assert list(rules.remarks(ARM.document())) == []
    assert "l2" in next(iter(rules.remarks(ARM.with_link(2, shapes="<visual/>").document())))
    assert next(iter(rules.remarks(bare.document()))).startswith("no shapes: a third")


def test_a_sign_is_named_where_the_bodies_still_meet_and_where_they_do_not():
    near, far = (0.0, 0.0, -0.1), (-0.45, 0.0, 0.0)
    found = [*rules.bodies_apart(BoxArm(origins=(*ORIGINS[:2], far)).document())]
    assert [(f.subject, f.instead) for f in found] == [("joint j3", '<origin xyz="0.45 0 0" rpy="0 0 0"/>')]
    tall = ARM.with_link(0, shapes=ARM.boxes[0].changed(size=(0.02, 0.02, 0.1)).box())
    below = BoxArm(boxes=tall.boxes, origins=(near, *ORIGINS[1:]))
    found = [*rules.origins_doubted(below.document())]
    assert [(f.subject, f.instead) for f in found] == [("joint j1", '<origin xyz="0 0 0.1" rpy="0 0 0"/>')]


def wrist(axis: str):
    """Two equal elbow pieces, the second turned by a quarter about x, whose joint's origin lies beside the first."""
    piece = '<visual><origin xyz="0 {} -0.05"/><geometry><box size="0.072 0.095 0.16"/></geometry></visual></link>'
    joint = '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
    origin = '<origin xyz="0 -0.12 0" rpy="1.5708 0 0"/>'
    limit = f'<axis xyz="{axis}"/><limit lower="-1" upper="1" effort="9" velocity="2"/></joint>'
    bodies = f'<link name="a">{piece.format(0.01)}<link name="b">{piece.format(-0.01)}'
    return document_of(f'<robot name="r">{bodies}{joint}{origin}{limit}</robot>', "f")


def test_an_origin_anywhere_on_an_axis_through_its_parent_is_a_note():
    """Tables of DH parameters put it at the far end of the child: another order of its numbers lies nearer."""
    (found,) = rules.origins_doubted(wrist("0 0 1"))
    assert (found.severity, found.instead) == ("note", '<origin xyz="0 0 -0.12" rpy="1.5708 0 0"/>')
    (found,) = rules.origins_doubted(wrist("1 0 0"))  # its axis goes past the parent
    assert found.severity is None


def test_an_axis_is_named():
    """Boxes beside each other along y turn freely about y; one that is to turn about x goes through its neighbour."""
    boxes = [ARM.boxes[0].changed(size=(0.1, 0.1, 0.5), com=(0.0, 0.0, 0.2)) for _ in range(4)]
    beside = BoxArm(boxes=tuple(boxes), origins=((0.0, 0.1, 0.0),) * 3)
    text = beside.text().replace('"0 0 1"', '"0 1 0"').replace("-2", "-3").replace('"2"', '"3"')
    assert list(rules.axes_doubted(document_of(text, "f"))) == []
    start = text.index("<axis", text.index('"j2"'))
    wrong = text[:start] + '<axis xyz="1 0 0"/>' + text[text.index("/>", start) + 2 :]
    found = list(rules.axes_doubted(document_of(wrong, "f")))
    assert [(f.subject, f.instead) for f in found] == [("joint j2", '<axis xyz="0 1 0"/>')]


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
    document = document_of(wrong, "f")
    joint, bodies = document.joint_into("l1"), bodies_of(document)
    found = axis_slip(joint, bodies["l0"].hull, bodies["l1"].hull, joint.origin.pose)
    assert np.argmax(found.values) in (1, 2)
    assert found.cut > 0.1
