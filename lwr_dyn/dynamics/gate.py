"""The shape gate around an engine: any arrays of numbers in, float64 arrays out, one clear error for everything else.

An engine of single states is called at once, and its arguments are checked only where the call fails or the first entry
of its result is not finite: a value that is not finite spreads outward with the motion and back with the force, so it
reaches the first joint.
"""

from collections.abc import Callable, Collection
from math import isfinite
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.dynamics.protocol import Dynamics, singular_joint
from lwr_dyn.foundation.arrays import Array, joint_array, same_batch
from lwr_dyn.foundation.errors import SingularMassError

Ungated = TypeVar("Ungated", covariant=True)
Call = Callable[..., Any]
FUNCTIONS = {
    "mass_matrix": (("q",), 2),
    "coriolis_matrix": (("q", "dq"), 2),
    "gravity_vector": (("q",), 1),
    "bias_torque": (("q", "dq"), 1),
    "inverse_dynamics": (("q", "dq", "ddq"), 1),
    "forward_dynamics": (("q", "dq", "tau"), 1),
    "potential_energy": (("q",), 0),
}
"""Each function's arguments, and the number of joint axes of its result."""


class Gated(Generic[Ungated]):
    """An engine behind the shape gate; implements the `Dynamics` protocol.

    Parameters
    ----------
    name : str
        Of the engine.
    n : int
        Number of joints.
    ungated : object
        Functions of single states (n,) that check nothing, for loops.
    batched : object, optional
        The same functions of whole batches (..., n); without them batches are computed state by state.
    slow : collection of str
        Functions of single states whose first entry may hide a value that is not finite: arguments are checked first.
    """

    __slots__ = (*FUNCTIONS, "n", "name", "ungated")

    mass_matrix: Callable[[ArrayLike], Array]
    coriolis_matrix: Callable[[ArrayLike, ArrayLike], Array]
    gravity_vector: Callable[[ArrayLike], Array]
    bias_torque: Callable[[ArrayLike, ArrayLike], Array]
    inverse_dynamics: Callable[[ArrayLike, ArrayLike, ArrayLike], Array]
    forward_dynamics: Callable[[ArrayLike, ArrayLike, ArrayLike], Array]
    potential_energy: Callable[[ArrayLike], Array]

    def __init__(self, name: str, n: int, ungated: Ungated, batched: Any = None, slow: Collection[str] = ()) -> None:
        self.name, self.n, self.ungated = name, n, ungated
        for function, (arguments, axes) in FUNCTIONS.items():
            single: Call = getattr(ungated, function)
            each = _one_by_one(single) if batched is None else getattr(batched, function)
            if function == "forward_dynamics":
                each = self._determined(each)
            gated = _checked(each, arguments, n, axes)
            if batched is None and axes and function not in slow:  # a result without axes is no array
                gated = _FAST[len(arguments)](single, gated, (n,), function == "mass_matrix")
            gated.__name__, gated.__doc__ = function, getattr(Dynamics, function).__doc__
            setattr(self, function, gated)

    def _determined(self, forward: Call) -> Call:
        """Forward dynamics that raises `SingularMassError` where the accelerations are not determined."""

        def determined(q: Array, dq: Array, tau: Array) -> Any:
            try:
                ddq = forward(q, dq, tau)
            except np.linalg.LinAlgError:
                ddq = np.array(np.nan)
            joint = None if np.isfinite(ddq).all() else singular_joint(self.mass_matrix(q).reshape(-1, self.n, self.n))
            if joint is not None:
                raise SingularMassError(joint + 1)
            return ddq

        return determined

    def __repr__(self) -> str:
        return f"<engine {self.name}, {self.n} joints>"


def _checked(each: Call, names: tuple[str, ...], n: int, axes: int) -> Call:
    """`each` of batches (..., n) with its arguments checked; a result that is constant gets all axes too."""

    def checked(*given: ArrayLike) -> Array:
        if len(given) != len(names):
            raise TypeError(f"{len(given)} arguments given; expected {', '.join(names)}")
        arrays = {name: joint_array(name, value, n) for name, value in zip(names, given, strict=True)}
        batch = same_batch(**arrays)
        shape = (*batch, *(n,) * axes)
        if 0 in batch:
            return np.empty(shape)
        result = np.asarray(each(*(_filled(array, (*batch, n)) for array in arrays.values())), dtype=np.float64)
        return _filled(result, shape)

    return checked


def _filled(array: Array, shape: tuple[int, ...]) -> Array:
    return array if array.shape == shape else np.array(np.broadcast_to(array, shape))


def _one_by_one(single: Call) -> Call:
    """A function of batches (..., n) from one of single states."""

    def each(*states: Array) -> Any:
        *batch, n = states[0].shape
        rows = [np.ascontiguousarray(x.reshape(-1, n)) for x in states]
        results = np.array([single(*row) for row in zip(*rows, strict=True)])
        return results.reshape((*batch, *results.shape[1:]))

    return each


def _of_q(single: Call, checked: Call, shape: tuple[int], first_joint_too: bool) -> Call:
    def of_q(q: Any, /) -> Any:
        try:
            if q.shape == shape:
                result = single(q)
                # no entry of B depends on the first joint
                if isfinite(result.item(0)) and (not first_joint_too or isfinite(q.item(0))):
                    return result
        except (AttributeError, TypeError):
            pass  # not arrays of numbers: `checked` says so
        return checked(q)

    return of_q


def _of_q_dq(single: Call, checked: Call, shape: tuple[int], _: bool) -> Call:
    def of_q_dq(q: Any, dq: Any, /) -> Any:
        try:
            if q.shape == dq.shape == shape:
                result = single(q, dq)
                if isfinite(result.item(0)):
                    return result
        except (AttributeError, TypeError):
            pass
        return checked(q, dq)

    return of_q_dq


def _of_q_dq_x(single: Call, checked: Call, shape: tuple[int], _: bool) -> Call:
    def of_q_dq_x(q: Any, dq: Any, x: Any, /) -> Any:
        try:
            if q.shape == dq.shape == x.shape == shape:
                result = single(q, dq, x)
                if isfinite(result.item(0)):
                    return result
        except (AttributeError, TypeError):
            pass
        return checked(q, dq, x)

    return of_q_dq_x


_FAST = {1: _of_q, 2: _of_q_dq, 3: _of_q_dq_x}
"""By the number of arguments: one function for any number of them would add 25 to 75 % to a call."""
