"""Inverse dynamics by the same recursion elsewhere: NumPy, JAX and CasADi against the generated kernel."""

from __future__ import annotations

import operator
import os
import subprocess
import tempfile

import numpy as np

import lwr_dyn
from benchmarks.kernel_peers import relative_difference
from benchmarks.timing import Call, head, installed, paired, row
from lwr_dyn.checks.arm.model_laws import random_states
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.recursion import inverse_dynamics
from lwr_dyn.model.arm import Arm


def other_peers(arm: Arm, count: int, pairs: int) -> None:
    """Inverse dynamics by the same recursion in NumPy, in JAX (jitted, batched), and as CasADi's compiled map."""
    batch, states = lwr_dyn.batch_dynamics(arm), random_states(arm, count, seed=3)
    x, out = (states.q, states.dq, states.ddq), np.empty((count, arm.n))
    ours: Call = lambda: batch.inverse_dynamics(*x, out=out)  # noqa: E731
    recursion = Recursion.of(arm.chain)
    head(f"{arm.name}: inverse dynamics of {count} states, one thread, the same recursion elsewhere")
    peers: dict[str, Call] = {"NumPy, batched": lambda: recursion.inverse_dynamics(*x)}
    if installed("jax"):
        peers["JAX, jit and vmap"] = jax_call(recursion, x)
    if installed("casadi"):
        peers["CasADi, map of compiled C"] = casadi_call(arm, x)
    for name, theirs in peers.items():
        result = paired(ours, theirs, pairs, 1)
        row(
            "inverse_dynamics",
            name,
            result,
            f"{1 / result[2]:.0f} times faster, {result[1] / count * 1e9:.0f} ns a state",
        )


def jax_call(recursion: Recursion, x: tuple[np.ndarray, ...]) -> Call:
    """The recursion jitted over a batch, on arrays already on the device."""
    import jax

    jax.config.update("jax_enable_x64", True)
    numbers = jax.numpy

    def one(*state: object) -> object:
        given = [[JaxNumber(v[i]) for i in range(len(recursion.links))] for v in state]
        torque = inverse_dynamics(recursion.links, recursion.gravity, *given)
        return numbers.stack([getattr(t, "value", t) for t in torque])

    arrays = [numbers.asarray(a) for a in x]
    compiled = jax.jit(jax.vmap(one))
    assert relative_difference(np.asarray(compiled(*arrays)), recursion.inverse_dynamics(*x)) < 1e-12
    return lambda: compiled(*arrays).block_until_ready()


class JaxNumber:
    """A traced number of JAX whose sine and cosine NumPy finds."""

    def __init__(self, value: object) -> None:
        self.value = value

    def _with(self, other: object, name: str) -> JaxNumber:
        return JaxNumber(getattr(operator, name)(self.value, getattr(other, "value", other)))

    def __add__(self, other: object) -> JaxNumber:
        return self._with(other, "add")

    def __sub__(self, other: object) -> JaxNumber:
        return self._with(other, "sub")

    def __mul__(self, other: object) -> JaxNumber:
        return self._with(other, "mul")

    def __neg__(self) -> JaxNumber:
        return JaxNumber(-self.value)

    def __rsub__(self, other: object) -> JaxNumber:
        return -self + other

    __radd__, __rmul__ = __add__, __mul__

    def cos(self) -> JaxNumber:
        """For numpy.cos."""
        from jax import numpy

        return JaxNumber(numpy.cos(self.value))

    def sin(self) -> JaxNumber:
        """For numpy.sin."""
        from jax import numpy

        return JaxNumber(numpy.sin(self.value))


def casadi_call(arm: Arm, x: tuple[np.ndarray, ...]) -> Call:
    """CasADi's own C code for one state, compiled with -O3, mapped over the batch in memory it owns."""
    import casadi

    from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec
    from lwr_dyn.codegen.kernels.symbolic_functions import symbolic_function

    function = symbolic_function(kernel_spec(arm), "inverse_dynamics")
    folder = tempfile.mkdtemp()
    before = os.getcwd()
    os.chdir(folder)
    try:
        name = function.generate("inverse.c")
        flags = ["-O3", "-march=native", "-ffast-math", "-fPIC", "-shared"]
        subprocess.run(["cc", *flags, name, "-o", "inverse.so", "-lm"], check=True)
        mapped = casadi.external("inverse_dynamics", os.path.join(folder, "inverse.so")).map(len(x[0]))
    finally:
        os.chdir(before)
    buffer, evaluate = mapped.buffer()
    arguments, out = [np.ascontiguousarray(a) for a in x], np.zeros((len(x[0]), arm.n))  # its columns are our rows
    for i, a in enumerate(arguments):
        buffer.set_arg(i, memoryview(a))
    buffer.set_res(0, memoryview(out))
    evaluate()
    assert relative_difference(out, Recursion.of(arm.chain).inverse_dynamics(*x)) < 1e-12
    buffers = (arguments, out, buffer)
    return lambda: evaluate() if buffers else None  # keeps the memory alive
