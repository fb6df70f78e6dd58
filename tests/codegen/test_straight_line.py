"""Straight-line code: quotients by one divisor become products with its reciprocal."""

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernel_spec import kernel_spec
from lwr_dyn.codegen.sincos import sincos
from lwr_dyn.codegen.straight_line import straight_line_code
from lwr_dyn.codegen.symbolic_functions import symbolic_function
from tests.codegen.evaluate import straight_line_values

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
    spec = kernel_spec(lwr_dyn.load("lwr4plus"))
    code = straight_line_code(symbolic_function(spec, function), sincos("float64"))
    assert sum(node.op == "/" for node in code.nodes) == quotients
