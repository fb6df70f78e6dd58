"""The engine "kernels": generated code behind the same gate and the same protocol as the other engines."""

from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.batch import BatchDynamics, batch_dynamics
from lwr_dyn.codegen.kernels.batch_arguments import wrap_angles
from lwr_dyn.codegen.kernels.kernel_spec import function_shape
from lwr_dyn.dynamics.gate import FUNCTIONS, Gated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm


def kernel_engine(arm: Arm, rotors: str = "armature") -> Gated[SimpleNamespace]:
    """The engine "kernels": its kernels are compiled when first used. Errors are those of `batch_dynamics`."""
    batch = batch_dynamics(arm, rotors=rotors)
    single = SimpleNamespace(**{function: partial(_single_state, batch, function) for function in FUNCTIONS})
    single.rotors = rotors
    single.mechanical_energy = partial(_mechanical_energy, batch)
    batched = SimpleNamespace(**{function: partial(_rows, getattr(batch, function)) for function in FUNCTIONS})
    engine = Gated("kernels", arm.n, single, batched)
    for function in FUNCTIONS:
        setattr(engine, function, _unread(batch, function, getattr(engine, function)))
    return engine


def _unread(batch: BatchDynamics, function: str, gated: Any) -> Any:
    """`gated`, but rows of float64 go to the kernel at once: it finds itself what is not finite, and `gated` says it.

    A pass over the arguments before and one over the results after it would take half as long as the kernel.
    """
    count, form = len(FUNCTIONS[function][0]), batch.form(function)

    def unread(*given: Any) -> Any:
        first = given[0] if given else None
        if type(first) is not np.ndarray or first.ndim < 2 or first.shape[-1] != batch.n or not first.size:
            return gated(*given)
        if len(given) != count or any(type(x) is not np.ndarray or x.shape != first.shape for x in given):
            return gated(*given)
        if any(x.dtype != np.float64 for x in given):
            return gated(*given)
        rows = [np.ascontiguousarray(x) for x in given]
        states = first.size // batch.n
        out = form.empty(states).reshape((*first.shape[:-1], *form.shape))
        places = [(x.__array_interface__["data"][0], batch.n) for x in rows]
        invalid = batch.kernel(function).run(places, out.__array_interface__["data"][0], states)
        return gated(*given) if invalid else out

    unread.__name__, unread.__doc__ = function, gated.__doc__
    return unread


def _rows(function: Any, *states: Array) -> Array:
    """Call a function of rows (k, n) with states (..., n)."""
    *batch, n = states[0].shape
    out: Array = function(*(x.reshape(-1, n) for x in states))
    return out.reshape((*batch, *out.shape[1:]))


def _single_state(batch: BatchDynamics, function: str, *state: Any) -> Any:
    """Call a kernel with a single state, (n,) each, unchecked: for loops."""
    kernel = batch.kernel(function)
    arrays = [np.ascontiguousarray(x, dtype=np.float64) for x in state]
    out = np.empty(function_shape(function).result(batch.n))
    place = out.__array_interface__["data"][0]
    if kernel.run([(x.__array_interface__["data"][0], 0) for x in arrays], place, 1):
        with np.errstate(invalid="ignore"):  # a state that is not finite gives NaN, as in the other engines
            arrays[0] = wrap_angles(batch.spec.chain, arrays[0])
        kernel.run([(x.__array_interface__["data"][0], 0) for x in arrays], place, 1)
    return out[()]


def _mechanical_energy(batch: BatchDynamics, q: Any, dq: Any) -> Any:
    """Kinetic plus potential energy [J] of a single state."""
    return _single_state(batch, "kinetic_energy", q, dq) + _single_state(batch, "potential_energy", q)
