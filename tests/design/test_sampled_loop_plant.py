"""The plant at rest: its exact step against cases known by hand and against the equations of motion."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lwr_dyn.design import sampled_loop
from lwr_dyn.design.sampled_loop import RestingPlant, rigid_plant
from tests.simulation.sample_runs import MIDDLE, lwr_dynamics
from tests.slips import uncaught


@pytest.mark.parametrize("T", [1e-3, 0.3])
def test_a_pendulum_and_a_falling_one_known_by_hand(T):
    w = np.array([30.0, 5.0])
    A, B = np.zeros((2, 2, 2)), np.zeros((2, 2, 1))
    A[:, 0, 1], A[:, 1, 0], B[:, 1, 0] = 1.0, [-(w[0] ** 2), w[1] ** 2], 1.0
    Ad, Bd = RestingPlant(A, B, np.eye(1, 2), np.eye(1, 2, 1)).held(T)
    c, s = np.array([np.cos(w[0] * T), np.cosh(w[1] * T)]), np.array([np.sin(w[0] * T), np.sinh(w[1] * T)])
    square = np.array([w[0] ** 2, -(w[1] ** 2)])
    np.testing.assert_allclose(Ad[:, 0, 0], c, rtol=1e-12)
    np.testing.assert_allclose(Ad[:, 0, 1], s / w, rtol=1e-12)
    np.testing.assert_allclose(Bd[:, 0, 0], (1 - c) / square, rtol=1e-9)
    np.testing.assert_allclose(Bd[:, 1, 0], s / w, rtol=1e-12)


def check(module):
    """The held step is what the equations of motion do near rest."""
    plant, dynamics, T, h = module.rigid_plant(lwr_dynamics(), MIDDLE[None]), lwr_dynamics(), 0.02, 1e-6
    Ad, Bd = plant.held(T)
    z, u = h * np.linspace(-1, 1, 14), h * np.linspace(2, 3, 7)
    tau = dynamics.gravity_vector(MIDDLE) + u

    def rate(t, y):
        return np.concatenate([y[7:], dynamics.forward_dynamics(y[:7], y[7:], tau)])

    end = solve_ivp(rate, (0, T), np.concatenate([MIDDLE, np.zeros(7)]) + z, rtol=1e-12, atol=1e-16).y[:, -1]
    found = end - np.concatenate([MIDDLE, np.zeros(7)])
    expected = Ad[0] @ z + Bd[0] @ u
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


SLIPS = (
    ("-inverse @ gravity_stiffness", "inverse @ gravity_stiffness"),
    ("A[:, :n, n:]", "A[:, n:, n:]"),
    ("gravity_stiffness(dynamics, q), inverse", "gravity_stiffness(dynamics, q), dynamics.mass_matrix(q)"),
    ("self.A * T, self.B * T", "self.A * T, self.B"),
    ("self.A * T, self.B * T", "self.A, self.B * T"),
    ("step[:, :N, :N], step[:, :N, N:]", "step[:, :N, :N], 2 * step[:, :N, N:]"),
)


def test_planted_slips_are_caught():
    assert not uncaught(sampled_loop.__name__, SLIPS, check)


def test_a_part_of_the_poses_is_the_plant_of_these_poses():
    q = np.random.default_rng(2).uniform(-1, 1, (5, 7))
    part, alone = rigid_plant(lwr_dynamics(), q).at(np.array([3])), rigid_plant(lwr_dynamics(), q[3:4])
    np.testing.assert_allclose(part.held(1e-3)[0], alone.held(1e-3)[0], rtol=1e-9, atol=1e-12)
    assert (part.size, part.n) == (14, 7)
