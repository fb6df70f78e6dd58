"""A slip that is planted is named, and what is to be written is the link as it was."""

import numpy as np
import pytest

from lwr_dyn.checks.urdf import inertia_shape_rules as rules
from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.hulls import solid_hull
from lwr_dyn.checks.urdf.judgement import primitive_points
from lwr_dyn.checks.urdf.undoings import (
    MassPoint,
    bound_ratio,
    log_distance,
    off_centre,
    outside,
    possible,
    spread_ratios,
    tensor_undoings,
)
from tests.checks.urdf.box_arm import BoxArm
from tests.tolerances import EXACT

LINK = 2
ARM = BoxArm()
XX, XY, XZ, YY, YZ, ZZ = ARM.boxes[LINK].six
COM, MASS = np.array(ARM.boxes[LINK].com), ARM.boxes[LINK].mass


def findings(arm):
    document = arm.document()
    return [f for rule in (rules.spread, rules.bound, rules.slip, rules.density, rules.centre) for f in rule(document)]


def about_joint():
    full = np.diag([XX, YY, ZZ]) + MASS * (COM @ COM * np.eye(3) - np.outer(COM, COM))
    return tuple(full[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]])


SLIPS = {
    "two moments exchanged": ((YY, XY, XZ, XX, YZ, ZZ), "ixx and iyy look exchanged"),
    "tensors written in another order": ((XX, YY, ZZ, XY, XZ, YZ), "another order"),
    "inertia about the link frame instead of the centre of mass": (about_joint(), "about the link frame"),
    "tensors 100 times too large": (tuple(100.0 * v for v in ARM.boxes[LINK].six), "100 times too large"),
    "tensors 1000 times too small": (tuple(1e-3 * v for v in ARM.boxes[LINK].six), "1000 times too small"),
}


def test_the_arm_itself_has_no_finding():
    assert findings(ARM) == []


@pytest.mark.parametrize("cause", SLIPS)
def test_a_slip_of_the_tensor_is_named_and_undone(cause):
    six, says = SLIPS[cause]
    found = findings(ARM.with_link(LINK, six=six))
    assert [f.cause for f in found] == [cause]
    assert found[0].subject == "link l2"
    assert says in found[0].what
    text = ARM.with_link(LINK, six=six).text()
    start = text.index("<inertia ", text.index('name="l2"'))
    mended = text[:start] + found[0].instead + text[text.index("/>", start) + 2 :]
    assert list(rules.spread(document_of(mended, "f"))) == []


@pytest.mark.parametrize("angle", [50.0, 90.0])
def test_rpy_in_degrees(angle):
    """The tensor of the box as it is about axes turned by `angle` about z, and that angle written in degrees."""
    turn = np.deg2rad(angle)
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    six = (rotation.T @ np.diag([XX, YY, ZZ]) @ rotation)[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    assert findings(ARM.with_link(LINK, six=tuple(six), rpy=(0.0, 0.0, turn))) == []
    found = findings(ARM.with_link(LINK, six=tuple(six), rpy=(0.0, 0.0, angle)))
    assert [f.cause for f in found] == ["rpy in degrees"]
    assert found[0].instead.endswith(f'rpy="0 0 {turn:.6g}"/>')


def test_a_quarter_turn():
    found = findings(ARM.with_link(LINK, rpy=(0.0, 0.0, np.pi / 2)))
    assert len(found) == 1
    assert possible(np.array([ARM.document().link("l2").inertial.inertia])).all()


CENTRES = {
    "centres of mass in mm": tuple(1000.0 * COM),
    "signs of centres of mass": (-COM[0], COM[1], COM[2]),
    "centres of mass in the parent frame": tuple(COM + ARM.origins[LINK - 1]),
    "axes of centres of mass": (COM[2], COM[0], COM[1]),
}


@pytest.mark.parametrize("cause", CENTRES)
def test_a_slip_of_the_centre_is_named_and_undone(cause):
    found = findings(ARM.with_link(LINK, com=CENTRES[cause], shapes=ARM.boxes[LINK].box()))
    assert [f.cause for f in found] == [cause]
    assert found[0].instead.startswith('<origin xyz="0.22 0.01 0"')


def test_centres_in_the_base_frame_are_judged_over_the_file():
    base, arm = np.zeros(3), ARM
    for k, origin in enumerate(ARM.origins, start=1):
        base = base + origin
        box = ARM.boxes[k]
        arm = arm.with_link(k, com=tuple(base + box.com), shapes=box.box())
    assert {f.cause for f in findings(arm)} == {"centres of mass in the base frame"}


@pytest.mark.parametrize(
    ("factor", "cause"), [(1000.0, "masses in g"), (0.001, "masses in t"), (0.1, "masses 10 times too small")]
)
def test_units_of_the_mass(factor, cause):
    found = findings(ARM.with_link(LINK, mass=MASS * factor))
    assert {f.cause for f in found} == {cause}
    assert found[-1].instead.startswith(f'<mass value="{MASS:.6g}"')


@pytest.mark.parametrize(("factor", "cause"), [(1000.0, "shapes in mm"), (0.001, "shapes 1000 times too small")])
def test_units_of_the_shapes(factor, cause):
    box = ARM.boxes[LINK]
    wide = box.changed(size=tuple(factor * v for v in box.size), com=tuple(factor * v for v in box.com)).box()
    assert [f.cause for f in findings(ARM.with_link(LINK, shapes=wide))] == [cause]


def test_possible_inertias():
    tried = np.array([np.diag(d) for d in ([1.0, 1.0, 1.0], [1.0, 1.0, 2.1], [1.0, -1.0, 1.0], [1.0, 1.0, 2.0])])
    assert possible(tried).tolist() == [True, False, False, True]


def test_each_undoing_of_the_order_takes_back_one_order():
    inertial = ARM.document().link("l2").inertial
    orders = [u for u in tensor_undoings(inertial) if u.cause == "tensors written in another order"]
    assert len(orders) == 5


SIZE = np.array([0.2, 0.3, 0.5])
HULL = solid_hull(primitive_points("box", tuple(SIZE)))
MASS = 3.0
FULL = MASS / 12.0 * np.diag((SIZE**2).sum() - SIZE**2)


def test_a_full_body_has_ratios_of_one():
    assert spread_ratios(FULL, MASS, HULL) == pytest.approx(np.ones(3), rel=1e-10)
    assert log_distance(spread_ratios(FULL, MASS, HULL)) == pytest.approx(0.0, abs=1e-9)


def test_ratios_scale_with_the_tensor_and_against_the_mass_in_batches():
    ratios = spread_ratios(np.array([FULL, 10.0 * FULL]), 2.0 * MASS, HULL)
    assert ratios == pytest.approx(np.array([[0.5] * 3, [5.0] * 3]), rel=1e-10)


def test_half_the_mass_at_either_end_reaches_the_bound():
    ends = MASS * (SIZE[2] / 2.0) ** 2
    point = MassPoint(MASS, np.zeros(3), np.diag([ends, ends, 1e-9]))
    assert bound_ratio(point, HULL) == pytest.approx(1.0, rel=1e-6)
    assert bound_ratio(MassPoint(MASS, np.zeros(3), FULL), HULL) == pytest.approx(1.0 / 3.0, rel=1e-9)
    assert bound_ratio(MassPoint(MASS, np.array([0.0, 0.0, 9.0]), FULL), HULL) < 1.0


def test_centres():
    assert outside(np.array([0.6, 0.0, 0.0]), HULL) == pytest.approx(0.5 / HULL.diameter, rel=EXACT)
    assert outside(np.zeros(3), HULL) < 0.0
    assert off_centre(np.array([0.0, 0.0, 0.5]), HULL) == pytest.approx(12.0**0.5, rel=1e-9)
