"""The recursion runs on symbols: the expressions from which kernels are generated."""

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.newton_euler import Recursion


@pytest.fixture(scope="module")
def recursion():
    return Recursion.of(lwr_dyn.load("lwr4plus").chain)


def traced(call, count):
    """A function of the recursion as a casadi.Function of `count` columns, and what it gives for symbols."""
    columns = [casadi.SX.sym(name, 7) for name in ("q", "dq", "ddq")[:count]]
    out = call(*(np.array(casadi.vertsplit(x)) for x in columns))
    return casadi.Function("f", columns, [casadi.vertcat(*out.flat)]), out


def test_inverse_dynamics_traces_to_about_840_operations_and_the_same_numbers(recursion):
    function, tau = traced(recursion.inverse_dynamics, 3)
    assert (tau.shape, tau.dtype) == ((7,), object)
    x = np.random.default_rng(0).uniform(-2, 2, (3, 7))
    assert np.abs(np.array(function(*x)).ravel() - recursion.inverse_dynamics(*x)).max() < 1e-13
    assert function.n_instructions() < 900  # right-angle twists leave exact zeros; 6e-17 would leave thousands


def test_gravity_alone_costs_far_less_because_zeros_are_structural(recursion):
    assert traced(recursion.gravity_vector, 1)[0].n_instructions() < 300


def test_the_slope_of_the_traced_energy_is_the_gravity_vector(recursion):
    q = casadi.SX.sym("q", 7)
    energy = recursion.potential_energy(np.array(casadi.vertsplit(q)))
    x = np.random.default_rng(1).uniform(-2, 2, 7)
    gradient = casadi.Function("g", [q], [casadi.gradient(energy, q)])
    assert np.abs(np.array(gradient(x)).ravel() - recursion.gravity_vector(x)).max() < 1e-12
    B = traced(recursion.mass_matrix, 1)[0]
    assert np.abs(np.array(B(x)).reshape(7, 7) - recursion.mass_matrix(x)).max() < 1e-12


@pytest.mark.parametrize("scalar", [np.float32, np.float64, np.longdouble, np.complex128])
def test_number_types_keep_their_type(recursion, scalar):
    x = np.random.default_rng(2).uniform(-1, 1, (3, 4, 7)).astype(scalar)
    assert recursion.inverse_dynamics(*x).dtype == scalar
