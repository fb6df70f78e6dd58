"""What can be emitted for an arm: each function with its arguments, units and result, and as a function on symbols."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lwr_dyn.codegen.kernel_spec import FUNCTIONS, KernelSpec, function_shape
from lwr_dyn.codegen.symbolic_functions import symbolic_function
from lwr_dyn.registry import Registry, Row

UNITS = {"q": "rad or m", "dq": "rad/s or m/s", "ddq": "rad/s^2 or m/s^2", "tau": "N m or N"}
"""Of joint vectors."""
RESULT_UNITS = {
    "inverse_dynamics": "N m or N", "forward_dynamics": "rad/s^2 or m/s^2", "mass_matrix": "kg m^2, kg m, kg",
    "coriolis_matrix": "N m s, N s", "bias_torque": "N m or N", "gravity_vector": "N m or N",
    "flange_pose": "m, row by row", "jacobian": "m or 1, row by row", "torque_regressor": "N m or N per SI unit",
    "kinetic_energy": "J", "potential_energy": "J",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Argument:
    """One input: so many numbers, in that unit."""

    name: str
    width: int
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class EmittedFunction:
    """A function of one arm, ready to be written in another language.

    `symbolic` has a column for each argument and one for the result, row by row where `shape` is that of a matrix.
    """

    name: str
    text: str
    """The result as a formula or in words."""
    arguments: tuple[Argument, ...]
    shape: tuple[int, ...]
    unit: str
    symbolic: Any

    @property
    def width(self) -> int:
        """Numbers of the result."""
        return int(self.symbolic.size1_out(0))


def of_batch(spec: KernelSpec, name: str) -> EmittedFunction:
    """A function of `batch_dynamics`."""
    shape = function_shape(name)
    arguments = tuple(Argument(state, spec.n, UNITS[state]) for state in shape.states)
    result = symbolic_function(spec, name)
    return EmittedFunction(name, shape.formula, arguments, shape.result(spec.n), RESULT_UNITS[name], result)


EMITTED: Registry[Callable[[KernelSpec, str], EmittedFunction]] = Registry(
    "emitted_function",
    {name: Row("lwr_dyn.emit.functions:of_batch", FUNCTIONS[name].formula, extra="batch") for name in RESULT_UNITS},
)
"""What can be emitted: name -> factory of (spec, name)."""


def emitted_function(spec: KernelSpec, name: str) -> EmittedFunction:
    """The function of that name for an arm; raises `UnknownNameError`, `MissingPackageError`."""
    return EMITTED.load(name)(spec, name)
