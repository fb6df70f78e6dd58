"""Evidence files: each number with half its last digit, in SI units; what is wrong is named with its place."""

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.checks.conventions.evidence import EvidenceError, parse_evidence
from lwr_dyn.checks.conventions.printed_table import printed_table
from lwr_dyn.foundation.errors import LwrDynError

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


def test_a_place_is_read_in_metres_with_the_coarsest_digit(read):
    (place,) = read(PLACE).places
    assert place.xyz == pytest.approx([0.3105, 0.0, 0.20025])
    assert place.half == pytest.approx(0.5e-3)  # of "0" mm; 0.05 mm and 0.005 mm of the others
    assert place.q == pytest.approx([0, np.pi / 2, 0, 0, 0, 0, 0])


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (', "200.25"]', "]", "2 entries"),
        ('"200.25"]', '"200.25", "1"]', "4 entries"),
        ('where = "p. 3"', 'where = "p. 3"\ncolour = 1', "colour"),
        ("[0, 90, 0, 0, 0, 0, 0]", "[0, 90]", "7 numbers"),
        ('"310.5"', "310.5", "without its digits"),
    ],
)
def test_a_wrong_place_is_refused(read, old, new, says):
    with pytest.raises(LwrDynError, match=says) as refusal:
        read(PLACE.replace(old, new))
    assert "place[0]" in str(refusal.value)


def test_tensors_have_their_point_and_the_signs_that_are_possible(read):
    rows = ", ".join(["['0.25', '0.5', '0.5', '-', '-', '-']"] * 7)
    tensors = read(TENSORS.format(products="'tensor'", rows=rows)).tensors
    assert (tensors.about, tensors.products) == ("origin", ("tensor",))
    assert tensors.half[6, :2] == pytest.approx([0.005, 0.05])
    assert np.isnan(tensors.values[:, 3:]).all()
    with pytest.raises(EvidenceError, match="6 rows"):
        read(TENSORS.format(products="'tensor'", rows=rows.removesuffix(", ['0.25', '0.5', '0.5', '-', '-', '-']")))


def test_numbers_of_outer_joints_come_first(read):
    number = '[[number]]\nquantity = "worst inertia"\njoint = "{}"\nvalue = "2.9"\nunit = "kg m^2"\nwhere = ""\n'
    evidence = read("".join(map(number.format, ("joint_2", "joint_7", "joint_1"))))
    assert [x.joint for x in evidence.outermost_first] == [6, 1, 0]
    assert [x.name for x in evidence.outermost_first] == ["b77", "b22", "b11"]
