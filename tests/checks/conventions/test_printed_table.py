"""Options as bodies: tables printed under a reading are read back; feasibility is that of `model.chain`."""

import numpy as np
import pytest

from lwr_dyn.checks.conventions.hypotheses import (
    alike_links,
    frame_vectors,
    mirror_misses,
    other_ends,
    shifted,
    shortfalls,
    with_rows_moved,
)
from lwr_dyn.checks.conventions.printed_table import LinkChoice, LinkOptions, link_options
from lwr_dyn.model.chain import Body, Convention, JointKind, is_physical
from lwr_dyn.model.spatial import Pose, from_rpy
from tests.checks.conventions.identifiable import open_choices
from tests.checks.conventions.scrambled_tables import same_bodies, scrambled_table


@pytest.mark.parametrize("seed", range(30))
def test_a_table_read_as_it_was_printed_gives_its_bodies(seed):
    one = scrambled_table(np.random.default_rng([11, seed]))
    table = with_rows_moved(one.table, one.truth.shift)
    ends = other_ends(table, one.truth.table.convention)
    bodies = [link_options(table, i, one.truth.table, ends[i], (c,)).body(0) for i, c in enumerate(one.truth.links)]
    assert same_bodies(table, tuple(bodies), one.bodies)


def test_other_readings_give_other_bodies():
    one = scrambled_table(np.random.default_rng([11, 1]))
    table = with_rows_moved(one.table, one.truth.shift)
    ends = other_ends(table, one.truth.table.convention)
    for wrong in (LinkChoice("integral"), LinkChoice("tensor", "zxy")):
        links = [wrong if c != wrong else LinkChoice("tensor", "yxz") for c in one.truth.links]
        bodies = [link_options(table, i, one.truth.table, ends[i], (c,)).body(0) for i, c in enumerate(links)]
        assert not same_bodies(table, tuple(bodies), one.bodies)


def options_of(bodies, deviation=0.0):
    tensors = np.array([b.inertia_com for b in bodies])
    com = np.array([b.com for b in bodies])
    return LinkOptions(
        choices=((LinkChoice(),),) * len(bodies), mass=bodies[0].mass, com=com, inertia_com=tensors,
        parameters=np.zeros((len(bodies), 10)), deviation=np.zeros(10), deviation_com=deviation,
        scale=float(np.abs(tensors).max()),
    )  # fmt: skip


def test_feasibility_is_that_of_physical():
    rng = np.random.default_rng(2)
    bodies = []
    for _ in range(300):
        turn = from_rpy(rng.uniform(-3, 3, 3))
        bodies.append(Body(1.0, np.zeros(3), turn @ np.diag(rng.uniform(-0.2, 1.0, 3)) @ turn.T))
    found = (shortfalls(options_of(bodies), np.full(300, np.inf)) <= 1e-12).all(axis=-1)
    expected = [is_physical(Body(b.mass, b.com, (b.inertia_com + b.inertia_com.T) / 2)) for b in bodies]
    assert list(found) == expected
    assert 30 < sum(expected) < 270


def test_too_large_a_radius_of_gyration_is_no_body():
    body = Body(2.0, np.zeros(3), np.diag([0.02, 0.02, 0.02]))  # 0.1 m
    short = shortfalls(options_of([body, body]), np.array([0.09, 0.11]))
    assert short[0, 2] > 0.0 >= short[1, 2]


def test_fuller_bodies_have_larger_fullness():
    flat, full = Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 1.99])), Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 1.2]))
    gone = Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.5]))
    a, b, c = options_of([flat, full, gone]).log_inertia_volume
    assert c == -np.inf
    assert a < b


def test_mirror_images_agree_and_a_flipped_product_does_not():
    tensor = np.array([[0.04, 0.001, 0.002], [0.001, 0.03, 0.004], [0.002, 0.004, 0.02]])
    body = Body(2.0, np.array([0.01, 0.07, -0.03]), tensor)
    turn = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    image = body.seen_from(Pose(turn, np.zeros(3)))
    flipped = Body(2.0, image.com, np.where(np.eye(3, dtype=bool), 1.0, -1.0) * image.inertia_com)
    misses = mirror_misses(options_of([body]), options_of([image, flipped]), [0], [0, 1])
    assert misses[0, 0] < 1e-12
    assert misses[0, 1] > 0.01


def test_repeated_links_are_found_by_mass_and_com():
    for seed in range(40):
        one = scrambled_table(np.random.default_rng([12, seed]))
        if len(one.alike) > 1:
            groups = alike_links(one.table, np.array([b.com for b in one.bodies]))
            assert set(one.alike) in [set(g) for g in groups]


def test_two_products_flipped_are_no_mirror_image_about_this_com():
    """Turning x about would give this tensor, and takes the com elsewhere."""
    tensor = np.array([[0.04, 0.001, 0.002], [0.001, 0.03, 0.004], [0.002, 0.004, 0.02]])
    turn = np.diag([-1.0, 1.0, 1.0])
    body, half = (
        Body(2.0, np.array([0.05, 0.07, -0.03]), tensor),
        Body(2.0, np.array([0.05, 0.07, -0.03]), turn @ tensor @ turn),
    )
    assert mirror_misses(options_of([body]), options_of([half]), [0], [0])[0, 0] > 0.01


@pytest.mark.parametrize("seed", range(6))
def test_the_other_end_of_a_link_follows_from_the_frames(seed):
    """Standard: frame i-1 seen from frame i; modified: frame i+1 seen from frame i; both at any q."""
    one = scrambled_table(np.random.default_rng([15, seed]))
    for convention in Convention:
        links = one.table.chain(convention).links
        ends, vectors = other_ends(one.table, convention), frame_vectors(one.table, convention)
        for i, link in enumerate(links):
            if link.kind is JointKind.PRISMATIC:
                continue
            pose = link.pose(0.7)
            if convention is Convention.STANDARD:
                np.testing.assert_allclose(ends[i], pose.inverse().position, atol=1e-12)
                np.testing.assert_allclose(vectors[i], pose.rotation.T @ pose.position, atol=1e-12)
            else:
                np.testing.assert_allclose(vectors[i], pose.position, atol=1e-12)
                if i > 0:
                    np.testing.assert_allclose(ends[i - 1], pose.position, atol=1e-12)
        if convention is Convention.MODIFIED:
            np.testing.assert_array_equal(ends[-1], one.table.flange.position)


def test_rows_that_fall_out_fill_the_blank_cell():
    one = next(t for k in range(200) if (t := scrambled_table(np.random.default_rng([13, k]))).truth.shift)
    moved = with_rows_moved(one.table, 1)
    assert np.isnan(one.table.com[-1]).all()
    assert np.array_equal(moved.com[-1], one.table.origin[-1])
    assert np.isnan(shifted(one.table.origin, 1)[0]).all()


@pytest.mark.slow
def test_what_no_number_shows_is_open():
    trials = [scrambled_table(np.random.default_rng([14, k])) for k in range(40)]
    open_ = {kind: [bool(open_choices(t)) for t in trials if t.kind == kind] for kind in ("numbers", "both")}
    assert any(open_["numbers"])
    assert sum(open_["both"]) < sum(open_["numbers"])
