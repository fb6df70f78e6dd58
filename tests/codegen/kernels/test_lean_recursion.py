"""The lean recursion: on any chain it gives the torques, the mass matrix and the energies of the readable one."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import lean_recursion
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.codegen.kernels.lean_recursion import axis_frames, base_matrix, parameter_map
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.model.spatial import Vector
from tests.random_arms import random_arm

CHAINS = {
    **{name: lwr_dyn.load(name).chain for name in ("lwr4plus", "wam7", "kr30ha")},
    "RPRRP": random_arm(0, "RPRRP").chain,
    **{f"seed {seed}": random_arm(seed).chain for seed in (3, 11, 12, *range(20, 30))},
}


@pytest.mark.parametrize("name", CHAINS)
def test_it_is_the_readable_recursion(name):
    """With the parameters of the bodies, and with those alone on which a torque depends."""
    chain = CHAINS[name]
    q, dq, ddq = np.random.default_rng(len(name)).uniform(-2, 2, (3, chain.n))
    readable, gravity, frames = Recursion.of(chain, "none"), Vector.of(chain.gravity), axis_frames(chain)
    own = parameter_map(frames) @ inertial_parameters(chain).ravel()
    for parameters in (own, base_matrix(frames, chain.gravity) @ own):
        bodies = parameters.reshape(chain.n, 10).tolist()
        tau = np.array(lean_recursion.inverse_dynamics(frames, bodies, gravity, q, dq, ddq), dtype=float)
        B = np.array(lean_recursion.mass_matrix(frames, bodies, q), dtype=float)
        for found, expected in ((tau, readable.inverse_dynamics(q, dq, ddq)), (B, readable.mass_matrix(q))):
            assert np.abs(found - expected).max() <= 1e-12 * max(1.0, np.abs(expected).max())
    U = lean_recursion.potential_energy(frames, own.reshape(chain.n, 10).tolist(), gravity, q)
    assert abs(U - readable.potential_energy(q)) <= 1e-12 * max(1.0, abs(U))


def test_the_axes_of_the_lwr_leave_two_shifts_and_more_parameters_matter_under_any_gravity():
    chain = CHAINS["lwr4plus"]
    frames = axis_frames(chain)
    shifts = np.array([(f.shift.x, f.shift.y, f.shift.z) for f in frames])
    assert np.flatnonzero(shifts.any(axis=1)).tolist() == [3, 5]
    np.testing.assert_allclose(shifts[[3, 5]], [[0.0, 0.0, 0.4], [0.0, 0.0, 0.39]], rtol=1e-12)
    counts = [np.count_nonzero(base_matrix(frames, g).any(axis=1)) for g in (chain.gravity, None)]
    assert counts[0] < counts[1]


@pytest.mark.parametrize(("name", "count"), [("lwr4plus", 43), ("wam7", 43), ("kr30ha", 36)])
def test_the_number_of_base_parameters(name, count):
    chain = CHAINS[name]
    K = base_matrix(axis_frames(chain), chain.gravity)
    kept = np.flatnonzero(K.any(axis=1))
    assert len(kept) == count
    assert np.abs(K[np.ix_(kept, kept)] - np.eye(count)).max() < 1e-10
    assert not K[::10].any()  # no mass is left
