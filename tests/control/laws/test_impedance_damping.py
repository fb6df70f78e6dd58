"""The factorisation behind the damping, against inverses, and where these do not exist."""

import numpy as np

from lwr_dyn.control.gains import modes
from lwr_dyn.kinematics.forward import jacobian
from tests.control.laws.written_out import ARM, REGULAR, ROAD_B, designed_damping, tip_inertia
from tests.slips import uncaught

K = np.array([2000.0, 1500.0, 1000.0, 200.0, 200.0, 200.0])
SLIPS = (
    ("dpotrf(B, lower=1, clean=1)", "dpotrf(B, lower=0, clean=1)"),
    ("dpotrf(B, lower=1, clean=1)", "dpotrf(B, lower=1, clean=0)"),
    ("dtrtrs(root, weighted, lower=1)[0]", "dtrtrs(root, weighted, lower=1, trans=1)[0]"),
    ("dtrtrs(root, weighted, lower=1)[0]", "root @ weighted"),
    ("dgesdd(reduced, full_matrices=0)", "dgesdd(reduced.T, full_matrices=0)"),
    ("    if fault:\n        return None\n", ""),
)


def check(module):
    B, weighted = ROAD_B.mass_matrix(REGULAR), (np.sqrt(K)[:, None] * jacobian(ARM.chain, REGULAR)).T
    L, A, S, Ut = module.modes(B, weighted)
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
    assert module.modes(-np.eye(7), weighted) is None


def test_planted_slips_are_caught():
    assert not uncaught("lwr_dyn.control.gains", SLIPS, check)


def test_at_a_singular_pose_all_parts_stay_bounded():
    q = np.array([0.3, 0.6, 0.2, 1.2, np.pi / 2, 0.0, 0.1])
    J, B = jacobian(ARM.chain, q), ROAD_B.mass_matrix(q)
    L, A, S, _ = modes(B, (np.sqrt(K)[:, None] * J).T)
    assert S[-1] < 1e-10 * S[0]
    np.testing.assert_allclose(A.T @ A, np.eye(6), atol=1e-12)
    projected = L @ (np.eye(7) - A @ A.T) @ np.linalg.inv(L)
    np.testing.assert_allclose(J @ np.linalg.solve(B, projected), np.zeros((6, 7)), atol=1e-10)
