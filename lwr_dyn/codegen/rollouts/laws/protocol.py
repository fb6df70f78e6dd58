"""What a kernel needs of a controller: its torque on symbols, its memory, and its gains as values of a run."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.codegen.rollouts.symbolic_model import SymbolicModel
from lwr_dyn.control.protocol import Controller
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm

Column = Any
"""A casadi.SX column."""
UNLIMITED = 1e300
"""[N m] Stands for a torque limit of infinity among the values of a law: 0 times it is 0, not NaN."""


def finite_limits(effort: ArrayLike) -> Array:
    """Torque limits (n,) [N m] with `UNLIMITED` for infinity."""
    return np.minimum(np.asarray(effort, dtype=np.float64), UNLIMITED)


@dataclass(frozen=True, slots=True, eq=False)
class LawInputs:
    """What a law is given at a sample, as columns: measured state, reference, memory and gains.

    `memory` (m,) is that of this sample; `parameters` holds a column for each name of `LawForm.parameters`, values in C
    order; `h` is the time between samples [s].
    """

    q: Column
    dq: Column
    q_ref: Column
    dq_ref: Column
    ddq_ref: Column
    memory: Column
    parameters: Mapping[str, Column]
    h: Any


class LawForm(Protocol):
    """A controller in the form that a kernel takes."""

    @property
    def name(self) -> str:
        """The controller's name, with its wrappers."""

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """Its gains: name -> shape of one run's values; all of them may differ from run to run."""

    @property
    def memory(self) -> int:
        """Numbers kept from sample to sample."""

    @property
    def digest(self) -> str:
        """Text of all else on which `torque` depends: variants and switches, not the values of the parameters.

        A change of the code of `torque` raises `rollout.step.GENERATOR`, so that kernels on disk are made again.
        """

    def values(self) -> Mapping[str, Array]:
        """The parameters of this controller, in the shapes of `parameters`."""

    def start(self) -> Array:
        """The memory (m,) at the first sample."""

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """The torque (n,) [N m], and the memory (m,) of the next sample; `model` is the arm as the law knows it."""

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """The controller that acts so on these values, with `arm` as the arm that it knows: for a run by `simulate`."""
