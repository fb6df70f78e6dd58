"""The engine "kernels": rows go to the kernel unread, and what is wrong with them is said as by every other engine."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.protocol import FUNCTIONS
from lwr_dyn.foundation.errors import ShapeError, SingularMassError
from tests.codegen.kernels.evaluate import states

ARM = lwr_dyn.load("lwr4plus")
ENGINE, ROAD_B = lwr_dyn.dynamics_of(ARM, "kernels"), lwr_dyn.dynamics_of(ARM, "newton-euler")
X = states(7, 24)


@pytest.mark.slow
@pytest.mark.parametrize("function", FUNCTIONS)
def test_rows_of_any_form_give_the_numbers_of_road_b(function):
    arguments = X[: len(FUNCTIONS[function][0])]
    expected = getattr(ROAD_B, function)(*arguments)
    forms = (
        arguments,
        [x.tolist() for x in arguments],
        [np.asfortranarray(x) for x in arguments],
        [np.repeat(x, 2, axis=1)[:, ::2] for x in arguments],
        [x.astype(np.longdouble) for x in arguments],
    )
    close = 1e-12 * max(1.0, np.abs(expected).max())
    for given in forms:
        difference = getattr(ENGINE, function)(*given) - expected
        offset = difference.mean() if function == "potential_energy" else 0.0  # only differences mean something
        assert np.abs(difference - offset).max() < close
    block = getattr(ENGINE, function)(*(x.reshape(2, 12, 7) for x in arguments))
    assert np.array_equal(block.reshape(expected.shape), getattr(ENGINE, function)(*arguments))
    assert len(getattr(ENGINE, function)(*(x[:0] for x in arguments))) == 0


@pytest.mark.slow
@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_value_that_is_not_finite_is_named(function, value):
    names = FUNCTIONS[function][0]
    for k, name in enumerate(names):
        arguments = [x.copy() for x in X[: len(names)]]
        arguments[k][13, 4] = value
        with pytest.raises(ShapeError, match=rf"{name}: {value} at index \(13, 4\)"):
            getattr(ENGINE, function)(*arguments)


@pytest.mark.slow
def test_large_angles_and_a_single_state_for_all():
    q = X[0].copy()
    q[3, 2] += 2e6 * np.pi
    assert np.abs(ENGINE.mass_matrix(q) - ENGINE.mass_matrix(X[0])).max() < 1e-8
    assert np.array_equal(ENGINE.bias_torque(X[0], X[1][0]), ENGINE.bias_torque(X[0], np.tile(X[1][0], (24, 1))))


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ShapeError, match="leading axes that broadcast"):
        ENGINE.bias_torque(X[0], X[1][:5])
    with pytest.raises(ShapeError, match="7 numbers, one per joint"):
        ENGINE.mass_matrix(X[0][:, :6])
    with pytest.raises(TypeError, match="1 arguments given"):
        ENGINE.bias_torque(X[0])


@pytest.mark.slow
def test_accelerations_that_are_not_determined():
    from dataclasses import replace

    from lwr_dyn.model.chain import Body

    last = ARM.chain.links[-1]
    links = (*ARM.chain.links[:-1], replace(last, body=Body.massless(), rotor=None))
    arm = replace(ARM, chain=replace(ARM.chain, links=links))
    with pytest.raises(SingularMassError, match="joint 7"):
        lwr_dyn.dynamics_of(arm, "kernels").forward_dynamics(*X)
