import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import scalar_code
from lwr_dyn.codegen.kernels.engine import body_text
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec
from lwr_dyn.codegen.kernels.scalar_code import number, scalar_function
from lwr_dyn.codegen.kernels.straight_line import Node, StraightLineCode, Value
from tests.codegen.kernels.evaluate import states

FUNCTIONS = (
    "mass_matrix", "coriolis_matrix", "gravity_vector", "bias_torque", "inverse_dynamics", "forward_dynamics",
    "potential_energy", "kinetic_energy",
)  # fmt: skip


def code_of(nodes, *results):
    return StraightLineCode(tuple(nodes), tuple(Value(*result) for result in results), Value(1, len(nodes) - 1))


@pytest.mark.parametrize(
    "function",
    ["gravity_vector", *(pytest.param(x, marks=pytest.mark.slow) for x in FUNCTIONS if x != "gravity_vector")],
)
def test_the_bits_are_those_of_the_batch(function):
    for name in ("lwr4plus", "kr30ha"):
        arm = lwr_dyn.load(name)
        batch, engine = lwr_dyn.batch_dynamics(arm), lwr_dyn.dynamics_of(arm, "kernels")
        single = getattr(engine.ungated, function)
        rows = states(arm.n, 500)[: 1 if function in ("mass_matrix", "gravity_vector", "potential_energy") else 3]
        rows = rows[:2] if function in ("coriolis_matrix", "bias_torque", "kinetic_energy") else rows
        found = np.array([single(*state) for state in zip(*rows, strict=True)])
        assert np.array_equal(found, getattr(batch, function)(*rows))


def test_a_product_stands_in_the_sum_that_alone_needs_it():
    x, y, z = (Node("in", 0, j) for j in range(3))
    nodes = [
        x,
        y,
        z,
        Node("*", 0, 1),
        Node("-", 3, 2),
        Node("-", 2, 3),
        Node("*", 0, 2),
        Node("-", 2, 6),
        Node("const", 0.0),
    ]
    code = code_of(nodes, (1, 4), (1, 5), (-1, 7))
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
