"""The engine "kernels": generated code for single states and for batches, behind the same gate as the other engines.

A function of single states is compiled when it is first asked for; what it does not take goes to the gate, which also
judges batches. A batch of float64 goes to its kernel at once, which finds itself what is not finite.
"""

from collections.abc import Callable
from functools import partial, wraps
from types import SimpleNamespace
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.batch import BatchDynamics, batch_dynamics, wrap_angles
from lwr_dyn.codegen.kernels.held_step import held_step
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec, function_shape
from lwr_dyn.codegen.kernels.single_state import Call, Signature, single_call
from lwr_dyn.dynamics.protocol import FUNCTIONS, Dynamics, Gated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.simulation.integrators import BoundedStep


def single_function(spec: KernelSpec, function: str, behind: Call) -> Call:
    """A function of a spec without inputs, of single states (n,) each, at C level; the rest goes to `behind`.

    It gives the bits of the batch's kernel.
    """
    shape = function_shape(function)
    names = ", ".join(shape.states)
    about = getattr(getattr(Dynamics, function, None), "__doc__", None) or shape.formula
    signature = Signature(((spec.n,),) * len(shape.states), shape.result(spec.n))
    doc = f"{function}({names}, /)\n--\n\n{about}"
    return single_call(function, signature, [spec.digest(function)], lambda: body_text(spec, function), behind, doc)


def body_text(spec: KernelSpec, function: str, name: str = "body") -> str:
    """The function as text of LLVM's language."""
    from lwr_dyn.codegen.kernels.kernel_source import function_code
    from lwr_dyn.codegen.kernels.scalar_code import scalar_function

    return scalar_function(name, function_code(spec, function), len(function_shape(function).states))


class SingleStates:
    """The functions of single states (n,), nothing checked, for loops; a state that is not finite gives NaN."""

    def __init__(self, batch: BatchDynamics) -> None:
        self.batch, self.rotors = batch, batch.spec.rotors

    def __getattr__(self, function: str) -> Any:
        if function not in (*FUNCTIONS, "kinetic_energy"):
            raise AttributeError(function)
        made = single_function(self.batch.spec, function, partial(_unchecked, self.batch, function))
        setattr(self, function, made)
        return made

    def __reduce__(self) -> tuple[type["SingleStates"], tuple[BatchDynamics]]:
        return SingleStates, (self.batch,)

    def held_step(self, h: float, substeps: int, bounds: tuple[Array, Array]) -> BoundedStep | None:
        """RK4 over h [s] under a held torque, without friction; None where there are no calls at C level."""
        spec = self.batch.spec
        parts, text = [spec.digest("forward_dynamics")], partial(body_text, spec, "forward_dynamics", "forward")
        return held_step(spec.n, parts, text, self.forward_dynamics, h, substeps, bounds)

    def mechanical_energy(self, q: Any, dq: Any) -> Any:
        """Kinetic plus potential energy [J]."""
        return self.kinetic_energy(q, dq) + self.potential_energy(q)


class KernelEngine:
    """The engine of an arm; implements the `Dynamics` protocol."""

    name = "kernels"
    mass_matrix: Callable[..., Any]
    coriolis_matrix: Callable[..., Any]
    gravity_vector: Callable[..., Any]
    bias_torque: Callable[..., Any]
    inverse_dynamics: Callable[..., Any]
    forward_dynamics: Callable[..., Any]
    potential_energy: Callable[..., Any]

    def __init__(self, arm: Arm, rotors: str = "armature") -> None:
        batch = batch_dynamics(arm, rotors=rotors)
        self.n, self.maker, self.ungated = arm.n, (kernel_engine, (arm, rotors)), SingleStates(batch)
        single = SimpleNamespace(**{function: partial(_unchecked, batch, function) for function in FUNCTIONS})
        checked = SimpleNamespace(**{function: partial(self._checked, function) for function in FUNCTIONS})
        self._batch, self._gated = batch, Gated(self.name, arm.n, single, checked)

    def __getattr__(self, function: str) -> Any:
        if function not in FUNCTIONS:
            raise AttributeError(function)
        behind = _unread(self._batch, function, getattr(self._gated, function))
        made = single_function(self._batch.spec, function, behind)
        made = made if function_shape(function).result(self.n) else _of_numpy(made)
        setattr(self, function, made)
        return made

    def _checked(self, function: str, *states: Array) -> Any:
        """A function of states (..., n) that the gate has judged."""
        if states[0].ndim == 1:
            return getattr(self.ungated, function)(*(np.require(x, requirements=("C", "A")) for x in states))
        return _over_rows(getattr(self._batch, function), *states)

    def __reduce__(self) -> tuple[Call, tuple[Any, ...]]:
        return self.maker

    def __repr__(self) -> str:
        return repr(self._gated)


def kernel_engine(arm: Arm, rotors: str = "armature") -> KernelEngine:
    """The engine "kernels": its code is compiled when first used. Errors are those of `batch_dynamics`."""
    return KernelEngine(arm, rotors)


def _of_numpy(call: Call) -> Call:
    """`call` with a number of NumPy in place of a float of Python, as the other engines give it."""

    @wraps(call)
    def number(*states: Any) -> Any:
        found = call(*states)
        return np.float64(found) if type(found) is float else found

    return number


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


def _over_rows(function: Any, *states: Array) -> Array:
    """Call a function of rows (k, n) with states (..., n)."""
    *batch, n = states[0].shape
    out: Array = function(*(x.reshape(-1, n) for x in states))
    return out.reshape((*batch, *out.shape[1:]))


def _unchecked(batch: BatchDynamics, function: str, *state: Any) -> Any:
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
