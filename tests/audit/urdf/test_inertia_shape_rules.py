"""Each rule is silent on the arm of boxes and finds the fault that it is for."""

import pytest

from lwr_dyn.audit.urdf import inertia_shape_rules as rules
from tests.audit.urdf.box_arm import BoxArm

ARM = BoxArm()
SIX, MASS, COM = ARM.boxes[1].six, ARM.boxes[1].mass, ARM.boxes[1].com


def scaled(factor):
    return {"six": tuple(factor * v for v in SIX)}


@pytest.mark.parametrize("rule", [rules.spread, rules.bound, rules.slip, rules.density, rules.centre])
def test_silent_on_a_good_arm(rule):
    assert list(rule(ARM.document())) == []


@pytest.mark.parametrize(
    ("rule", "values", "severity"),
    [
        (rules.spread, scaled(19.0), "error"),
        (rules.spread, scaled(5.0), "warning"),
        (rules.spread, scaled(0.019), "error"),
        (rules.spread, scaled(0.3), "warning"),
        (rules.bound, scaled(4.0), "warning"),
        (rules.density, {"mass": MASS / 300.0}, "error"),
        (rules.density, {"mass": MASS / 25.0}, "warning"),
        (rules.density, {"mass": MASS * 3.5}, "warning"),
        (rules.density, {"mass": MASS * 11.0}, "error"),
        (rules.density, {"mass": MASS / 7.0}, "warning"),
        (rules.centre, {"com": (COM[0], COM[1], 0.5), "shapes": ARM.boxes[1].box()}, "warning"),
        (rules.centre, {"com": (COM[0], COM[1], 0.9), "shapes": ARM.boxes[1].box()}, "error"),
    ],
)
def test_a_fault_has_its_severity(rule, values, severity):
    found = list(rule(ARM.with_link(1, **values).document()))
    assert [(f.severity, f.subject, f.link) for f in found] == [(severity, "link l1", "l1")]
    assert found[0].place.line > 1


def test_one_fault_of_the_tensor_has_one_finding():
    for factor in (1e-4, 0.03, 4.0, 5.0, 30.0):
        document = ARM.with_link(1, **scaled(factor)).document()
        assert sum(len(list(rule(document))) for rule in (rules.spread, rules.bound, rules.slip)) == 1


def test_a_slip_of_small_size_is_a_note():
    ixx, _, _, iyy, _, izz = ARM.boxes[3].six
    found = list(rules.slip(ARM.with_link(3, six=(izz, 0.0, 0.0, iyy, 0.0, ixx)).document()))
    assert len(found) <= 1
