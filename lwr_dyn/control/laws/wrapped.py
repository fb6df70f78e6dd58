"""What is put around a controller: it adds to the torques, and offers what the inner controller offers."""

from collections.abc import Iterator
from typing import Any

from lwr_dyn.control.protocol import Controller, describe
from lwr_dyn.foundation.arrays import Array

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
