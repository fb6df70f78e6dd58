"""Links and joints of a URDF as written: defaults, what cannot be read, and poses."""

import numpy as np
import pytest

from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.elements import JointElement, LinkElement


def link(inside: str) -> LinkElement:
    return document_of(f'<robot name="r"><link name="a">{inside}</link></robot>', "r.urdf").links[0]


def joint(inside: str, type_: str = "revolute") -> JointElement:
    text = f'<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="{type_}">{inside}</joint></robot>'
    return document_of(text, "r.urdf").joints[0]


INERTIA = '<inertia ixx="1" ixy="4" ixz="5" iyy="2" iyz="6" izz="3"/>'


def test_an_inertial_is_turned_into_the_axes_of_its_link():
    text = f'<inertial><origin xyz="1 2 3" rpy="0 0 {np.pi / 2!r}"/><mass value="2"/>{INERTIA}</inertial>'
    inertial = link(text).inertial
    np.testing.assert_array_equal(inertial.tensor, [[1, 4, 5], [4, 2, 6], [5, 6, 3]])
    np.testing.assert_allclose(inertial.inertia, [[2, -4, -6], [-4, 1, 5], [-6, 5, 3]], atol=1e-12)
    pose = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    np.testing.assert_allclose(inertial.origin.pose, pose, atol=1e-12)
    assert (*inertial.com, inertial.mass, inertial.is_complete, inertial.is_zero) == (1.0, 2.0, 3.0, 2.0, True, False)


@pytest.mark.parametrize(
    ("inside", "complete", "zero"),
    [
        ('<mass value="2"/><inertia ixx="1" iyy="1" izz="1"/>', True, False),  # products not written are 0
        ('<mass value="0"/><inertia ixx="0" iyy="0" izz="0"/>', True, True),
        ('<mass value="1"/><inertia ixx="0" iyy="0" izz="0"/>', True, False),
        (f'<mass value="0"/>{INERTIA}', True, False),
        ('<mass value="2"/><inertia ixx="1" iyy="1"/>', False, False), ('<mass value="0"/>', False, False),
        (INERTIA, False, False), (f'<mass value="two"/>{INERTIA}', False, False),
        (f'<origin xyz="0 0"/><mass value="2"/>{INERTIA}', False, False),
        (f'<origin rpy="0 0 x"/><mass value="2"/>{INERTIA}', False, False),
    ],
)  # fmt: skip
def test_what_an_inertial_lacks(inside, complete, zero):
    inertial = link(f"<inertial>{inside}</inertial>").inertial
    assert (inertial.is_complete, inertial.is_zero) == (complete, zero)


@pytest.mark.parametrize(
    ("solid", "kind", "size"),
    [
        ('<box size="1 2 3"/>', "box", (1.0, 2.0, 3.0)), ('<box size="1 2"/>', "box", None), ("<box/>", "box", None),
        ('<cylinder length="2" radius="1"/>', "cylinder", (1.0, 2.0)), ('<cylinder radius="1"/>', "cylinder", None),
        ('<capsule length="2" radius="1"/>', "capsule", (1.0, 2.0)), ('<sphere radius="1"/>', "sphere", (1.0,)),
        ("<plane/>", "", None), ('<mesh filename="a.stl"/>', "mesh", ()),
        ('<mesh filename="a.stl" scale="1 2 3"/>', "mesh", ()),
    ],
)  # fmt: skip
def test_shapes(solid, kind, size):
    for role in ("visual", "collision"):
        (shape,) = link(f'<{role}><origin xyz="1 0 0"/><geometry>{solid}</geometry></{role}>').shapes
        mesh, scale = ("a.stl", [1.0, 2.0 ** ("2" in solid), 3.0 ** ("3" in solid)]) if kind == "mesh" else ("", None)
        assert (shape.role, shape.kind, shape.size, shape.mesh) == (role, kind, size, mesh)
        assert shape.scale.tolist() == scale if mesh else True
        np.testing.assert_array_equal(shape.origin.pose[:3, 3], [1, 0, 0])


def test_a_joint_as_written_and_its_defaults():
    full = joint(
        '<origin xyz="1 2 3"/><parent link="a"/><child link="b"/><axis xyz="0 0 2"/>'
        '<limit lower="-1" upper="2" effort="3" velocity="4"/><mimic joint="k"/>'
    )
    assert (full.subject, full.parent, full.child, full.mimic, full.moves) == ("joint j", "a", "b", "k", True)
    assert (full.lower, full.upper, full.effort, full.velocity, *full.axis) == (-1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 2.0)
    assert (full.place_of("axis"), full.place_of("dynamics")) == (full.element.child("axis").place, full.place)
    bare = joint("", "fixed")
    assert (bare.parent, bare.child, bare.mimic, bare.limit, bare.lower, bare.moves) == ("", "", *[None] * 3, False)
    assert (*bare.axis, *bare.origin.xyz, *bare.origin.rpy, bare.origin.element) == (1, *[0] * 8, None)
