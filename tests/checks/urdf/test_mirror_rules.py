"""Two links of one shape, turned or mirrored: their tensors agree but for what the turn explains, or one is wrong."""

import numpy as np
import pytest

from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.lint import lint_document
from lwr_dyn.checks.urdf.mirror_rules import signs_unlike
from lwr_dyn.checks.urdf.reader_rules import refusal

COM = np.array([0.06, -0.022, 0.013])
TENSOR = np.array([[0.0025, 0.0018, -0.0012], [0.0018, 0.0062, -0.0004], [-0.0012, -0.0004, 0.0067]])
MIRROR = np.diag([1.0, -1.0, 1.0])
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def link(name, com, tensor, mass=1.5, shape=""):
    """A link with an inertial."""
    cells = " ".join(f'i{"xyz"[a]}{"xyz"[b]}="{tensor[a, b]:.9g}"' for a in range(3) for b in range(a, 3))
    place = " ".join(f"{x:.9g}" for x in com)
    return (
        f'<link name="{name}"><inertial><origin xyz="{place}"/><mass value="{mass}"/><inertia {cells}/></inertial>'
        f"{shape}</link>"
    )


def pair(left, right):
    """A trunk with a left and a right arm of one link each."""
    joints = "".join(
        f'<joint name="{name}" type="continuous"><parent link="trunk"/><child link="{name}"/></joint>'
        for name in ("left", "right")
    )
    return document_of(f'<robot name="r"><link name="trunk"/>{left}{right}{joints}</robot>', "f")


@pytest.mark.parametrize("turn", [MIRROR, QUARTER, np.eye(3), QUARTER @ MIRROR, -np.eye(3)])
def test_images_of_a_link_are_silent(turn):
    other = link("right", turn @ COM, turn @ TENSOR @ turn.T)
    assert list(signs_unlike(pair(link("left", COM, TENSOR), other))) == []


UPSIDE = np.diag([1.0, 1.0, -1.0])
OPPOSITE = 2 * np.diag(TENSOR.diagonal()) - TENSOR


@pytest.mark.parametrize("wrong", [TENSOR, MIRROR @ OPPOSITE @ MIRROR, UPSIDE @ TENSOR @ UPSIDE])
def test_signs_that_no_mirror_image_gives_are_found(wrong):
    (found,) = signs_unlike(pair(link("left", COM, TENSOR), link("right", MIRROR @ COM, wrong)))
    assert (found.subject, found.sure) == ("link right", "likely")
    right = MIRROR @ TENSOR @ MIRROR
    assert found.instead == (
        f'<inertia ixx="{right[0, 0]:g}" ixy="{right[0, 1]:g}" ixz="{right[0, 2]:g}" iyy="{right[1, 1]:g}" '
        f'iyz="{right[1, 2]:g}" izz="{right[2, 2]:g}"/>'
    )


def test_a_centre_on_an_axis_leaves_the_signs_free():
    flipped = MIRROR @ TENSOR @ MIRROR
    assert list(signs_unlike(pair(link("left", (0, 0, 0.1), TENSOR), link("right", (0, 0, 0.1), flipped)))) == []


def test_other_masses_centres_and_moments_are_other_links():
    for other in (
        link("right", MIRROR @ COM, TENSOR, mass=1.6),
        link("right", MIRROR @ COM * 1.1, TENSOR),
        link("right", MIRROR @ COM, 1.1 * TENSOR),
    ):
        assert list(signs_unlike(pair(link("left", COM, TENSOR), other))) == []


def test_where_both_have_shapes_the_finding_is_at_the_one_that_fits_worse():
    """A bar along (1, 1, 0) on the left and along (1, -1, 0) on the right; the left tensor is the right one's."""
    bar = '<visual><origin xyz="{} {} 0" rpy="0 0 {}"/><geometry><box size="0.4 0.05 0.05"/></geometry></visual>'
    turn = np.array([[1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, np.sqrt(2.0)]]) / np.sqrt(2.0)
    along = turn @ np.diag([0.0005, 0.0205, 0.0205]) @ turn.T
    com = np.array([0.1, 0.12, 0.0])
    left = link("left", com, MIRROR @ along @ MIRROR, shape=bar.format(0.1, 0.12, 0.785398))
    right = link("right", MIRROR @ com, MIRROR @ along @ MIRROR, shape=bar.format(0.1, -0.12, -0.785398))
    assert [f.subject for f in signs_unlike(pair(left, right))] == ["link left"]


def test_lint_warns_and_the_reader_reads_such_a_file():
    document = pair(link("left", COM, TENSOR), link("right", MIRROR @ COM, TENSOR))
    assert [f.level for f in lint_document(document).findings if f.code == "inertia-mirror"] == ["warning"]
    assert refusal(document).wants_a_choice
