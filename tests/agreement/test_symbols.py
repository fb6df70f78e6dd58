"""The recursion runs on symbols: the expressions from which kernels are generated."""

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.newton_euler import Recursion


def symbols(name, n=7):
    return np.array([casadi.SX.sym(f"{name}{i}") for i in range(n)])


@pytest.fixture(scope="module")
def recursion():
    return Recursion.of(lwr_dyn.load("lwr4plus").chain)


def test_inverse_dynamics_traces_to_about_840_operations_and_the_same_numbers(recursion):
    q, dq, ddq = symbols("q"), symbols("dq"), symbols("ddq")
    tau = recursion.inverse_dynamics(q, dq, ddq)
    assert tau.shape == (7,)
    assert tau.dtype == object
    traced = casadi.Function("tau", [casadi.vertcat(*x) for x in (q, dq, ddq)], [casadi.vertcat(*tau)])
    x = np.random.default_rng(0).uniform(-2, 2, (3, 7))
    assert np.abs(np.array(traced(*x)).ravel() - recursion.inverse_dynamics(*x)).max() < 1e-13
    assert traced.n_instructions() < 900  # right-angle twists leave exact zeros; 6e-17 would leave thousands


def test_gravity_alone_costs_far_less_because_zeros_are_structural(recursion):
    q = symbols("q")
    g = casadi.Function("g", [casadi.vertcat(*q)], [casadi.vertcat(*recursion.gravity_vector(q))])
    assert g.n_instructions() < 300


def test_mass_matrix_and_energy_trace_too(recursion):
    q = symbols("q")
    U = recursion.potential_energy(q)
    gradient = casadi.Function("g", [casadi.vertcat(*q)], [casadi.gradient(U, casadi.vertcat(*q))])
    x = np.random.default_rng(1).uniform(-2, 2, 7)
    assert np.abs(np.array(gradient(x)).ravel() - recursion.gravity_vector(x)).max() < 1e-12


@pytest.mark.parametrize("scalar", [np.float32, np.float64, np.longdouble, np.complex128])
def test_number_types_keep_their_type(recursion, scalar):
    x = np.random.default_rng(2).uniform(-1, 1, (3, 4, 7)).astype(scalar)
    assert recursion.inverse_dynamics(*x).dtype == scalar
