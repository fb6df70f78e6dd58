"""From a data file to an arm: conversions worked out by hand, and the source of each quantity."""

import numpy as np
import pytest

from lwr_dyn.arms.papers.assembly import STANDARD_GRAVITY, arm_from_paper, dh_rows
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.model.chain import link_frames
from lwr_dyn.model.spatial import steiner

GOOD = template("own.toml", "own", "RP", "standard")
PRODUCTS = "[[0.01, 0.002, 0], [0.002, 0.01, 0], [0, 0, 0.004]]"
ROW = "[[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.004]]"


def assembled(*changes):
    text = GOOD
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return arm_from_paper(parse_paper(text, "own.toml"))


def tensor(arm, link=0):
    return arm.chain.links[link].body.inertia_com


def test_dh_rows_are_in_si_and_frames_are_those_of_the_table():
    first, second = dh_rows(parse_paper(GOOD, "own.toml"))
    assert (first.alpha, first.d, second.alpha) == (np.pi / 2, 0.3, 0.0)
    frame = next(iter(link_frames(assembled().chain, np.zeros(2))))
    np.testing.assert_allclose(frame[:3, 3], [0.0, 0.0, 0.3], atol=1e-15)


def test_products_of_the_integral_sign_are_negated_and_moments_are_not():
    plain, negated = (
        assembled((ROW, PRODUCTS)),
        assembled((ROW, PRODUCTS), ('products = "tensor"', 'products = "integral"')),
    )
    assert (tensor(plain)[0, 1], tensor(negated)[0, 1]) == (0.002, -0.002)
    np.testing.assert_array_equal(tensor(plain).diagonal(), tensor(negated).diagonal())


def test_a_tensor_about_the_origin_is_brought_to_the_centre_of_mass():
    arm = assembled(('about = "com"', 'about = "origin"'))
    moved = tensor(assembled()) - steiner(2.0, np.array([0.0, 0.0, -0.05]))
    np.testing.assert_allclose(tensor(arm), moved, rtol=1e-14)
    cells = [source.cell for source in arm.sources["link_1.inertia"]]
    assert cells == ["inertial.inertia.values[0]", "inertial.mass.values[0]", "inertial.com.values[0]"]


def test_limits_move_by_the_printed_zero_without_rounding():
    zero = 'zero = { values = [-90, 0], unit = ["deg", "m"], where = "p. 1", kind = "assumed" }\nlower = {'
    arm = assembled(("lower = {", zero), ("[-170, 0]", "[210, 0]"), ("[170, 0.5]", "[300, 0.5]"))
    assert arm.limits[0].lower == np.radians(120.0)
    assert [s.cell for s in arm.sources["joint_1.lower"]] == ["limits.lower.values[0]", "limits.zero.values[0]"]


def test_what_the_file_leaves_out_is_unknown_and_gravity_is_the_standard_one():
    gravity = next(line for line in GOOD.splitlines() if line.startswith("gravity ="))
    effort = next(line for line in GOOD.splitlines() if line.startswith("effort ="))
    arm = assembled((gravity, ""), (effort, ""))
    assert tuple(arm.chain.gravity) == STANDARD_GRAVITY
    assert [limit.effort for limit in arm.limits] == [None, None]
    assert arm.limits[0].velocity == pytest.approx(np.radians(120.0))
    assert arm.sources["joint_1.effort"] == ()
