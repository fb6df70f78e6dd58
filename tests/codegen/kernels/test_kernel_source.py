"""The generated source: plain Python that computes what the machine code computes."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_source import generate
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec
from tests.codegen.kernels.evaluate import states

ARM = lwr_dyn.load("lwr4plus")


def run_as_python(source, row):
    """The body over its buffer, by the interpreter."""
    text = source.text[source.text.index("def body(b, out, at):") : source.text.index("@cfunc")]
    names = {}
    exec(text, names)
    lanes, given = source.interface.lanes, sum(source.interface.widths)
    b, out = np.zeros(source.interface.buffer), np.full(lanes * source.interface.width + 1, 77.0)
    b[: given * lanes] = np.repeat(row, lanes)
    names["body"](b, out, 1)
    assert out[0] == 77.0
    return out[1:].reshape(lanes, -1)[0]


@pytest.mark.slow
@pytest.mark.parametrize("function", ["gravity_vector", "forward_dynamics", "potential_energy"])
def test_the_body_is_python_that_gives_the_kernels_numbers(function):
    source = generate(kernel_spec(ARM), function)
    x = states(7, 1)[: len(source.interface.inputs)]
    result = getattr(lwr_dyn.batch_dynamics(ARM), function)(*x)
    assert np.abs(run_as_python(source, x.ravel()) - result.ravel()).max() < 1e-12 * max(1.0, np.abs(result).max())


def test_the_operations_stay_few():
    """Fused, with seven sines and cosines of 35 each: 346, 187 and 622 beside them were the aim."""
    result = {
        name: generate(kernel_spec(ARM), name).interface.fused
        for name in ("inverse_dynamics", "mass_matrix", "forward_dynamics")
    }
    assert result["inverse_dynamics"] < 346 + 7 * 35
    assert result["mass_matrix"] < 187 + 6 * 35
    assert result["forward_dynamics"] < 622 + 7 * 35
