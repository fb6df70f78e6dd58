"""The generated source is Python that computes what the machine code does; choices and exponentials beside NumPy."""

import casadi
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.batch import address_and_step
from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel import kernel_of
from lwr_dyn.codegen.kernels.kernel_source import generate, placed_lines
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS, INPUTS, kernel_spec, parameter_shape
from lwr_dyn.codegen.kernels.loop_code import KernelLoop, LaneBody
from lwr_dyn.codegen.kernels.machine_code import load
from lwr_dyn.codegen.kernels.straight_line import straight_line_code
from lwr_dyn.dynamics import protocol
from lwr_dyn.kinematics.closed_forms.text_parser import parsed
from tests.codegen.kernels.evaluate import states
from tests.codegen.kernels.plain_kernel import PlainKernel
from tests.codegen.rollouts.beside import first_joints
from tests.tolerances import EXACT

ARM, FOUR = lwr_dyn.load("lwr4plus"), first_joints(4)
COUNT = 60
CASES = {
    **{function: (function, {}) for function in FUNCTIONS},
    "all inputs": ("inverse_dynamics", {"inputs": INPUTS}),
    "friction": ("inverse_dynamics", {"friction": "arm"}),
    "float32": ("inverse_dynamics", {"dtype": "float32"}),
    "float32, quotients": ("forward_dynamics", {"dtype": "float32"}),
}
WHOLE = {function: ARM for function in protocol.FUNCTIONS}
"""Of seven joints are those that other tests compile as well; of four, which compile much faster, all others."""
SINGLE = 2e-5
"""Relative, float32: its rounding of 6e-8 through some hundred operations and, forward, the condition of B."""


def rows_of(spec, function):
    """Joint vectors, and a set of each input for every state; three states are not finite or too far away."""
    x = states(spec.n, COUNT)[: len(FUNCTIONS[function].states)]
    x[0, 3, 2], x[-1, 11, -1], x[0, 20, 1] = np.nan, np.inf, 1e9
    rng = np.random.default_rng(1)
    widths = [int(np.prod(parameter_shape(name, spec.n))) for name in spec.parameters_of(function)]
    return [row.astype(spec.dtype) for row in (*x, *(rng.uniform(-1, 1, (COUNT, width)) for width in widths))]


def run(kernel, rows, repeated=()):
    """Results (COUNT, width), and how many are invalid; the first row of those `repeated` is every state's."""
    out = np.full((COUNT, kernel.interface.width), 77.0, dtype=kernel.dtype)
    given = [address_and_step(x[:1] if i in repeated else x, COUNT) for i, x in enumerate(rows)]
    invalid = kernel.run(given, out.__array_interface__["data"][0], COUNT)
    return out, invalid


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_body_is_python_that_gives_the_kernels_numbers(case):
    function, options = CASES[case]
    spec = kernel_spec(WHOLE.get(case, FOUR), **options)
    rows = rows_of(spec, function)
    for repeated in ((), (len(rows) - 1,)):
        (result, invalid), (expected, known) = (
            run(kernel, rows, repeated) for kernel in (kernel_of(spec, function), PlainKernel(spec, function))
        )
        assert invalid == known >= (0 if repeated else 3)
        valid = ~np.isin(np.arange(COUNT), (3, 11, 20))
        bound = EXACT if spec.dtype == "float64" else SINGLE
        assert np.abs(result[valid] - expected[valid]).max() < bound * max(1.0, np.abs(expected[valid]).max())


def test_the_operations_stay_few():
    """Fused, with seven sines and cosines of 35 each: 346, 187 and 622 beside them were the aim."""
    result = {
        name: generate(kernel_spec(ARM), name).interface.fused
        for name in ("inverse_dynamics", "mass_matrix", "forward_dynamics")
    }
    assert result["inverse_dynamics"] < 346 + 7 * 35
    assert result["mass_matrix"] < 187 + 6 * 35
    assert result["forward_dynamics"] < 622 + 7 * 35


LANES = 8
X, Y = casadi.SX.sym("x"), casadi.SX.sym("y")
ELEMENTARY = (
    casadi.fmin(X, Y), casadi.fmax(X, Y), casadi.fmin(-X, Y), casadi.fmax(X, -Y), casadi.fabs(X - Y),
    casadi.if_else(X < Y, X, -Y), casadi.if_else(X <= 0, Y, casadi.sqrt(X)), casadi.remainder(X, 1),
    casadi.exp(X), casadi.tanh(X), casadi.log(casadi.fabs(X)), casadi.tanh(-X), casadi.log(Y * Y + 1e-300),
)  # fmt: skip


@pytest.fixture(scope="module")
def computed():
    """Rows of (x, y) -> rows of all functions, by one kernel."""
    code = straight_line_code(casadi.Function("f", [X, Y], [casadi.vertcat(*ELEMENTARY)]), sincos("float64"), False)
    lines = placed_lines(code, {("in", 0, 0): 0, ("in", 1, 0): 1}, range(2, 3 + len(ELEMENTARY)), LANES)
    size = (3 + len(ELEMENTARY)) * LANES
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
