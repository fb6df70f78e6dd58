import copy
import pickle

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.protocol import FUNCTIONS, Dynamics, mechanical_energy
from lwr_dyn.foundation.errors import ShapeError
from tests.codegen.kernels.evaluate import states

ARM = lwr_dyn.load("lwr4plus")
ENGINE, PINOCCHIO = lwr_dyn.dynamics_of(ARM, "kernels"), lwr_dyn.dynamics_of(ARM)
Q, DQ, X = states(ARM.n, 40)


@pytest.mark.parametrize("function", FUNCTIONS)
def test_single_states_are_those_of_pinocchio(function):
    count = len(FUNCTIONS[function][0])
    for state in zip(Q, DQ, X, strict=True):
        want = getattr(PINOCCHIO, function)(*state[:count])
        found = getattr(ENGINE, function)(*state[:count])
        if function == "potential_energy":  # only differences mean something
            want, found = want - PINOCCHIO.potential_energy(Q[0]), found - ENGINE.potential_energy(Q[0])
        assert np.abs(found - want).max() <= 1e-11 * max(1.0, np.abs(want).max())


def test_it_is_an_engine_that_can_be_copied_and_pickled():
    assert isinstance(ENGINE, Dynamics)
    assert repr(ENGINE) == "<engine kernels, 7 joints>"
    for made in (copy.copy(ENGINE), copy.deepcopy(ENGINE), pickle.loads(pickle.dumps(ENGINE))):
        assert np.array_equal(made.mass_matrix(Q[0]), ENGINE.mass_matrix(Q[0]))
    again = pickle.loads(pickle.dumps(ENGINE.ungated))
    assert np.array_equal(again.forward_dynamics(Q[0], DQ[0], X[0]), ENGINE.forward_dynamics(Q[0], DQ[0], X[0]))


def test_what_it_does_not_have_is_an_attribute_error():
    for of in (ENGINE, ENGINE.ungated):
        with pytest.raises(AttributeError, match="jacobian"):
            _ = of.jacobian


@pytest.mark.slow
def test_a_large_angle_gives_the_number_of_its_turn():
    far = Q[0] + 2.0 * np.pi * 1e7
    for function in ("mass_matrix", "gravity_vector"):
        for call in (getattr(ENGINE, function), getattr(ENGINE.ungated, function)):
            assert np.abs(call(far) - call(Q[0])).max() < 1e-6


@pytest.mark.slow
def test_without_a_gate_a_state_that_is_not_finite_gives_nan():
    bad = np.where(np.arange(ARM.n) == 2, np.inf, Q[0])
    assert np.isnan(ENGINE.ungated.inverse_dynamics(bad, DQ[0], X[0])).any()
    with pytest.raises(ShapeError, match="inf at index"):
        ENGINE.inverse_dynamics(bad, DQ[0], X[0])


def test_the_energy_is_that_of_its_parts():
    energies = mechanical_energy(ENGINE, Q, DQ)
    want = mechanical_energy(PINOCCHIO, Q, DQ)
    assert np.abs((energies - energies[0]) - (want - want[0])).max() < 1e-11
