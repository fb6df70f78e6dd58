"""Evidence files: each number with half its last digit, in SI units; what is wrong is named with its place."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.checks.conventions.evidence import (
    DerivedNumber,
    Evidence,
    EvidenceError,
    FlangePlace,
    evidence_number,
    parse_evidence,
)
from lwr_dyn.checks.conventions.printed_table import printed_table
from lwr_dyn.foundation.errors import LwrDynError, ShapeError, UnknownNameError

PLACE = """[[place]]
q = [0, 90, 0, 0, 0, 0, 0]
unit = "mm"
xyz = ["310.5", "0", "200.25"]
where = "p. 3"
"""
TENSORS = """[tensors]
about = "origin"
unit = "kg m^2"
where = ""
products = {products}
values = [{rows}]
"""


@pytest.fixture(scope="module")
def read():
    table = printed_table(open_paper("lwr4plus"))
    return lambda text: parse_evidence(text, "e.toml", table)


def test_a_place_and_tensors_are_read_in_si_with_the_coarsest_digit(read):
    (place,) = read(PLACE).places
    assert (*place.xyz, place.half, *place.q) == pytest.approx((0.3105, 0.0, 0.20025, 0.5e-3, 0, np.pi / 2, *[0] * 5))
    rows = ", ".join(["['0.25', '0.5', '0.5', '-', '-', '-']"] * 7)
    tensors = read(TENSORS.format(products="'tensor'", rows=rows)).tensors
    assert (tensors.about, tensors.products) == ("origin", ("tensor",))
    assert tensors.half[6, :2] == pytest.approx([0.005, 0.05])
    assert np.isnan(tensors.values[:, 3:]).all()
    assert read(TENSORS.format(products="'unknown'", rows=rows)).tensors.products == ("tensor", "integral")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (', "200.25"]', "]", "2 entries"), ('"200.25"]', '"200.25", "1"]', "4 entries"),
        ('where = "p. 3"', 'where = "p. 3"\ncolour = 1', "colour"), ("[0, 90, 0, 0, 0, 0, 0]", "[0, 90]", "7 numbers"),
        ('"310.5"', "310.5", "without its digits"),
    ],
)  # fmt: skip
def test_a_wrong_place_is_refused(read, old, new, says):
    with pytest.raises(LwrDynError, match=rf"place\[0\].*{says}"):
        read(PLACE.replace(old, new))


ROW = "['1.0', '1.0', '1.0', '-', '-', '-']"
NUMBER = '[[number]]\nquantity = "{}"\njoint = "joint_1"\nvalue = {}\nunit = "{}"\nq = [{}]\nwhere = ""\n'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (TENSORS.format(products="'tensor'", rows=", ".join([ROW] * 6)),
         "evidence: tensors.values: 6 rows; allowed: 7 rows of xx yy zz xy xz yz, one per link"),
        (TENSORS.format(products="'tensor'", rows=ROW + ", ['1.0', '1.0']"),
         "evidence: tensors.values[1]: 2 entries; allowed: 6: xx yy zz xy xz yz"),
        (TENSORS.format(products="'tensor'", rows="1.0"),
         "evidence: tensors.values: not a list of rows; allowed: one row of xx yy zz xy xz yz per link"),
        (NUMBER.format("gravity", '"2.9 Nm"', "N m", "0, 0, 0, 0, 0, 0, 0"),
         "evidence: number[0].value: '2.9 Nm', no digits; allowed: a number as printed, such as \"2.908\""),
        (NUMBER.format("inertia", "2.9", "kg m^2", "0, 0, 0, 0, 0, 0, 0"),
         "evidence: number[0].value: 2.9, a number without its digits; allowed: text as printed, such as \"2.908\""),
        *((f"[arm]\nalike = {given}\n",
           f"evidence: e.toml: arm.alike: {said}; allowed: lists of two or more different links") for given, said in (
            ("[['link_1', 'link_1']]", "['link_1', 'link_1']"), ("['link_1']", "'link_1'"),
            ("[['link_1', 'link_2', 'link_1']]", "['link_1', 'link_2', 'link_1']"))),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_place(read, text, says):
    with pytest.raises(EvidenceError) as refusal:
        read(text)
    assert str(refusal.value) == says


def test_evidence_made_in_code_is_checked_against_the_table():
    table = printed_table(open_paper("lwr4plus"))
    posed = DerivedNumber("inertia", 0, evidence_number("2.9"))
    with pytest.raises(EvidenceError, match="evidence: b11: no pose; allowed: q, or a largest B_ii"):
        Evidence((posed,)).check(table)
    places = (FlangePlace(np.zeros(6), np.zeros(3), 0.1),)
    for given, error, says in (
        (Evidence((replace(posed, joint=7),)), UnknownNameError, "no joint of lwr4plus named '8'; known: joint_1"),
        (Evidence(alike=((0, 7),)), UnknownNameError, "no joint of lwr4plus named '8'"),
        (Evidence((replace(posed, q=np.zeros(6)),)), ShapeError, "6"), (Evidence(places=places), ShapeError, "6"),
    ):  # fmt: skip
        with pytest.raises(error, match=says):
            given.check(table)


def test_numbers_of_outer_joints_come_first(read):
    number = '[[number]]\nquantity = "worst inertia"\njoint = "{}"\nvalue = "2.9"\nunit = "kg m^2"\nwhere = ""\n'
    evidence = read("".join(map(number.format, ("joint_2", "joint_7", "joint_1"))))
    assert [(x.joint, x.name) for x in evidence.outermost_first] == [(6, "b77"), (1, "b22"), (0, "b11")]
