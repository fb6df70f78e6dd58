"""What is a body: every cloud of mass points is, and nothing beyond their cone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.model.chain import Body, is_physical, unphysical_links, with_bodies, with_payload
from lwr_dyn.model.spatial import from_rpy
from tests.random_arms import arms, random_arm, random_body

TENSORS = {
    "negative moment": np.diag([-0.1, 1.0, 1.0]),
    "triangle inequality": np.diag([1.0, 1.0, 2.001]),
    "indefinite by a product": np.array([[1.0, 1.5, 0.0], [1.5, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "not symmetric": np.array([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "not a number": np.full((3, 3), np.nan),
}


@given(arms)
def test_clouds_of_mass_points_are_bodies(arm):
    assert unphysical_links(arm.chain) == ()


@given(st.integers(0, 10**6))
def test_turned_borders_stay_inside_and_a_step_further_is_outside(seed):
    rng = np.random.default_rng(seed)
    R = from_rpy(rng.uniform(-3, 3, 3))
    moments = np.array([a := rng.uniform(0.1, 1), b := rng.uniform(0.1, 1), a + b])  # a lamina
    assert is_physical(Body(1.0, np.zeros(3), R @ np.diag(moments) @ R.T))
    beyond = moments * [1, 1, 1 + 1e-6]
    assert not is_physical(Body(1.0, np.zeros(3), R @ np.diag(beyond) @ R.T))


@pytest.mark.parametrize("fault", TENSORS)
def test_no_body_has_it(fault):
    assert not is_physical(Body(1.0, np.zeros(3), TENSORS[fault]))


@pytest.mark.parametrize(
    ("mass", "inertia", "physical"),
    [(0.0, 0.0, True), (0.0, 1.0, False), (-1.0, 1.0, False), (1.0, 0.0, True), (np.nan, 1.0, False)],
)
def test_mass_and_inertia_go_together(mass, inertia, physical):
    assert is_physical(Body(mass, np.zeros(3), inertia * np.eye(3))) is physical


def test_the_link_is_named():
    arm = random_arm(5, "RRR")
    bodies = [random_body(np.random.default_rng(i)) for i in range(3)]
    bodies[1] = Body(1.0, np.zeros(3), TENSORS["triangle inequality"])
    assert unphysical_links(with_bodies(arm.chain, bodies)) == ("link_2",)


def test_links_without_a_body_do_not_count():
    assert unphysical_links(lwr_dyn.load("lwr4").chain) == ()


def test_readings_and_a_point_payload_are_physical():
    for reading in lwr_dyn.readings("lwr4plus"):
        chain = lwr_dyn.load("lwr4plus", reading).chain
        assert unphysical_links(chain) == ()
        assert unphysical_links(with_payload(chain, 3.0, (0.0, 0.0, 0.1))) == ()
