"""What an engine of rigid-body dynamics offers: `Dynamics` behind the shape gate, `UngatedDynamics` for loops.

The gate: any arrays of numbers in, float64 arrays out, one clear error for everything else. An engine of single states
is called at once, and its arguments are checked only where the call fails or the first entry of its result is not
finite: a value that is not finite spreads outward with the motion and back with the force, so it reaches the first
joint. Every engine passes the same identities and agreement tests.
"""

from collections.abc import Callable, Collection
from math import isfinite
from pickle import PicklingError
from typing import Any, Generic, Protocol, TypeVar, cast, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, joint_array, same_batch
from lwr_dyn.foundation.errors import SingularMassError


@runtime_checkable
class Dynamics(Protocol):
    """B(q) ddq + C(q, dq) dq + g(q) = tau, in SI units; batches are (..., n).

    Every method raises `ShapeError`: wrong last axis, batches that do not broadcast, a value that is not finite.
    """

    @property
    def n(self) -> int:
        """Number of joints."""

    def mass_matrix(self, q: ArrayLike, /) -> Array:
        """B(q), (..., n, n) [kg m^2 for turning joints], rotors included as `armature`."""

    def coriolis_matrix(self, q: ArrayLike, dq: ArrayLike, /) -> Array:
        """C(q, dq), (..., n, n), in Christoffel form: dB/dt = C + C^T (Siciliano eqs. 7.44, 7.45)."""

    def gravity_vector(self, q: ArrayLike, /) -> Array:
        """g(q), (..., n) [N m]: the torque that holds the arm at rest."""

    def bias_torque(self, q: ArrayLike, dq: ArrayLike, /) -> Array:
        """C(q, dq) dq + g(q), (..., n) [N m]."""

    def inverse_dynamics(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike, /) -> Array:
        """tau, (..., n) [N m]."""

    def forward_dynamics(self, q: ArrayLike, dq: ArrayLike, tau: ArrayLike, /) -> Array:
        """ddq, (..., n) [rad/s^2]."""

    def potential_energy(self, q: ArrayLike, /) -> Array:
        """U(q), (...) [J]; only differences have a meaning."""


class UngatedDynamics(Protocol):
    """The same functions without the shape gate: single states, float64 arrays (n,), nothing checked."""

    def mass_matrix(self, q: Any, /) -> Any:
        """B(q), (n, n)."""

    def coriolis_matrix(self, q: Any, dq: Any, /) -> Any:
        """C(q, dq), (n, n)."""

    def gravity_vector(self, q: Any, /) -> Any:
        """g(q), (n,)."""

    def bias_torque(self, q: Any, dq: Any, /) -> Any:
        """C(q, dq) dq + g(q), (n,)."""

    def inverse_dynamics(self, q: Any, dq: Any, ddq: Any, /) -> Any:
        """tau, (n,)."""

    def forward_dynamics(self, q: Any, dq: Any, tau: Any, /) -> Any:
        """ddq, (n,)."""

    def potential_energy(self, q: Any, /) -> Any:
        """U(q) [J]."""


def ungated(dynamics: Dynamics) -> UngatedDynamics:
    """The engine's functions without the gate; the engine itself where it has no attribute `ungated`."""
    return cast(UngatedDynamics, getattr(dynamics, "ungated", dynamics))


def mechanical_energy(dynamics: Dynamics, q: Array, dq: Array) -> Array:
    """Kinetic plus potential energy E = dq^T B(q) dq / 2 + U(q), (k,) [J], for k states (k, n).

    Calls the ungated `mechanical_energy(q, dq)` of single states where the engine has one.
    """
    single = getattr(ungated(dynamics), "mechanical_energy", None)
    if single is not None:
        return np.fromiter(map(single, q, dq), np.float64, len(q))
    B = dynamics.mass_matrix(q)
    return np.asarray(np.einsum("ki,kij,kj->k", dq, B, dq) / 2 + dynamics.potential_energy(q))


def mass_and_bias(dynamics: Dynamics, q: Array, dq: Array) -> tuple[Array, Array]:
    """B(q) (k, n, n) and C(q, dq) dq + g(q) (k, n) for k states (k, n).

    Calls the ungated `mass_and_bias(q, dq)` of batches where the engine has one. Raises `ShapeError`: a value that is
    not finite.
    """
    both = getattr(ungated(dynamics), "mass_and_bias", None)
    if both is None:
        return dynamics.mass_matrix(q), dynamics.bias_torque(q, dq)
    B, bias = both(joint_array("q", q, dynamics.n), joint_array("dq", dq, dynamics.n))
    return B, bias


def singular_joint(B: Array) -> int | None:
    """The joint (0-based) at which a mass matrix of the batch (k, n, n) has no inverse; None where all have one.

    Each matrix is scaled to a diagonal of ones, so that a light finger on a heavy base is no fault: its smallest
    eigenvalue is then at most `n` roundings, or an entry of the diagonal is not above 0, or one is not finite.
    """
    diagonal = np.diagonal(B, axis1=-2, axis2=-1)
    bad = ~((diagonal > 0.0) & np.isfinite(B).all(axis=-1))
    if bad.any():
        return int(np.argmax(bad.any(axis=0)))
    size = np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(B / (size[..., :, None] * size[..., None, :]))
    worst = int(np.argmin(values[:, 0]))
    if values[worst, 0] > B.shape[-1] * np.finfo(np.float64).eps:
        return None
    return int(np.argmax(np.abs(vectors[worst, :, 0])))


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
    """An engine with a name and n joints behind the shape gate; implements the `Dynamics` protocol.

    `ungated` has functions of single states (n,) that check nothing, for loops; `batched` the same functions of whole
    batches (..., n), without which batches are computed state by state. `slow` names functions of single states whose
    first entry may hide a value that is not finite: arguments are checked first. `maker`, a function and its arguments,
    makes the same engine again: what a pickle holds.
    """

    __slots__ = (*FUNCTIONS, "maker", "n", "name", "ungated")

    mass_matrix: Callable[[ArrayLike], Array]
    coriolis_matrix: Callable[[ArrayLike, ArrayLike], Array]
    gravity_vector: Callable[[ArrayLike], Array]
    bias_torque: Callable[[ArrayLike, ArrayLike], Array]
    inverse_dynamics: Callable[[ArrayLike, ArrayLike, ArrayLike], Array]
    forward_dynamics: Callable[[ArrayLike, ArrayLike, ArrayLike], Array]
    potential_energy: Callable[[ArrayLike], Array]

    def __init__(
        self,
        name: str,
        n: int,
        ungated: Ungated,
        batched: Any = None,
        slow: Collection[str] = (),
        maker: tuple[Call, tuple[Any, ...]] | None = None,
    ) -> None:
        self.name, self.n, self.ungated, self.maker = name, n, ungated, maker
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

    def __reduce__(self) -> tuple[Call, tuple[Any, ...]]:
        if self.maker is None:
            raise PicklingError(
                f"engine {self.name} does not say how it is made; lwr_dyn.dynamics_of makes one that does"
            )
        return self.maker

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
