"""Straight-line code as a function of numbers: the bits of the batch, fused products, what it refuses."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import scalar_code
from lwr_dyn.codegen.kernels.engine import body_text
from lwr_dyn.codegen.kernels.kernel_spec import function_shape, kernel_spec
from lwr_dyn.codegen.kernels.scalar_code import number, scalar_function
from lwr_dyn.codegen.kernels.straight_line import Node, StraightLineCode, Value
from lwr_dyn.dynamics.protocol import FUNCTIONS
from tests.codegen.kernels.evaluate import states


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


def test_a_result_is_not_taken_in():
    x, y = (Node("in", 0, j) for j in range(2))
    code = code_of([x, y, Node("*", 0, 1), Node("+", 1, 2), Node("const", 0.0)], (1, 2), (1, 3))
    assert code.contraction() == {}
    assert code.operations_after_contraction() == code.operations == 2


def test_without_the_instruction_there_are_two(monkeypatch):
    monkeypatch.setattr(scalar_code, "fuses", lambda: False)
    text = body_text(kernel_spec(lwr_dyn.load("lwr4plus")), "gravity_vector")
    assert "llvm.fma" not in text
    assert "fmul" in text


def test_numbers_are_written_bit_for_bit():
    assert number(1.0) == "0x3FF0000000000000"
    assert number(-0.0) == "0x8000000000000000"


def test_an_operation_that_no_function_of_a_state_has_is_refused():
    nodes = [Node("in", 0, 0), Node("2^", 0, 0), Node("const", 0.0)]
    with pytest.raises(NotImplementedError, match=r"2\^"):
        scalar_function("f", code_of(nodes, (1, 1)), 1)
