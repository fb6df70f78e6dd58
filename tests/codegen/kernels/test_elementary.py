"""Choices, exponential, tanh and logarithm in straight-line code: machine code against NumPy."""

import casadi
import numpy as np
import pytest

from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel_source import placed_lines
from lwr_dyn.codegen.kernels.loop_code import KernelLoop, LaneBody
from lwr_dyn.codegen.kernels.machine_code import load
from lwr_dyn.codegen.kernels.straight_line import straight_line_code
from lwr_dyn.kinematics.closed_forms.text_parser import parsed

LANES = 8
X, Y = casadi.SX.sym("x"), casadi.SX.sym("y")
FUNCTIONS = (
    casadi.fmin(X, Y), casadi.fmax(X, Y), casadi.fmin(-X, Y), casadi.fmax(X, -Y), casadi.fabs(X - Y),
    casadi.if_else(X < Y, X, -Y), casadi.if_else(X <= 0, Y, casadi.sqrt(X)), casadi.remainder(X, 1),
    casadi.exp(X), casadi.tanh(X), casadi.log(casadi.fabs(X)), casadi.tanh(-X), casadi.log(Y * Y + 1e-300),
)  # fmt: skip


@pytest.fixture(scope="module")
def computed():
    """Rows of (x, y) -> rows of all functions, by one kernel."""
    code = straight_line_code(casadi.Function("f", [X, Y], [casadi.vertcat(*FUNCTIONS)]), sincos("float64"), False)
    lines = placed_lines(code, {("in", 0, 0): 0, ("in", 1, 0): 1}, range(2, 3 + len(FUNCTIONS)), LANES)
    size = (3 + len(FUNCTIONS)) * LANES
    body = "\n".join(lines)
    loop = KernelLoop(
        parsed("int once(double *out, double *b, int start, int stop)\n{\n    body(b);\n    return 0;\n}\n", {}),
        "once",
        (LaneBody("body", f"def body(b):\n    for k in range({LANES}):\n{body}\n"),),
    )
    kernel = load(loop.machine_code(), "kernel", inputs=0)

    def run(x, y):
        memory = np.zeros(size + 8)
        first = -memory.__array_interface__["data"][0] // 8 % 8
        b = memory[first : first + size]
        b[:LANES], b[LANES : 2 * LANES] = x, y
        kernel.call(0, b.__array_interface__["data"][0], 0, 0)
        return b.reshape(-1, LANES)[3:]

    return run


def expected(x, y):
    with np.errstate(all="ignore"):
        return np.array([
            np.minimum(x, y), np.maximum(x, y), np.minimum(-x, y), np.maximum(x, -y), np.abs(x - y),
            np.where(x < y, x, -y), np.where(x <= 0.0, y, np.sqrt(x)), x - np.round(x), np.exp(x), np.tanh(x),
            np.log(np.abs(x)), np.tanh(-x), np.log(y * y + 1e-300),
        ])  # fmt: skip


@pytest.mark.parametrize("size", [1e-12, 1e-3, 0.3, 1.0, 20.0, 600.0])
def test_the_operations_are_those_of_numpy(computed, size):
    rng = np.random.default_rng(0)
    for _ in range(50):
        x, y = rng.uniform(-size, size, (2, LANES))
        found, known = computed(x, y), expected(x, y)
        scale = np.where(np.isfinite(known), np.maximum(np.abs(known), 1e-300), 1.0)
        error = np.abs(np.where(found == known, 0.0, found - known)) / scale
        error[[10, 12]] *= np.minimum(np.abs(known[[10, 12]]), 1.0)  # the logarithm near 1: by its last digit
        assert error.max() < 5e-16


def test_a_nan_stays_in_its_lane_and_in_the_first_argument_of_a_choice(computed):
    x, y = np.full(LANES, 2.0), np.full(LANES, 3.0)
    x[3] = np.nan
    found = computed(x, y)
    clean = computed(np.full(LANES, 2.0), y)
    assert np.isnan(found[[0, 1, 2, 3, 4, 8, 9], 3]).all()
    others = np.arange(LANES) != 3
    assert (found[:, others] == clean[:, others]).all()


def test_large_arguments_neither_overflow_nor_lose_the_sign(computed):
    found = computed(np.full(LANES, 1e6), np.full(LANES, 1.0))
    assert np.isfinite(found[8]).all()
    assert (found[[9, 11]] == [[1.0], [-1.0]]).all()


def test_an_operation_that_is_not_known_is_refused():
    function = casadi.Function("f", [X], [casadi.atan(X)])
    with pytest.raises(NotImplementedError):
        straight_line_code(function, sincos("float64"))
    with pytest.raises(NotImplementedError):
        straight_line_code(casadi.Function("f", [X], [casadi.remainder(X, 2)]), sincos("float64"))
