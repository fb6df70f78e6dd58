"""Rules of the shapes: what a fault of one is said to be, and what goes through."""

import numpy as np
import pytest

from lwr_dyn.checks.urdf import shape_rules as rules
from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.hulls import solid_hull
from lwr_dyn.checks.urdf.judgement import bodies_of, primitive_points
from tests.checks.urdf.box_arm import ORIGINS, BoxArm, said

ARM = BoxArm()
BELOW, BEHIND = (0.0, 0.0, -0.45), (-0.45, 0.0, 0.0)
LOST = '<collision><geometry><mesh filename="lost.stl"/></geometry></collision>'
APART = "error joint j2: z of its origin has the opposite sign: its bodies l1 and l2 lie 0.68 diameters apart"
PERMUTED = "joint j: x, y, z of its origin look permuted: its origin lies far from its parent"


def placed(k, origin, arm=ARM):
    """The arm with the origin of joint k elsewhere."""
    return BoxArm(boxes=arm.boxes, origins=(*arm.origins[: k - 1], origin, *arm.origins[k:]))


def both(share):
    """The second link with collision shapes of another size."""
    box = ARM.boxes[1]
    return ARM.with_link(1, shapes=box.box() + box.changed(size=tuple(share * v for v in box.size)).box("collision"))


def ahead(gap):
    """The last joint before the end of its parent, and its link ahead of it."""
    return placed(
        3, (0.47 + gap, 0.0, 0.0), ARM.with_link(3, shapes=ARM.boxes[3].changed(com=(0.04 + gap, 0, 0)).box())
    )


def partial(k):
    arm = placed(2, BELOW)
    return arm.with_link(k, shapes=arm.boxes[k].box() + LOST)


def wrist(axis):
    """Two equal elbow pieces, the second turned by a quarter about x, whose joint's origin lies beside the first."""
    piece = '<visual><origin xyz="0 {} -0.05"/><geometry><box size="0.072 0.095 0.16"/></geometry></visual></link>'
    joint = '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
    origin = '<origin xyz="0 -0.12 0" rpy="1.5708 0 0"/>'
    limit = f'<axis xyz="{axis}"/><limit lower="-1" upper="1" effort="9" velocity="2"/></joint>'
    bodies = f'<link name="a">{piece.format(0.01)}<link name="b">{piece.format(-0.01)}'
    return document_of(f'<robot name="r">{bodies}{joint}{origin}{limit}</robot>', "f")


def beside(axis):
    """Boxes beside each other along y, which turn freely about y; the second joint turns about this axis."""
    boxes = [ARM.boxes[0].changed(size=(0.1, 0.1, 0.5), com=(0.0, 0.0, 0.2)) for _ in range(4)]
    text = BoxArm(boxes=tuple(boxes), origins=((0.0, 0.1, 0.0),) * 3).text().replace('"0 0 1"', '"0 1 0"')
    head, tail = text.replace("-2", "-3").replace('"2"', '"3"').split('name="j2"')
    return document_of(f'{head}name="j2"{tail.replace("0 1 0", axis, 1)}', "f")


THIN = ARM.with_link(0, shapes=ARM.boxes[0].changed(size=(0.02, 0.02, 0.1)).box())
CASES = {
    rule: [(ARM.document(), [])]
    for rule in (rules.mesh_unreadable, rules.shapes_differ, rules.bodies_apart, rules.joint_off_bodies,
                 rules.origins_doubted, rules.axes_doubted)
}  # fmt: skip
CASES[rules.shapes_differ] += [
    (both(0.495).document(), ["error link l1: its visual shapes have 8.24 times … 0.534 m and 0.264 m, 2.02 times"]),
    (both(2.02).document(), ["error link l1: its visual shapes have 0.121 times … 0.534 m and 1.08 m, 0.495 times"]),
    (both(0.505).document(), []), (both(1.98).document(), []),
]  # fmt: skip
CASES[rules.bodies_apart] += [
    (placed(2, BELOW).document(), [APART + '; at q = 0 … 0.86 diameters of l1 … <origin xyz="0 0 0.45" rpy="0 0 0"/>']),
    *((partial(k).document(), [APART.replace("error", "note")]) for k in (1, 2)),  # what a body lacks may fill the gap
    (placed(3, BEHIND).document(), ['error joint j3: x of its origin … 0.73 diameters … xyz="0.45 0 0" rpy="0 0 0"/>']),
    (placed(3, (450.0, 0.0, 0.0)).document(), ["error joint j3: its bodies l2 and l3 lie 8.6e+02 diameters apart"]),
    (ahead(0.016).document(), []), (ahead(0.018).document(), ["error joint j3: its bodies l2 and l3 lie 0.069"]),
]  # fmt: skip
CASES[rules.joint_off_bodies] += [
    (placed(2, BELOW).document(), []), (ahead(0.033).document(), []),
    (ahead(0.035).document(), ["error joint j3: its origin lies 0.067 diameters outside both l2 and l3; a joint's"]),
    (document_of(ahead(0.035).text().replace("revolute", "prismatic"), "f"), []),
]  # fmt: skip
CASES[rules.origins_doubted] += [
    (placed(1, (0.0, 0.0, -0.1), THIN).document(), ['error joint j1: z of its origin … write <origin xyz="0 0 0.1"']),
    # tables of DH parameters put it at the far end of the child: the axis goes through the parent, or past it
    (wrist("0 0 1"), [f'note {PERMUTED} … 0.46 diameters of a … <origin xyz="0 0 -0.12" rpy="1.5708 0 0"/>']),
    (wrist("1 0 0"), [f"error {PERMUTED}"]),
]
CASES[rules.axes_doubted] += [
    (beside("0 1 0"), []),
    (beside("1 0 0"), ['error joint j2: the axis turns l2 into l1: about y … 0.34 of … write <axis xyz="0 1 0"/>']),
]


@pytest.mark.parametrize("rule", CASES)
def test_a_rule_finds_its_fault_and_is_silent_on_a_good_arm(rule):
    assert all(said(rule(document), *expected) for document, expected in CASES[rule])


def test_a_mesh_that_cannot_be_read_and_one_of_another_format(tmp_path):
    (tmp_path / "bad.stl").write_bytes(b"solid x\nnothing")
    (tmp_path / "a.glb").write_bytes(b"glTF")
    shapes = "".join(
        f'<visual><geometry><mesh filename="{name}"/></geometry></visual>' for name in ("bad.stl", "a.glb")
    )
    document = ARM.with_link(1, shapes=shapes).document(str(tmp_path / "arm.urdf"))
    bad = "error link l1: the mesh bad.stl cannot be read; without points; export it again"
    assert said(rules.mesh_unreadable(document), bad, "note link l1: the mesh a.glb cannot be read; format .glb is not")


def test_remarks_on_links_without_shapes():
    bare = ARM
    for k in range(4):
        bare = bare.with_link(k, shapes="<visual/>")
    assert [list(rules.remarks(x.document())) for x in (ARM, ARM.with_link(2, shapes="<visual/>"), bare)] == [
        [], ["no shapes with a volume: l2; there a third of the faults cannot be seen"],
        ["no shapes: a third of the faults cannot be seen (mass, centre and inertia against the body)"],
    ]  # fmt: skip


def neighbours(arm, name):
    document = arm.document()
    joint, bodies = document.joint_into(name), bodies_of(document)
    return joint, bodies[joint.parent].hull, bodies[name].hull, joint.origin.pose


def test_a_good_origin_and_axis_are_not_doubted():
    slips = [rules.origin_slip(*neighbours(ARM, name)[1:]) for name in ("l1", "l2", "l3")]
    slips.append(rules.axis_slip(*neighbours(ARM, "l1")))
    assert all(slip is None or slip.cut < 0.1 for slip in slips)


@pytest.mark.parametrize(
    ("k", "origin", "says", "right"),
    [(3, BEHIND, "x of its origin has the opposite sign", ORIGINS[2]),
     (2, (0.45, 0.0, 0.0), "x, y, z of its origin look permuted", ORIGINS[1])],
)  # fmt: skip
def test_the_sign_and_the_order_of_an_origin_are_named_and_put_right(k, origin, says, right):
    """The cut is by how many of the parent's diameters the joint comes nearer to it."""
    _, parent, child, pose = neighbours(placed(k, origin), f"l{k}")
    found = rules.origin_slip(parent, child, pose)
    assert (found.says, found.values.tolist()) == (says, list(right))
    half = np.array(ARM.boxes[k - 1].size) / 2.0
    far = [(np.abs(np.array(x) - ARM.boxes[k - 1].com) - half).max() for x in (origin, right)]
    assert found.cut == pytest.approx((far[0] - far[1]) / parent.diameter, rel=1e-9)


def test_an_axis_that_turns_the_child_into_its_parent():
    text = ARM.text().replace('<axis xyz="0 0 1"/>', '<axis xyz="1 0 0"/>')
    joint = document_of(text, "f").joint_into("l1")
    found = rules.axis_slip(joint, *neighbours(ARM, "l1")[1:])
    assert np.argmax(found.values) in (1, 2)
    assert found.cut > 0.1


def test_points_that_fill_a_hull_are_in_it_and_faces_about_it_touch_it():
    hull = solid_hull(np.vstack([np.zeros(3), np.eye(3)]))
    points, (normals, offsets) = rules._filled(hull), rules._faces(hull)
    assert len(points) == 16
    assert (points @ hull.planes[:, :3].T + hull.planes[:, 3]).max() <= 1e-12
    assert np.ptp(hull.vertices @ normals.T - offsets, axis=0).min() > 0.0
    assert (hull.vertices @ normals.T - offsets).max(axis=0) == pytest.approx(0.0, abs=1e-15)
    many = solid_hull(primitive_points("sphere", (1.0,)))
    assert 240 <= len(rules._filled(many)) <= 320


def test_half_a_body_is_none():
    """Of shapes beside a mesh that is not there."""
    whole = both(1.0)
    half = whole.with_link(1, shapes=whole.boxes[1].shapes + LOST)
    assert [bodies_of(x.document())["l1"].collision is None for x in (whole, half)] == [False, True]
    assert bodies_of(half.document())["l1"].visual is not None
