"""Each rule of mass, centre and inertia against the shapes: silent on the arm of boxes, with both sides of its bounds.

A slip that is planted is named, and what is to be written is the link as it was.
"""

import numpy as np
import pytest

from lwr_dyn.checks.urdf import inertia_shape_rules as rules
from lwr_dyn.checks.urdf import undoings
from lwr_dyn.checks.urdf.document import document_of
from lwr_dyn.checks.urdf.hulls import solid_hull
from lwr_dyn.checks.urdf.judgement import USUAL_DENSITY, judgements, primitive_points
from tests.checks.urdf.box_arm import BoxArm, said
from tests.tolerances import EXACT

ARM = BoxArm()
RULES = [rules.spread, rules.bound, rules.slip, rules.density, rules.mass_fit, rules.centre, rules.centre_slip]
MASS, COM = ARM.boxes[1].mass, ARM.boxes[1].com


def scaled(factor):
    return {"six": tuple(factor * v for v in ARM.boxes[1].six)}


def put(z):
    """The centre of the second link at this height, its shape where it was: its top is at 0.48 m."""
    return {"com": (COM[0], COM[1], z), "shapes": ARM.boxes[1].box()}


@pytest.mark.parametrize("rule", RULES)
def test_silent_on_a_good_arm(rule):
    assert list(rule(ARM.document())) == []


@pytest.mark.parametrize(
    ("rule", "values", "level"),
    [
        (rules.spread, scaled(18.1), "error"), (rules.spread, scaled(17.9), "warning"),
        (rules.spread, scaled(4.55), "warning"), (rules.spread, scaled(4.45), ""),
        (rules.spread, scaled(0.0199), "error"), (rules.spread, scaled(0.0201), "warning"),
        (rules.spread, scaled(0.32), "warning"), (rules.spread, scaled(0.34), ""),
        (rules.bound, scaled(4.1), "warning"), (rules.bound, scaled(4.0), ""), (rules.bound, scaled(4.55), ""),
        (rules.density, {"mass": MASS / 250.0}, "error"), (rules.density, {"mass": MASS / 235.0}, "warning"),
        (rules.density, {"mass": MASS / 11.9}, "note"), (rules.density, {"mass": MASS / 12.1}, "warning"),
        (rules.density, {"mass": MASS / 6.1}, "note"), (rules.density, {"mass": MASS / 5.9}, ""),
        (rules.density, {"mass": MASS * 4.2}, "warning"), (rules.density, {"mass": MASS * 4.1}, ""),
        (rules.density, {"mass": MASS * 9.9}, "warning"), (rules.density, {"mass": MASS * 10.1}, "error"),
        (rules.centre, put(0.491), "warning"), (rules.centre, put(0.641), "error"),
        (rules.centre, put(0.638), "warning"),
        (rules.centre, put(0.52), "warning"), (rules.centre, put(0.477), ""),
    ],
)  # fmt: skip
def test_a_fault_has_its_severity(rule, values, level):
    found = list(rule(ARM.with_link(1, **values).document()))
    assert [(f.severity, f.subject, f.link) for f in found] == [(level, "link l1", "l1")] * bool(level)
    assert all(f.place.line > 1 for f in found)


def test_what_is_said():
    """Of a spread below 0, of a density, of a centre, of a mass in lb and of one that is too large for both."""
    negative = ARM.with_link(1, six=(-0.2, 0.0, 0.0, 0.01, 0.0, 0.01))
    assert said(rules.spread(negative.document()), "warning link l1: its inertia is that of no body: its")
    wide = rules.spread(ARM.with_link(1, **scaled(9.0)).document())
    assert said(wide, "warning link l1: the tensor looks 10 times too large; … about 3 times as wide … S are 9, 9, 9;")
    light = "warning link l1: the mass looks … is 58 kg/m^3: mass 0.4638 kg, hull 0.008 m^3; the file's usual is 1200"
    assert said(rules.density(ARM.with_link(1, mass=MASS / 20.7).document()), light)
    out = "warning link l1: the centre of … lies outside the hull of its shapes: 0.075 diameters outside, 2 standard"
    assert said(rules.centre(ARM.with_link(1, **put(0.52)).document()), out)
    mass = ARM.boxes[2].mass
    found = list(rules.mass_fit(ARM.with_link(2, mass=mass / 0.45359237).document()))
    assert [(f.cause, f.instead) for f in found] == [("masses in lb", f'<mass value="{mass:.6g}"/>')]
    assert said(
        rules.mass_fit(ARM.with_link(2, mass=1.6 * mass).document()), "note link l2: the mass looks 1.6 times too"
    )
    hollow = ARM.with_link(2, mass=2.0 * mass, six=tuple(2.0 * v for v in ARM.boxes[2].six))
    assert (
        list(rules.mass_fit(hollow.document()))
        == list(rules.mass_fit(ARM.with_link(2, mass=1.5 * mass).document()))
        == []
    )


@pytest.mark.parametrize("factor", [1e-4, 0.03, 4.4, 5.0, 30.0])
def test_one_fault_of_the_tensor_has_one_finding(factor):
    document = ARM.with_link(1, **scaled(factor)).document()
    assert sum(len(list(rule(document))) for rule in (rules.spread, rules.bound, rules.slip)) == 1


def test_a_slip_tells_how_much_nearer_it_brings_the_tensor_and_what_is_not_counted():
    document = ARM.with_link(1, rpy=(0.0, 0.0, 0.7)).document()
    (found,) = rules.slip(document)
    (judged,) = (x for x in judgements(document) if x.body.link.name == "l1")
    whole = float(undoings.log_distance(judged.ratios))  # nothing is left: the box is a full body
    assert judged.cut == pytest.approx(whole - 0.1, abs=0.02)
    assert judged.tensor_slip.prior == 0.1
    assert f"nearer to those of a full body by {whole:.2g}; 0.1 of it is not counted for this slip" in found.why


def drawn_at_a_cover(cover_mass, cover_size="0.1 0.16 0.5", com="0.02 0 0.23"):
    """The second link as a thin shaft with the mass of the whole body, which is drawn at a cover fixed to it."""
    shaft = '<visual><geometry><cylinder radius="0.015" length="0.1"/></geometry></visual>\n'
    text = ARM.with_link(1, shapes=shaft, com=tuple(float(v) for v in com.split())).text()
    inertial = f'<inertial><mass value="{cover_mass}"/><inertia ixx="1e-2" iyy="1e-2" izz="1e-2"/></inertial>'
    body = f'<visual><origin xyz="0.02 0 0.23"/><geometry><box size="{cover_size}"/></geometry></visual>'
    joint = '<joint name="weld" type="fixed"><parent link="l1"/><child link="cover"/></joint>'
    cover = f'<link name="cover">{inertial if cover_mass else ""}{body}</link>{joint}'
    return document_of(text.replace("</robot>", cover + "</robot>"), "f")


@pytest.mark.parametrize(
    ("cover", "level"),
    [((0,), "note"), ((0.49 * MASS,), "note"),
     ((0.51 * MASS,), "error"),  # it has a mass of its own
     ((0, "0.02 0.02 0.5"), "error"),  # too small
     ((0, "0.1 0.16 0.5", "0.2 0 0.23"), "error")],  # the centre is beside it
)  # fmt: skip
def test_a_body_that_is_drawn_at_a_link_fixed_to_it_is_no_fault(cover, level):
    document = drawn_at_a_cover(*cover)
    levels = {f.severity for rule in RULES for f in rule(document) if f.subject == "link l1"}
    assert levels == {"note"} if level == "note" else level in levels


LINK = ARM.boxes[2]
XX, XY, XZ, YY, YZ, ZZ = LINK.six
C = np.array(LINK.com)


def findings(arm):
    document = arm.document()
    return [f for rule in (rules.spread, rules.bound, rules.slip, rules.density, rules.centre) for f in rule(document)]


def rotated(angle):
    """The tensor of the box about axes turned by `angle` about z."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return tuple((turn.T @ np.diag([XX, YY, ZZ]) @ turn)[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]])


ABOUT_JOINT = np.diag([XX, YY, ZZ]) + LINK.mass * (C @ C * np.eye(3) - np.outer(C, C))
SLIPS = {
    "two moments exchanged": {"six": (YY, XY, XZ, XX, YZ, ZZ)},
    "tensors written in another order": {"six": (XX, YY, ZZ, XY, XZ, YZ)},
    "inertia about the link frame instead of the centre of mass": {
        "six": tuple(ABOUT_JOINT[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]])
    },
    **{f"tensors {off}": {"six": tuple(factor * v for v in LINK.six)} for off, factor in (
        ("100 times too large", 100.0), ("1000 times too small", 1e-3), ("1000000 times too large", 1e6))},
    "rpy in degrees": {"six": rotated(np.deg2rad(50.0)), "rpy": (0.0, 0.0, 50.0)},
    "centres of mass in mm": {"com": tuple(1000.0 * C)},
    "signs of centres of mass": {"com": (-C[0], C[1], C[2])},
    "centres of mass in the parent frame": {"com": tuple(C + ARM.origins[1])},
    "axes of centres of mass": {"com": (C[2], C[0], C[1])},
    **{f"masses {off}": {"mass": factor * LINK.mass} for off, factor in (
        ("in g", 1000.0), ("in t", 0.001), ("10 times too small", 0.1))},
    **{f"shapes {off}": {"shapes": LINK.changed(size=tuple(f * v for v in LINK.size), com=tuple(f * C)).box()}
       for off, f in (("in mm", 1000.0), ("1000 times too small", 0.001))},
}  # fmt: skip


@pytest.mark.parametrize("cause", SLIPS)
def test_a_slip_is_named_and_undone(cause):
    arm = ARM.with_link(2, **{"shapes": LINK.box(), **SLIPS[cause]})
    found = findings(arm)
    assert ({f.cause for f in found}, {f.subject for f in found}) == ({cause}, {"link l2"})
    assert len(found) == 1 or cause.startswith("masses")
    instead = found[-1].instead
    if cause.startswith("shapes"):
        assert instead == "shapes in metres"
        return
    tag = instead[: instead.index(" ") + 1]
    text = arm.text()
    start = text.index(tag, text.index('name="l2"'))
    mended = document_of(text[:start] + instead + text[text.index("/>", start) + 2 :], "f")
    (judged,) = (x for x in judgements(mended) if x.body.link.name == "l2")
    assert judged.ratios == pytest.approx([1.0] * 3, rel=1e-4)
    assert (judged.off, judged.density) == (pytest.approx(0.0, abs=1e-9), pytest.approx(1200.0, rel=1e-5))


def test_a_tensor_turned_as_its_rpy_says_and_a_centre_inside_with_the_wrong_sign():
    assert findings(ARM.with_link(2, six=rotated(0.9), rpy=(0.0, 0.0, 0.9))) == []
    there = ARM.with_link(1, com=(0.0, 0.0, 0.05), shapes=ARM.boxes[1].changed(com=(0.0, 0.0, 0.05)).box())
    assert list(rules.centre_slip(there.document())) == []
    wrong = rules.centre_slip(there.with_link(1, com=(0.0, 0.0, -0.05)).document())
    assert said(wrong, 'warning link l1: z of the … 0.69 standard deviations off the … write <origin xyz="0 0 0.05"')


def test_centres_in_the_base_frame_are_judged_over_the_file():
    base, arm = np.zeros(3), ARM
    for k, origin in enumerate(ARM.origins, start=1):
        base = base + origin
        arm = arm.with_link(k, com=tuple(base + ARM.boxes[k].com), shapes=ARM.boxes[k].box())
    assert {f.cause for f in findings(arm)} == {"centres of mass in the base frame"}


def test_full_boxes_have_ratios_of_one_and_their_density():
    """Links without mass or shape are passed over, and a fixed joint to a link that is not there adds no body."""
    joint = '<joint name="weld" type="fixed"><parent link="l3"/><child link="missing"/></joint></robot>'
    found = judgements(document_of(ARM.text().replace("</robot>", joint), "x.urdf"))
    for x in found:
        assert (*x.ratios, x.density, x.usual) == pytest.approx((1.0, 1.0, 1.0, 1200.0, 1200.0), rel=1e-9)
        assert (x.off, x.spread, x.tensor_slip, x.centre_slip) == (pytest.approx(0.0, abs=1e-9),) * 2 + (None, None)
    assert [x.body.link.name for x in found] == ["l0", "l1", "l2", "l3"]
    bare = ARM.with_link(1, mass=0.0).with_link(2, shapes="<visual/>")
    assert [x.body.link.name for x in judgements(bare.document())] == ["l0", "l3"]


@pytest.mark.parametrize(
    ("masses", "usual"),
    [((1000.0,) * 4, USUAL_DENSITY), ((4.1,) * 4, 4920.0), ((4.2,) * 4, USUAL_DENSITY), ((0.09,) * 4, 108.0),
     ((0.08,) * 4, USUAL_DENSITY), ((0.001, 0.001, 0.001, 1.0), 1200.0)],
)  # fmt: skip
def test_the_usual_density_is_the_median_without_light_links_or_that_of_an_arm(masses, usual):
    arm = ARM
    for k, factor in enumerate(masses):
        arm = arm.with_link(k, mass=factor * ARM.boxes[k].mass)
    assert [x.usual for x in judgements(arm.document())] == pytest.approx([usual] * 4, rel=EXACT)


SIZE, BODY_MASS = np.array([0.2, 0.3, 0.5]), 3.0
HULL = solid_hull(primitive_points("box", tuple(SIZE)))
FULL = BODY_MASS / 12.0 * np.diag((SIZE**2).sum() - SIZE**2)


def test_ratios_bounds_and_centres_of_a_box():
    """A full body has ratios of 1, in proportion to tensor over mass; half the mass at either end reaches the bound."""
    tensors = np.array([FULL, 10.0 * FULL])
    assert undoings.spread_ratios(tensors, 2.0 * BODY_MASS, HULL) == pytest.approx(
        np.array([[0.5] * 3, [5.0] * 3]), rel=1e-10
    )
    assert undoings.log_distance(np.array([[1.0, 1.0, 1.0], [np.e, 1.0, np.exp(-1.0)]])) == pytest.approx(
        [0.0, 2.0**0.5]
    )
    ends = BODY_MASS * (SIZE[2] / 2.0) ** 2
    tries = ((np.zeros(3), np.diag([ends, ends, 1e-9])), (np.zeros(3), FULL), (np.array([0.0, 0.0, 9.0]), FULL))
    bounds = [undoings.bound_ratio(undoings.MassPoint(BODY_MASS, *x), HULL) for x in tries]
    assert bounds[:2] == pytest.approx([1.0, 1.0 / 3.0], rel=1e-6)
    assert bounds[2] < 1.0
    assert undoings.outside(np.array([0.6, 0.0, 0.0]), HULL) == pytest.approx(0.5 / HULL.diameter, rel=EXACT)
    assert undoings.off_centre(np.array([0.0, 0.0, 0.5]), HULL) == pytest.approx(12.0**0.5, rel=1e-9)
    moments = ([1.0, 1.0, 1.0], [1.0, 1.0, 2.0], [1.0, 1.1, 2.15], [1.0, -1.0, 1.0], [-5e-4, 1.0, 1.0])
    assert undoings.possible(np.array([np.diag(x) for x in moments])).tolist() == [True, True, False, False, False]


def test_every_undoing_takes_back_one_slip():
    """Each is no other, and the numbers of the tensor or the centre stand in them in another order, sign or power."""
    arm = ARM.with_link(2, six=(1.0, 0.02, 0.03, 1.4, 0.05, 1.7), com=(0.4, 0.05, 0.06), rpy=(0.1, 0.2, 0.3))
    inertial, pose = arm.document().link("l2").inertial, np.eye(4)
    pose[:3] = [[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0]]
    tensors, centres = undoings.tensor_undoings(inertial, pose), undoings.centre_undoings(inertial, pose, np.eye(4))
    counts = {cause: sum(u.cause == cause for u in tensors) for cause in dict.fromkeys(u.cause for u in tensors)}
    assert counts.pop("tensors 10 times too small") == 1
    powers = [counts.pop(x) for x in list(counts) if x.startswith("tensors 1")]
    assert (powers, list(counts.values())) == ([1] * 11, [3, 2, 5, 1, 3, 5, 1, 1, 6, 1, 1])
    assert len({u.instead for u in tensors}) == len(tensors)
    rows = [u.tensor[np.triu_indices(3)].tolist() for u in tensors if u.cause == "tensors written in another order"]
    xx, xy, xz, yy, yz, zz = inertial.tensor[np.triu_indices(3)].tolist()
    assert rows == [
        [xx, yy, yz, xy, zz, xz], [xx, yy, zz, xy, yz, xz], [xx, zz, yz, xy, yy, xz], [xx, yy, zz, xy, xz, yz],
        [xx, yy, xz, xy, zz, yz],
    ]  # fmt: skip
    assert [tuple(np.round(u.com, 6)) for u in centres] == [
        (-1.95, 0.6, -2.94), (0.004, 0.0005, 0.0006), (0.04, 0.005, 0.006),
        (-0.4, 0.05, 0.06), (0.4, -0.05, 0.06), (0.4, 0.05, -0.06),
        (0.4, 0.06, 0.05), (0.05, 0.4, 0.06), (0.05, 0.06, 0.4), (0.06, 0.4, 0.05), (0.06, 0.05, 0.4),
    ]  # fmt: skip
