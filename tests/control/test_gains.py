"""Gains of a second-order loop, modes of a mass matrix, and the slope of the gravity torque."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import LARGEST, diagonal, gravity_stiffness, modes, second_order_gains, worst_case_gains
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.model.chain import JointKind
from tests.control.laws.written_out import ARM, REGULAR, ROAD_B, designed_damping, tip_inertia
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


K = np.array([2000.0, 1500.0, 1000.0, 200.0, 200.0, 200.0])


def test_modes_are_those_of_the_pencil():
    B, weighted = ROAD_B.mass_matrix(REGULAR), (np.sqrt(K)[:, None] * jacobian(ARM.chain, REGULAR)).T
    L, A, S, Ut = modes(B, weighted)
    Lambda, Jbar, J = tip_inertia(ARM, ROAD_B, REGULAR)
    np.testing.assert_allclose(L @ L.T, B, atol=1e-12)
    squares = np.linalg.eigvals(np.linalg.solve(Lambda, np.diag(K))).real
    np.testing.assert_allclose(S**2, np.sort(squares)[::-1], rtol=1e-9)
    assert (L.shape, A.shape, Ut.shape) == ((7, 7), (7, 6), (6, 6))
    D = designed_damping(Lambda, np.diag(K), 0.7)
    np.testing.assert_allclose(1.4 * L @ A @ Ut @ np.diag(np.sqrt(K)), J.T @ D, rtol=0, atol=1e-9 * np.abs(D).max())
    np.testing.assert_allclose(1.4 * L @ (A * S) @ A.T @ L.T, J.T @ D @ J, rtol=0, atol=1e-9 * np.abs(D).max())
    projector = L @ (np.eye(7) - A @ A.T) @ np.linalg.inv(L)
    np.testing.assert_allclose(projector, np.eye(7) - J.T @ Jbar.T, atol=1e-9)
    assert modes(-np.eye(7), weighted) is None
    assert np.array_equal(L, np.tril(L))
    assert (np.diff(S) <= 0.0).all()
    for rows in (3, 8):  # fewer and more than joints
        free = np.random.default_rng(rows).standard_normal((7, rows))
        found = modes(B, free.copy())
        np.testing.assert_allclose(found.root @ (found.joint * found.frequency) @ found.task, free, atol=1e-12)


def test_at_a_singular_pose_all_parts_of_the_modes_stay_bounded():
    q = np.array([0.3, 0.6, 0.2, 1.2, np.pi / 2, 0.0, 0.1])
    J, B = jacobian(ARM.chain, q), ROAD_B.mass_matrix(q)
    L, A, S, _ = modes(B, (np.sqrt(K)[:, None] * J).T)
    assert S[-1] < 1e-10 * S[0]
    np.testing.assert_allclose(A.T @ A, np.eye(6), atol=1e-12)
    projected = L @ (np.eye(7) - A @ A.T) @ np.linalg.inv(L)
    np.testing.assert_allclose(J @ np.linalg.solve(B, projected), np.zeros((6, 7)), atol=1e-10)
