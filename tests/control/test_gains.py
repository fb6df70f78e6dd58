"""Gains of a second-order loop, modes of a mass matrix, and the slope of the gravity torque."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import (
    LARGEST,
    diagonal,
    gravity_stiffness,
    modes,
    no_torque_known,
    second_order_gains,
    worst_case_gains,
)
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.chain import JointKind
from tests.simulation.sample_runs import one_joint


def test_gains_are_the_second_order_formulas():
    gains, plain = second_order_gains([2.0, 0.5], omega_n=10.0, xi=0.7), second_order_gains([1.0])
    np.testing.assert_allclose([gains.Kp, gains.Kd], [[200.0, 50.0], [28.0, 7.0]], rtol=1e-15)
    assert (gains.omega_n, gains.xi, plain.Kp[0], plain.Kd[0]) == (10.0, 0.7, 2500.0, 100.0)
    assert second_order_gains([1.0], LARGEST, 1.0).Kp.tolist() == [1e18]


@pytest.mark.parametrize(
    ("inertia", "options", "error", "words"),
    [
        *([[1.0], {name: bad}, OptionError, f"{name}: {bad}; allowed: a number above 0"]
          for name in ("omega_n", "xi") for bad in (0.0, -1.0, np.nan, np.inf)),
        *([[1.0], {name: 1.001e9}, OptionError, r"omega_n, xi: 1001000000.0; allowed: at most 1e\+09"]
          for name in ("omega_n", "xi")),
        ([1.0, 0.0], {}, OptionError, r"^inertia: .* a number above 0"),
        ([2.0, -1e-9], {}, OptionError, r"^inertia: .* a number above 0"),
        ([1.0, np.nan], {}, ShapeError, "inertia: nan"),
    ],
)  # fmt: skip
def test_gains_of_what_is_not_positive_or_would_overflow_are_refused(inertia, options, error, words):
    with pytest.raises(error, match=words):
        second_order_gains(inertia, **options)


def test_worst_case_gains_are_those_of_the_largest_inertia_or_of_the_one_given():
    arm = lwr_dyn.load("lwr4plus")
    gains = worst_case_gains(arm, 20.0, 0.7)
    assert gains.Kp.tolist() == pytest.approx([400.0 * w.value for w in worst_case_inertias(arm)], rel=1e-14)
    assert worst_case_gains(arm, 20.0, 0.7, np.full(7, 3.0)).Kd.tolist() == pytest.approx([84.0] * 7)
    with pytest.raises(OptionError, match=r"^omega_n"):  # before the search, which this arm has no limits for
        worst_case_gains(one_joint(), -1.0)


@pytest.mark.parametrize("rows", [3, 6, 8])
def test_modes_rebuild_the_matrices_that_they_are_of(rows):
    rng = np.random.default_rng(rows)
    A = rng.standard_normal((6, 8))
    B, weighted = A @ A.T + np.eye(6), rng.standard_normal((6, rows))
    found = modes(B, weighted.copy())
    np.testing.assert_allclose(found.root @ found.root.T, B, atol=1e-12)
    assert np.array_equal(found.root, np.tril(found.root))
    m = min(6, rows)
    assert (found.joint.shape, found.frequency.shape, found.task.shape) == ((6, m), (m,), (m, rows))
    np.testing.assert_allclose(found.root @ (found.joint * found.frequency) @ found.task, weighted, atol=1e-12)
    assert (np.diff(found.frequency) <= 0.0).all()
    assert modes(-B, weighted) is None
    assert np.isnan(no_torque_known(3)).tolist() == [True] * 3


def test_the_slope_of_gravity_is_a_central_difference_of_a_ten_thousandth():
    """Of a pendulum, m g l sin q: m g l cos q sin(h) / h, with more digits than the truncation leaves."""
    pendulum = one_joint(JointKind.REVOLUTE, mass=2.0, lever=0.5, gravity=(0.0, -9.81, 0.0))
    q = np.array([[0.3], [-2.0], [3.1]])
    slope = gravity_stiffness(lwr_dyn.dynamics_of(pendulum, "newton-euler"), q)
    np.testing.assert_allclose(slope[:, 0, 0], -9.81 * np.sin(q[:, 0]) * np.sin(1e-4) / 1e-4, rtol=2e-11)
    dynamics, q = lwr_dyn.dynamics_of(lwr_dyn.load("lwr4plus")), np.random.default_rng(2).uniform(-1, 1, (2, 7))
    column = [dynamics.gravity_vector(q + side * 1e-5 * np.eye(7)[3]) for side in (1.0, -1.0)]
    np.testing.assert_allclose(gravity_stiffness(dynamics, q)[:, :, 3], (column[0] - column[1]) / 2e-5, atol=1e-6)
    assert diagonal(np.array([2.0, 3.0]), 2).tolist() == [[[2.0, 0.0], [0.0, 3.0]]] * 2
