"""Two links of one shape, turned or mirrored: their tensors agree but for what the turn explains, or one is wrong."""

import numpy as np
import pytest

from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.lint import lint_document
from lwr_dyn.checks.urdf.mirror_rules import signs_unlike
from lwr_dyn.checks.urdf.reader_rules import refusal
from tests.checks.urdf.box_arm import said

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


UPSIDE = np.diag([1.0, 1.0, -1.0])
OPPOSITE = 2 * np.diag(TENSOR.diagonal()) - TENSOR
RIGHT = MIRROR @ TENSOR @ MIRROR
LEFT, IMAGE = link("left", COM, TENSOR), MIRROR @ COM


@pytest.mark.parametrize(
    "left_and_right",
    [
        *((LEFT, link("right", turn @ COM, turn @ TENSOR @ turn.T))
          for turn in (MIRROR, QUARTER, np.eye(3), QUARTER @ MIRROR, -np.eye(3))),
        (link("left", (0, 0, 0.1), TENSOR), link("right", (0, 0, 0.1), RIGHT)),  # on an axis: the signs are free
        (LEFT, link("right", IMAGE, TENSOR, mass=1.502)), (LEFT, link("right", IMAGE * 1.003, TENSOR)),
        (LEFT, link("right", IMAGE, TENSOR * 1.021)),  # another link
        (link("left", COM, np.diag(TENSOR.diagonal())), link("right", IMAGE, TENSOR)),
    ],
)  # fmt: skip
def test_images_of_a_link_and_other_links_are_silent(left_and_right):
    assert list(signs_unlike(pair(*left_and_right))) == []


@pytest.mark.parametrize("wrong", [TENSOR, MIRROR @ OPPOSITE @ MIRROR, UPSIDE @ TENSOR @ UPSIDE, 1.019 * TENSOR])
def test_signs_that_no_mirror_image_gives_are_found(wrong):
    """To the bounds: 0.1 % of the mass, 0.2 % of the centre, 2 % of the largest moment."""
    document = pair(LEFT, link("right", IMAGE * 1.0015, wrong, mass=1.501))
    cells = " ".join(f'i{"xyz"[a]}{"xyz"[b]}="{RIGHT[a, b]:g}"' for a in range(3) for b in range(a, 3))
    says = f"error link right: the signs of its products of inertia do … those of link left … write <inertia {cells}/>"
    assert said(signs_unlike(document), says)
    assert [f.level for f in lint_document(document).findings if f.code == "inertia-mirror"] == ["warning"]
    assert refusal(document).wants_a_choice  # the reader reads it


def test_where_both_have_shapes_the_finding_is_at_the_one_that_fits_worse():
    """A bar along (1, 1, 0) on the left and along (1, -1, 0) on the right; the left tensor is the right one's."""
    bar = '<visual><origin xyz="{} {} 0" rpy="0 0 {}"/><geometry><box size="0.4 0.05 0.05"/></geometry></visual>'
    turn = np.array([[1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, np.sqrt(2.0)]]) / np.sqrt(2.0)
    along = turn @ np.diag([0.0005, 0.0205, 0.0205]) @ turn.T
    com = np.array([0.1, 0.12, 0.0])
    left = link("left", com, MIRROR @ along @ MIRROR, shape=bar.format(0.1, 0.12, 0.785398))
    right = link("right", MIRROR @ com, MIRROR @ along @ MIRROR, shape=bar.format(0.1, -0.12, -0.785398))
    assert [f.subject for f in signs_unlike(pair(left, right))] == ["link left"]
