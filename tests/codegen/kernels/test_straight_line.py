"""Straight-line code: shared reciprocals, what its flag watches; as a function of numbers: the bits of the batch."""

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import scalar_code
from lwr_dyn.codegen.kernels.batch import address_and_step
from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.engine import body_text
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS as BATCHED
from lwr_dyn.codegen.kernels.kernel_spec import function_shape, kernel_spec
from lwr_dyn.codegen.kernels.scalar_code import number, scalar_function
from lwr_dyn.codegen.kernels.straight_line import Node, StraightLineCode, Value, reached_inputs, straight_line_code
from lwr_dyn.codegen.kernels.symbolic_functions import symbolic_function
from lwr_dyn.dynamics.protocol import FUNCTIONS
from tests.codegen.kernels.evaluate import states, straight_line_values
from tests.codegen.kernels.plain_kernel import kernels_by_python

ARM = lwr_dyn.load("lwr4plus")
X = casadi.SX.sym("x", 3)


def traced(*results):
    function = casadi.Function("f", [X], [casadi.vertcat(*results)])
    return straight_line_code(function, sincos("float64"), is_flagged=False)


def operations_of(*results):
    return "".join(sorted(node.op for node in traced(*results).nodes if node.op not in ("in", "const")))


@pytest.mark.parametrize(
    ("results", "operations"),
    [
        ((X[0] / X[2], X[1] / X[2]), "**/"), ((X[0] / X[2], 1 / X[2]), "*/"), ((X[0] / -X[2], X[1] / X[2]), "**/"),
        ((X[0] / X[2],), "/"), ((X[0] / 2, X[1] / -0.25), "**"), ((X[0] / 3,), "/"),
    ],
)  # fmt: skip
def test_several_quotients_by_one_divisor_share_its_reciprocal_and_others_keep_their_rounding(results, operations):
    """Alone, or by a power of two."""
    assert operations_of(*results) == operations


def test_the_values_are_those_of_the_function():
    results = (X[0] / X[2], X[1] / -X[2], 1 / X[2], X[0] / 2 / X[1], -X[0] / -0.5)
    x = np.array([0.3, -1.7, 2.9])
    values = straight_line_values(traced(*results), x)
    expected = np.array([x[0] / x[2], -x[1] / x[2], 1 / x[2], x[0] / 2 / x[1], x[0] / 0.5])
    assert np.abs(values / expected - 1.0).max() < 3e-16


@pytest.mark.parametrize(("function", "quotients"), [("forward_dynamics", 6), ("coriolis_matrix", 0)])
def test_an_arms_quotients_are_as_many_as_its_pivots_that_change(function, quotients):
    code = straight_line_code(symbolic_function(kernel_spec(ARM), function), sincos("float64"))
    assert sum(node.op == "/" for node in code.nodes) == quotients


@pytest.mark.parametrize(
    ("result", "reached"),
    [
        (X[0] * X[1] - 3.0, {0, 1}), (casadi.sqrt(X[0]) + casadi.fabs(X[2]), {0, 2}),
        (X[0] / X[1], {0}),  # x / infinity is 0
        (casadi.sin(X[0]) + casadi.cos(X[1]) * X[2], {0, 1, 2}), (casadi.fmin(X[0], X[1]) + X[2], {2}),
        (casadi.if_else(X[0] < 1.0, X[1], X[2]), set()), (casadi.tanh(X[0]) + X[1], {1}), (2.0, set()),
    ],
)  # fmt: skip
def test_a_result_tells_of_inputs_only_where_they_must_spoil_it(result, reached):
    code = traced(result)
    known = reached_inputs(code.nodes)[code.results[0].node]
    assert {node.b for i, node in enumerate(code.nodes) if known >> i & 1} == reached


@pytest.mark.slow
@pytest.mark.parametrize("function", BATCHED)
def test_every_number_of_a_state_is_watched(function):
    arguments = len(BATCHED[function].states)
    states = np.tile(np.random.default_rng(5).uniform(-1, 1, (arguments, 1, 7)), (1, 7 * arguments * 3, 1))
    for row in range(states.shape[1]):
        which, kind = divmod(row, 3)
        states[which // 7, row, which % 7] = (np.nan, np.inf, -np.inf)[kind]
    batch = lwr_dyn.batch_dynamics(ARM)
    with kernels_by_python():
        form, kernel = batch.form(function), batch.kernel(function)
    for count in (states.shape[1], 1):
        out = form.empty(count)
        given = [address_and_step(rows, count) for rows in states[:, :count]]
        assert kernel.run(given, out.__array_interface__["data"][0], count) == count


def code_of(nodes, *results):
    return StraightLineCode(tuple(nodes), tuple(Value(*result) for result in results), Value(1, len(nodes) - 1))


SLOW = [pytest.param(x, marks=pytest.mark.slow) for x in (*FUNCTIONS, "kinetic_energy") if x != "gravity_vector"]


@pytest.mark.parametrize("function", ["gravity_vector", *SLOW])
@pytest.mark.parametrize("name", ["lwr4plus", "kr30ha"])
def test_the_bits_are_those_of_the_batch(function, name):
    arm = lwr_dyn.load(name)
    single = getattr(lwr_dyn.dynamics_of(arm, "kernels").ungated, function)
    rows = states(arm.n, 500)[: len(function_shape(function).states)]
    found = np.array([single(*state) for state in zip(*rows, strict=True)])
    assert np.array_equal(found, getattr(lwr_dyn.batch_dynamics(arm), function)(*rows))


def test_a_product_stands_in_the_sum_that_alone_needs_it():
    x, y, z = (Node("in", 0, j) for j in range(3))
    made = Node("*", 0, 1), Node("-", 3, 2), Node("-", 2, 3), Node("*", 0, 2), Node("-", 2, 6), Node("const", 0.0)
    code = code_of([x, y, z, *made], (1, 4), (1, 5), (-1, 7))
    assert code.contraction() == {7: 6}  # node 3 has two uses
    text = scalar_function("f", code, 1)
    assert text.count("llvm.fma") == 1
    assert text.count("fmul") == 1
    assert "fneg double %v0" in text  # z - x z = (-x) z + z

    x, y = (Node("in", 0, j) for j in range(2))
    code = code_of([x, y, Node("*", 0, 1), Node("+", 1, 2), Node("const", 0.0)], (1, 2), (1, 3))
    assert code.contraction() == {}  # a result is not taken in
    assert code.operations_after_contraction() == code.operations == 2


def test_without_the_instruction_there_are_two(monkeypatch):
    monkeypatch.setattr(scalar_code, "fuses", lambda: False)
    text = body_text(kernel_spec(lwr_dyn.load("lwr4plus")), "gravity_vector")
    assert "llvm.fma" not in text
    assert "fmul" in text


def test_the_flag_is_returned_with_its_sign():
    code = StraightLineCode((Node("in", 0, 0),), (Value(1, 0),), Value(-1, 0))
    *_, flag, last, end = scalar_function("f", code, 1).splitlines()
    assert (flag, last, end) == ("  %flag = fneg double %v0", "  ret double %flag", "}")


def test_numbers_are_written_bit_for_bit():
    assert [number(1.0), number(-0.0)] == ["0x3FF0000000000000", "0x8000000000000000"]


def test_an_operation_that_no_function_of_a_state_has_is_refused():
    nodes = [Node("in", 0, 0), Node("2^", 0, 0), Node("const", 0.0)]
    with pytest.raises(NotImplementedError, match=r"2\^"):
        scalar_function("f", code_of(nodes, (1, 1)), 1)
