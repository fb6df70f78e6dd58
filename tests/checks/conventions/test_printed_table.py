"""Options as bodies: tables printed under a reading are read back; feasibility is that of `model.chain`."""

import numpy as np
import pytest

from lwr_dyn.checks.conventions import hypotheses
from lwr_dyn.checks.conventions.printed_table import LinkChoice, LinkOptions, link_options
from lwr_dyn.model.chain import Body, Convention, JointKind, is_physical
from lwr_dyn.model.spatial import Pose, from_rpy
from tests.checks.conventions.recovery import open_choices
from tests.checks.conventions.scrambled_tables import same_bodies, scrambled_table


def read_as(one, links):
    """A scrambled table and its bodies, each link read so."""
    table = hypotheses.with_rows_moved(one.table, one.truth.shift)
    ends = hypotheses.other_ends(table, one.truth.table.convention)
    return table, tuple(link_options(table, i, one.truth.table, ends[i], (c,)).body(0) for i, c in enumerate(links))


@pytest.mark.parametrize("seed", range(30))
def test_a_table_read_as_it_was_printed_gives_its_bodies(seed):
    one = scrambled_table(np.random.default_rng([11, seed]))
    assert same_bodies(*read_as(one, one.truth.links), one.bodies)


@pytest.mark.parametrize("wrong", [LinkChoice("integral"), LinkChoice("tensor", "zxy")])
def test_other_readings_give_other_bodies(wrong):
    one = scrambled_table(np.random.default_rng([11, 1]))
    links = [wrong if c != wrong else LinkChoice("tensor", "yxz") for c in one.truth.links]
    assert not same_bodies(*read_as(one, links), one.bodies)


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
    found = (hypotheses.shortfalls(options_of(bodies), np.full(300, np.inf)) <= 1e-12).all(axis=-1)
    expected = [is_physical(Body(b.mass, b.com, (b.inertia_com + b.inertia_com.T) / 2)) for b in bodies]
    assert list(found) == expected
    assert 30 < sum(expected) < 270


def test_a_radius_of_gyration_and_the_fullness_of_bodies():
    """0.1 m is too large where 0.09 m are allowed; a flat body is less full, and one beyond the triangle is none."""
    body = Body(2.0, np.zeros(3), np.diag([0.02, 0.02, 0.02]))
    short = hypotheses.shortfalls(options_of([body, body]), np.array([0.09, 0.11]))
    assert short[0, 2] > 0.0 >= short[1, 2]
    moments = [np.diag([1.0, 1.0, largest]) for largest in (1.99, 1.2, 2.5)]
    flat, full, gone = options_of([Body(1.0, np.zeros(3), x) for x in moments]).log_inertia_volume
    assert (flat < full, gone) == (True, -np.inf)


TENSOR = np.array([[0.04, 0.001, 0.002], [0.001, 0.03, 0.004], [0.002, 0.004, 0.02]])


def test_mirror_images_agree_and_flipped_products_do_not():
    """One product of the image; two of the body itself: turning x would give these, and takes the com elsewhere."""
    body = Body(2.0, np.array([0.01, 0.07, -0.03]), TENSOR)
    image = body.seen_from(Pose(np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]), np.zeros(3)))
    flipped = Body(2.0, image.com, np.where(np.eye(3, dtype=bool), 1.0, -1.0) * image.inertia_com)
    misses = hypotheses.mirror_misses(options_of([body]), options_of([image, flipped]), [0], [0, 1])
    assert misses[0, 0] < 1e-12 < 0.01 < misses[0, 1]
    turn, off = np.diag([-1.0, 1.0, 1.0]), np.array([0.05, 0.07, -0.03])
    body, half = Body(2.0, off, TENSOR), Body(2.0, off, turn @ TENSOR @ turn)
    assert hypotheses.mirror_misses(options_of([body]), options_of([half]), [0], [0])[0, 0] > 0.01


def test_repeated_links_are_found_by_mass_and_com():
    for seed in range(40):
        one = scrambled_table(np.random.default_rng([12, seed]))
        if len(one.alike) > 1:
            groups = hypotheses.alike_links(one.table, np.array([b.com for b in one.bodies]))
            assert set(one.alike) in [set(g) for g in groups]


@pytest.mark.parametrize("seed", range(6))
def test_the_other_end_of_a_link_follows_from_the_frames(seed):
    """Standard: frame i-1 seen from frame i; modified: frame i+1 seen from frame i; both at any q."""
    one = scrambled_table(np.random.default_rng([15, seed]))
    for convention in Convention:
        links = one.table.chain(convention).links
        ends, vectors = hypotheses.other_ends(one.table, convention), hypotheses.frame_vectors(one.table, convention)
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
    moved = hypotheses.with_rows_moved(one.table, 1)
    assert np.isnan(one.table.com[-1]).all()
    assert np.array_equal(moved.com[-1], one.table.origin[-1])
    assert np.isnan(hypotheses.shifted(one.table.origin, 1)[0]).all()


@pytest.mark.slow
def test_what_no_number_shows_is_open():
    trials = [scrambled_table(np.random.default_rng([14, k])) for k in range(40)]
    open_ = {kind: [bool(open_choices(t)) for t in trials if t.kind == kind] for kind in ("numbers", "both")}
    assert any(open_["numbers"])
    assert sum(open_["both"]) < sum(open_["numbers"])
