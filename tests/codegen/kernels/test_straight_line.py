"""Straight-line code: quotients by one divisor become products with its reciprocal; what its flag watches."""

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.batch import address_and_step
from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS, kernel_spec
from lwr_dyn.codegen.kernels.straight_line import reached_inputs, straight_line_code
from lwr_dyn.codegen.kernels.symbolic_functions import symbolic_function
from tests.codegen.kernels.evaluate import straight_line_values

ARM = lwr_dyn.load("lwr4plus")
X = casadi.SX.sym("x", 3)


def code_of(*results):
    function = casadi.Function("f", [X], [casadi.vertcat(*results)])
    return straight_line_code(function, sincos("float64"), is_flagged=False)


def operations_of(*results):
    return "".join(sorted(node.op for node in code_of(*results).nodes if node.op not in ("in", "const")))


def test_several_quotients_by_one_divisor_share_its_reciprocal():
    assert operations_of(X[0] / X[2], X[1] / X[2]) == "**/"
    assert operations_of(X[0] / X[2], 1 / X[2]) == "*/"
    assert operations_of(X[0] / -X[2], X[1] / X[2]) == "**/"


def test_a_quotient_alone_and_one_by_a_power_of_two_keep_their_rounding():
    assert operations_of(X[0] / X[2]) == "/"
    assert operations_of(X[0] / 2, X[1] / -0.25) == "**"
    assert operations_of(X[0] / 3) == "/"


def test_the_values_are_those_of_the_function():
    results = (X[0] / X[2], X[1] / -X[2], 1 / X[2], X[0] / 2 / X[1], -X[0] / -0.5)
    x = np.array([0.3, -1.7, 2.9])
    values = straight_line_values(code_of(*results), x)
    expected = np.array([x[0] / x[2], -x[1] / x[2], 1 / x[2], x[0] / 2 / x[1], x[0] / 0.5])
    assert np.abs(values / expected - 1.0).max() < 3e-16


@pytest.mark.parametrize(("function", "quotients"), [("forward_dynamics", 6), ("coriolis_matrix", 0)])
def test_an_arms_quotients_are_as_many_as_its_pivots_that_change(function, quotients):
    code = straight_line_code(symbolic_function(kernel_spec(ARM), function), sincos("float64"))
    assert sum(node.op == "/" for node in code.nodes) == quotients


@pytest.mark.parametrize(
    ("result", "reached"),
    [
        (X[0] * X[1] - 3.0, {0, 1}),
        (casadi.sqrt(X[0]) + casadi.fabs(X[2]), {0, 2}),
        (X[0] / X[1], {0}),  # x / infinity is 0
        (casadi.sin(X[0]) + casadi.cos(X[1]) * X[2], {0, 1, 2}),
        (casadi.fmin(X[0], X[1]) + X[2], {2}),
        (casadi.if_else(X[0] < 1.0, X[1], X[2]), set()),
        (casadi.tanh(X[0]) + X[1], {1}),
        (2.0, set()),
    ],
)
def test_a_result_tells_of_inputs_only_where_they_must_spoil_it(result, reached):
    code = code_of(result)
    known = reached_inputs(code.nodes)[code.results[0].node]
    assert {node.b for i, node in enumerate(code.nodes) if known >> i & 1} == reached


@pytest.mark.slow
@pytest.mark.usefixtures("by_python")
@pytest.mark.parametrize("function", FUNCTIONS)
def test_every_number_of_a_state_is_watched(function):
    arguments = len(FUNCTIONS[function].states)
    states = np.tile(np.random.default_rng(5).uniform(-1, 1, (arguments, 1, 7)), (1, 7 * arguments * 3, 1))
    for row in range(states.shape[1]):
        which, kind = divmod(row, 3)
        states[which // 7, row, which % 7] = (np.nan, np.inf, -np.inf)[kind]
    batch = lwr_dyn.batch_dynamics(ARM)
    form, kernel = batch.form(function), batch.kernel(function)
    for count in (states.shape[1], 1):
        out = form.empty(count)
        given = [address_and_step(rows, count) for rows in states[:, :count]]
        assert kernel.run(given, out.__array_interface__["data"][0], count) == count
