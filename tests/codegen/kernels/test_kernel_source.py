"""The generated source: plain Python that computes what the machine code computes."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.batch import address_and_step
from lwr_dyn.codegen.kernels.kernel import kernel_of
from lwr_dyn.codegen.kernels.kernel_source import generate
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS, INPUTS, kernel_spec, parameter_shape
from lwr_dyn.dynamics import protocol
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
