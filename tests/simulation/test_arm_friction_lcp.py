"""The boxed problem: against all combinations of sides tried one by one."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.simulation.arm_friction import boxed_lcp

CLOSE = 1e-8
"""Relative, on random matrices with condition numbers up to 1e4."""


def problem(seed, size):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(size, size))
    lo, hi = -rng.uniform(0, 1.5, size), rng.uniform(0, 1.5, size)
    hi[rng.random(size) < 0.2] = np.inf
    return root @ root.T + 0.1 * np.eye(size), rng.normal(size=size) * 2, lo, hi


def every_solution(M, b, lo, hi):
    """Solutions found by trying every joint at every side."""
    solutions = []
    for sides in itertools.product((-1, 0, 1), repeat=b.size):
        s = np.array(sides)
        if not np.isfinite(hi[s > 0]).all():
            continue
        f = np.where(s > 0, hi, lo)
        at = s == 0
        f[at] = np.linalg.solve(M[np.ix_(at, at)], b[at] - M[np.ix_(at, ~at)] @ f[~at])
        if (f >= lo).all() and (f <= hi).all() and (s * (b - M @ f) >= 0).all():
            solutions.append((f, s))
    return solutions


@given(st.integers(0, 10**6), st.integers(1, 4))
def test_it_is_the_one_solution(seed, size):
    M, b, lo, hi = problem(seed, size)
    (f, sides), *others = every_solution(M, b, lo, hi)
    assert not others
    got = boxed_lcp(M, b, lo, hi)
    np.testing.assert_allclose(got.force, f, rtol=CLOSE, atol=CLOSE)
    np.testing.assert_array_equal(got.sides, sides)


@given(st.integers(0, 10**6), st.integers(5, 7))
def test_seven_joints_at_once(seed, size):
    M, b, lo, hi = problem(seed, size)
    got = boxed_lcp(M, b, lo, hi)
    w = b - M @ got.force
    assert ((got.force >= lo) & (got.force <= hi)).all()
    assert (w[got.force < hi] <= CLOSE * np.abs(b).max()).all()
    assert (w[got.force > lo] >= -CLOSE * np.abs(b).max()).all()


@given(st.integers(0, 10**6), st.integers(1, 6))
def test_a_stop_is_a_problem_with_one_bound(seed, size):
    """Stops of a lower limit: they push, -f >= 0, or the joint leaves, w >= 0, never both."""
    M, b, *_ = problem(seed, size)
    got = boxed_lcp(M, b, np.full(size, -np.inf), np.zeros(size))
    w = b - M @ got.force
    assert (got.force <= 0).all()
    assert (w >= -1e-9).all()
    assert np.abs(got.force * w).max() <= 1e-9
    assert (b < 0).any() == (got.force < 0).any()


def test_on_the_border_the_start_decides():
    """b = hi: at rest and about to move are both right, a joint that is known to have given way moves."""
    one = np.ones(1)
    assert boxed_lcp(np.eye(1), one, -one, one).sides.tolist() == [0]
    assert boxed_lcp(np.eye(1), one, -one, one, np.array([1])).sides.tolist() == [1]
    assert boxed_lcp(np.eye(1), 0.9 * one, -one, one, np.array([1])).sides.tolist() == [0]
