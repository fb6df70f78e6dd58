"""The interface of a controller: it is called with the state and the reference, and returns torques.

A plain function `f(t, q, dq, q_ref, dq_ref, ddq_ref) -> tau` is a controller. A controller with memory has `reset`; one
that may also run continuously gives its memory a derivative (`WithMemory`), which an integrator carries. What stands
around a controller (`Wrapped`) adds to the torques, and offers what the inner controller offers.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import exp, isfinite, pi
from typing import Annotated, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, read_only, real_array
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.foundation.registry import Option

VelocityError = Annotated[bool, Option(bool, "Kd on dq_ref - dq, not the paper's -dq.")]


class Controller(Protocol):
    """A controller; it may also have `reset()`, and `name`, `label` and `parameters` (see `describe`).

    `follows_reference` False says of a law that it looks at no reference, so that its error says nothing.
    `signals`, a mapping of names to arrays (m,), is what it tells of itself after each call: `Run.signals` keeps it."""

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array, /) -> Array:
        """Torques tau (n,) [N m] at time t [s], from measured q, dq and the reference.

        Copy the arrays if you keep them: the loop reuses them.
        """


@runtime_checkable
class WithMemory(Protocol):
    """A controller whose memory is a vector with a derivative."""

    @property
    def memory_size(self) -> int:
        """Length m of the memory; it starts at zero."""

    def torque_and_rate(
        self, memory: Array, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array
    ) -> tuple[Array, Array]:
        """Torques (n,) and the derivative of the memory (m,) [per s]."""


@dataclass(slots=True, eq=False)
class JointReadings:
    """What the sensors of all joints read at a sample, (n,) each; on rigid joints theta is q. Copy what you keep."""

    theta: Array  # motor side, seen at the joint [rad or m]
    dtheta: Array
    q: Array  # link side [rad or m]
    dq: Array
    torque: Array
    """Of the gear on the link [N m]; on rigid joints the torque of the motor that was last applied, 0 at first."""


@runtime_checkable
class WithJointSensors(Protocol):
    """A controller that reads both sides of the gears, or joint torques: `sense` is called before each call.

    Sampled runs only. A controller that wraps another hands the readings on.
    """

    def sense(self, readings: JointReadings, /) -> None:
        """Take the readings of this sample."""


def reset(controller: Controller) -> None:
    """Clears a controller's memory before a run; does nothing for a controller without `reset`."""
    own_reset = getattr(controller, "reset", None)
    if own_reset is not None:
        own_reset()


def label_of(controller: Any) -> str:
    """The controller and its variant in words, such as "PD + gravity, damping on dq": the one name it is shown by.

    A controller with variants spells the variant out in `label`; others are shown by their name. Two controllers of
    this package that act differently on the same gains have different labels.
    """
    return str(getattr(controller, "label", _name_of(controller)))


def describe(controller: Any) -> dict[str, Any]:
    """Name, label and parameters of a controller, for a run's meta.

    >>> describe(lambda t, q, dq, q_ref, dq_ref, ddq_ref: -dq)
    {'name': 'own controller', 'label': 'own controller', 'parameters': {}}
    """
    parameters: Mapping[str, Any] = getattr(controller, "parameters", {})
    return {"name": _name_of(controller), "label": label_of(controller), "parameters": dict(parameters)}


UNNAMED, LAMBDA = "own controller", "<lambda>"
"""What a controller that is a lambda is called, and what Python calls it."""


def _name_of(controller: Any) -> str:
    name = str(getattr(controller, "name", getattr(controller, "__name__", type(controller).__name__)))
    return UNNAMED if name == LAMBDA else name


def damping_words(velocity_error: bool) -> str:
    """What Kd acts on, in words: the speed of the joint, or of its error."""
    return "damping on dq_ref - dq" if velocity_error else "damping on dq"


def saturate(tau: Any, effort: Any, out: Array | None = None) -> Any:
    """The torque that motors with the limits `effort` (n,) can give, (n,) [N m], also of columns of symbols.

    An array is written into `out` if given.

    >>> saturate(np.array([3.0, -9.0]), np.array([5.0, 4.0]))
    array([ 3., -4.])
    """
    if hasattr(tau, "fmin"):  # symbols, which have no place to be written to
        return tau.fmin(effort).fmax(-effort)
    within: Array = np.maximum(np.minimum(tau, effort, out=out), -effort, out=out)
    return within


def saturating(effort: Array) -> Callable[[Array, Array], None]:
    """`saturate` of one plant, into an array, with its limits looked at once: for loops."""
    lower, minimum, maximum = -effort, np.minimum, np.maximum

    def cut(tau: Array, out: Array) -> None:
        maximum(minimum(tau, effort, out=out), lower, out=out)

    return cut


def joint_torque(name: str, tau: object, n: int) -> Array:
    """A torque as a float64 array (n,); raises `ShapeError` for text or another shape."""
    allowed = f"{n} numbers, one a joint"
    try:
        array = np.asarray(tau, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(name, "not an array of numbers", allowed) from None
    if array.shape != (n,):
        raise ShapeError(name, f"shape {array.shape}", allowed)
    return array


def positive_gains(name: str, value: ArrayLike, n: int) -> Array:
    """Gains as a read-only (n,) array; a single number is for all joints.

    Raises
    ------
    ShapeError
        Not one number and not n of them, or not finite.
    OptionError
        A gain that is not positive.

    >>> positive_gains("Kp", 2500.0, 2)
    array([2500., 2500.])
    """
    array = real_array(name, value)
    if array.shape not in ((), (n,)):
        raise ShapeError(name, f"shape {array.shape}", f"one number, or shape ({n},)")
    if not (array > 0.0).all():
        raise OptionError(name, array.tolist(), "numbers above 0")
    return read_only(np.broadcast_to(array, (n,)))


def filter_pole(cutoff_hz: float, rate: float) -> float:
    """Pole exp(-2 pi f_c T) of the first-order low-pass of measured velocities, with cut-off and rate 1/T [Hz].

    Raises `OptionError` for a frequency that is not positive, or a cut-off not below half the rate.
    """
    if not (isfinite(rate) and rate > 0.0):
        raise OptionError("rate", rate, "a number above 0, in Hz")
    if not (isfinite(cutoff_hz) and 0.0 < cutoff_hz < rate / 2):
        raise OptionError("cut-off of the velocity filter", cutoff_hz, f"above 0 and below {rate / 2:g} Hz")
    return exp(-2.0 * pi * cutoff_hz / rate)


OFFERED = ("reset", "sense", "linear_feedback", "memory_size")
"""Parts of the interfaces of a controller that a wrapper passes on as they stand, where the inner one has them."""


def layers_of(controller: Controller) -> Iterator[Controller]:
    """The controller, and what its wrappers stand around, from the outermost to the law."""
    yield controller
    while isinstance(controller, Wrapped):
        controller = controller.inner
        yield controller


class Wrapped:
    """A controller around `inner`: tau = inner's + `added`, with the memory, sensors and linear form of the inner one.

    `word` stands behind the inner controller's name, `label_word` behind its label.
    """

    word, label_word = "", ""

    def __init__(self, inner: Controller) -> None:
        self.inner = inner
        for part in OFFERED:  # set here, not by __getattr__, which isinstance with a protocol does not ask
            if hasattr(inner, part):
                setattr(self, part, getattr(inner, part))
        if hasattr(inner, "torque_and_rate"):
            self.torque_and_rate = self._torque_and_rate

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or "inner" not in vars(self):
            raise AttributeError(name)
        return getattr(self.inner, name)

    @property
    def name(self) -> str:
        """The inner controller's name with the wrapper's."""
        return f"{describe(self.inner)['name']}+{self.word}"

    @property
    def label(self) -> str:
        """The inner controller and its variant, and the wrapper's."""
        return f"{describe(self.inner)['label']}, {self.label_word}"

    @property
    def parameters(self) -> dict[str, Any]:
        """The inner controller's and the wrapper's own, as JSON values."""
        return {**describe(self.inner)["parameters"], **self.own_parameters}

    @property
    def own_parameters(self) -> dict[str, Any]:
        """What makes this wrapper, as JSON values."""
        return {}

    def added(self, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """The torque (n,) [N m] beside the inner controller's."""
        raise NotImplementedError

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        return self.inner(t, q, dq, q_ref, dq_ref, ddq_ref) + self.added(q, dq, q_ref, dq_ref, ddq_ref)

    def _torque_and_rate(self, memory: Array, q: Array, dq: Array, *reference: Array) -> tuple[Array, Array]:
        tau, rate = self.inner.torque_and_rate(memory, q, dq, *reference)  # type: ignore[attr-defined]
        return tau + self.added(q, dq, *reference), rate
