"""The lean recursion: on any chain it gives the torques, the mass matrix and the energies of the readable one."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.codegen.kernels.lean_recursion import axis_frames, base_matrix, parameter_map
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.model.spatial import Vector
from tests.random_arms import random_arm
from tests.slips import uncaught

SEEDS = (0, 3, 11, 12)
SLIPS = (
    ("ZERO, ZERO, -gravity", "ZERO, ZERO, gravity"),
    ("add(xy, domega.z), multiply(-1.0, add(xx, zz))", "add(xy, domega.z), add(xx, zz)"),
    ("omega.cross(spin) + body.first.cross(a)", "omega.cross(spin)"),
    ("+ omega.cross(spin)", "- omega.cross(spin)"),
    (".times(multiply(2.0, dq[i]))", ".times(dq[i])"),
    ("        moment = moment + frame.shift.cross(force)\n    return tau", "    return tau"),
    ("subtract(I.xx, u), xy, add(I.yy, u)", "add(I.xx, u), xy, subtract(I.yy, u)"),
    ("g = h + moved ", "g = moved + moved "),
    (
        "return Z.times(self.mass), Vector(h.y, multiply(-1.0, h.x), 0.0)",
        "return Z.times(self.mass), Vector(h.x, h.y, 0.0)",
    ),
    ("first = frame.turn @ first + frame.shift.times(mass)", "first = frame.turn @ first"),
    (
        "add(multiply(self.s, v.x), multiply(self.c, v.y)), v.z",
        "subtract(multiply(self.c, v.y), multiply(self.s, v.x)), v.z",
    ),
)


def parameters(chain, are_folded):
    frames = axis_frames(chain)
    own = parameter_map(frames) @ inertial_parameters(chain).ravel()
    if are_folded:
        own = base_matrix(frames, chain.gravity) @ own
    return frames, own.reshape(chain.n, 10).tolist()


def check(module):
    for seed in SEEDS:
        compare(module, random_arm(seed, "RPRRP" if seed == 0 else None).chain, seed)


def compare(module, chain, seed):
    q, dq, ddq = np.random.default_rng(seed).uniform(-2, 2, (3, chain.n))
    readable, gravity = Recursion.of(chain, "none"), Vector.of(chain.gravity)
    for are_folded in (False, True):
        frames, bodies = parameters(chain, are_folded)
        tau = np.array(module.inverse_dynamics(frames, bodies, gravity, q, dq, ddq), dtype=float)
        expected = readable.inverse_dynamics(q, dq, ddq)
        assert np.abs(tau - expected).max() <= 1e-12 * max(1.0, np.abs(expected).max())
        B = np.array(module.mass_matrix(frames, bodies, q), dtype=float)
        expected = readable.mass_matrix(q)
        assert np.abs(B - expected).max() <= 1e-12 * max(1.0, np.abs(expected).max())
    frames, bodies = parameters(chain, False)
    U = module.potential_energy(frames, bodies, gravity, q)
    assert abs(U - readable.potential_energy(q)) <= 1e-12 * max(1.0, abs(U))


def test_planted_slips_are_caught():
    assert not uncaught("lwr_dyn.codegen.kernels.lean_recursion", SLIPS, check)


@pytest.mark.parametrize("name", ["lwr4plus", "wam7", "kr30ha"])
def test_the_robots(name):
    from lwr_dyn.codegen.kernels import lean_recursion

    compare(lean_recursion, lwr_dyn.load(name).chain, 5)


@pytest.mark.parametrize("seed", range(20, 30))
def test_random_chains(seed):
    from lwr_dyn.codegen.kernels import lean_recursion

    compare(lean_recursion, random_arm(seed).chain, seed)


def test_the_axes_of_the_lwr_leave_two_shifts():
    frames = axis_frames(lwr_dyn.load("lwr4plus").chain)
    shifts = [(f.shift.x, f.shift.y, f.shift.z) for f in frames]
    assert [i for i, shift in enumerate(shifts) if any(shift)] == [3, 5]
    assert shifts[3] == (0.0, 0.0, pytest.approx(0.4))
    assert shifts[5] == (0.0, 0.0, pytest.approx(0.39))


@pytest.mark.parametrize(("name", "count"), [("lwr4plus", 43), ("wam7", 43), ("kr30ha", 36)])
def test_the_number_of_base_parameters(name, count):
    chain = lwr_dyn.load(name).chain
    K = base_matrix(axis_frames(chain), chain.gravity)
    kept = np.flatnonzero(K.any(axis=1))
    assert len(kept) == count
    assert np.abs(K[np.ix_(kept, kept)] - np.eye(count)).max() < 1e-10
    assert not K[[i for i in range(len(K)) if i % 10 == 0]].any()  # no mass is left


def test_more_parameters_matter_under_any_gravity():
    chain = lwr_dyn.load("lwr4plus").chain
    frames = axis_frames(chain)
    some, any_ = (np.count_nonzero(base_matrix(frames, g).any(axis=1)) for g in (chain.gravity, None))
    assert any_ > some
