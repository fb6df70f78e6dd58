"""What can be emitted for an arm: each function with arguments, units and result, on symbols and as operations.

Sines and cosines are the project's own polynomials ("own": the same bits on every machine that does not contract
products and sums) or calls of the language's library ("libm").
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, get_args

from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS, KernelSpec, function_shape, parameter_shape
from lwr_dyn.codegen.kernels.straight_line import OPERATIONS, Node, StraightLineCode, Value, straight_line_code
from lwr_dyn.codegen.kernels.symbolic_functions import symbolic_function
from lwr_dyn.dynamics.regressor import chain_with_dynamics
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm

UNITS = {
    "q": "rad or m", "dq": "rad/s or m/s", "ddq": "rad/s^2 or m/s^2", "tau": "N m or N",
    "inertia": "of each link m, m c, tensor about its frame's origin (xx xy yy xz yz zz): kg, kg m, kg m^2",
    "payload": "at the flange m, m c, tensor about its origin (xx xy yy xz yz zz): kg, kg m, kg m^2",
    "gravity": "m/s^2 in the base frame",
    "friction": "rows Coulomb and viscous towards +, towards -, offset: N m, N m s/rad",
}  # fmt: skip
"""Of joint vectors and of quantities that are inputs instead of constants."""

RESULT_UNITS = {
    "inverse_dynamics": "N m or N", "forward_dynamics": "rad/s^2 or m/s^2",
    "mass_matrix": "kg m^2, kg m, kg; row by row", "coriolis_matrix": "N m s, N s; row by row",
    "bias_torque": "N m or N", "gravity_vector": "N m or N", "flange_pose": "4 x 4, m; row by row",
    "jacobian": "m or 1; 6 rows, row by row",
    "torque_regressor": "N m or N for a unit of m, m c, tensor (xx xy yy xz yz zz) of each link; row by row",
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


@dataclass(frozen=True, slots=True, eq=False)
class TemplateCase:
    """Test vectors of one function of a template: for each call the numbers given and expected."""

    name: str
    arguments: tuple[tuple[Argument, list[Any]], ...]
    unit: str
    rows: list[Any]
    """Of the result, an entry a call; NaN where there is none."""
    returned: list[Any] | None
    """What the function itself gives; None where it gives nothing."""
    tolerance: float
    """In the result's unit."""


@dataclass(frozen=True, slots=True, eq=False)
class TemplateFunction:
    """A function with branches, written by hand for each language with the arm's numbers put in.

    In the texts @NAME@ is the function's name with its prefix, @NUMBER@ the type of numbers.
    """

    name: str
    text: str
    """The result in words, with units; several lines are kept."""
    declaration: Mapping[str, str]
    """Language -> head of the function without body."""
    source: Mapping[str, str]
    """Language -> the function with all that it needs, and is no other function's.

    "LANGUAGE libm" stands for the text with the library's sine and cosine, where it differs.
    """
    self_test: Mapping[str, str] = field(default_factory=dict)
    """Language -> a function @NAME@_self_test without arguments: how many of its test vectors fail."""
    cases: Callable[[], tuple[TemplateCase, ...]] = tuple
    """Makes its test vectors, for other languages."""

    def written(self, language: str, kind: str) -> str:
        """The text in a language, with sines and cosines of that kind."""
        return self.source.get(f"{language} {kind}", self.source[language])


Emitted = EmittedFunction | TemplateFunction


def of_batch(spec: KernelSpec, name: str, arm: Arm) -> EmittedFunction:
    """A function of `batch_dynamics`; raises `MissingDataError` where it needs masses that are not given."""
    shape = function_shape(name)
    if "inertia" in shape.parameters:
        chain_with_dynamics(arm)
    states = [Argument(state, spec.n, UNITS[state]) for state in shape.states]
    inputs = [Argument(x, math.prod(parameter_shape(x, spec.n)), UNITS[x]) for x in spec.parameters_of(name)]
    result = symbolic_function(spec, name)
    arguments = (*states, *inputs)
    return EmittedFunction(name, shape.formula, arguments, shape.result(spec.n), RESULT_UNITS[name], result)


_STEP, _FRICTION = "further_functions:registered_step", "further_functions:friction_function"

_FURTHER = {
    "inverse_kinematics": ("closed_form:inverse_kinematics_function", "q of all branches, in closed form"),
    "torque_regressor_compact": ("further_functions:compact_function", "the distinct numbers of Y"),
    "torque_regressor_expanded": ("further_functions:expanding_function", "Y from its distinct numbers"),
    "friction_torque": (_FRICTION, "tau_f of dq"),
    "smooth_friction_torque": (_FRICTION, "tau_f of dq, with tanh"),
    "step_pd_gravity": (_STEP, "PD with gravity compensation"),
    "step_pid": (_STEP, "PID, with its memory"),
    "step_inverse_dynamics": (_STEP, "inverse dynamics control"),
    "step_motor_pd": (_STEP, "PD on the motor side of rigid joints"),
    "step_adaptive": (_STEP, "Slotine and Li's adaptive law for a load, with its memory"),
    "step_robust": (_STEP, "the robust law for a load"),
}

EMITTED: Registry[Callable[[KernelSpec, str, Arm], Emitted]] = Registry(
    "emitted_function",
    {
        name: Row("lwr_dyn.codegen.emit.functions:of_batch", FUNCTIONS[name].formula, extra="batch")
        for name in RESULT_UNITS
    }
    | {name: Row(f"lwr_dyn.codegen.emit.{place}", text, extra="batch") for name, (place, text) in _FURTHER.items()},
)
"""What can be emitted: name -> factory of (spec, name, arm)."""


def emitted_function(spec: KernelSpec, name: str, arm: Arm) -> Emitted:
    """The function of that name for an arm; raises `UnknownNameError`, and `MissingDataError` where it cannot be."""
    return EMITTED.load(name)(spec, name, arm)


SinCosKind = Literal["own", "libm"]

SINCOS = get_args(SinCosKind)

_BY_BITS = ("2^", "exponent", "significand")


@dataclass(frozen=True, slots=True)
class LibraryCalls:
    """Sine and cosine as calls: takes the place of `SinCos` in straight-line code."""

    magic: float
    most_half_turns: int

    def expand(self, writer: Any, x: Any) -> tuple[Any, Any, Any]:
        """sin x and cos x as nodes; no half turns are subtracted."""
        return writer.node("sin", x.node, x.node), writer.node("cos", x.node, x.node), writer.number(0.0)


@dataclass(frozen=True, slots=True)
class Operation:
    """Node `index` is computed."""

    index: int
    node: Node


@dataclass(frozen=True, slots=True)
class Store:
    """Result `place` gets the value."""

    place: int
    value: Value


@dataclass(frozen=True, eq=False)
class EmittedCode:
    """The operations of a function."""

    function: EmittedFunction
    code: StraightLineCode
    kind: SinCosKind
    dtype: str

    @property
    def nodes(self) -> tuple[Node, ...]:
        """Operations, constants and inputs."""
        return self.code.nodes

    @property
    def operations(self) -> int:
        """Additions, products, quotients, roots and calls of one state."""
        return self.code.operations

    @property
    def stores_early(self) -> bool:
        """Whether a result is stored as soon as it is known, so that fewer are held: then it may not be an argument.

        With as many results as joints they are stored last, and may take the place of an argument.
        """
        is_wide = self.function.width > max(argument.width for argument in self.function.arguments)
        return is_wide or any(self.nodes[value.node].op == "in" for value in self.code.results)

    @cached_property
    def statements(self) -> tuple[Operation | Store, ...]:
        """In order; constants and inputs have no statement of their own."""
        out, is_early = list[Operation | Store](), self.stores_early
        wanted: dict[int, list[Store]] = {}
        for place, value in enumerate(self.code.results):
            wanted.setdefault(value.node if is_early else -1, []).append(Store(place, value))
        for i, node in enumerate(self.nodes):
            out += [Operation(i, node)] if node.op in OPERATIONS else []
            out += wanted.get(i, ())
        return (*out, *wanted.get(-1, ()))


def check_sincos(kind: str) -> None:
    """Raise `OptionError` for another kind of sine and cosine."""
    if kind not in SINCOS:
        raise OptionError("sincos", repr(kind), ", ".join(SINCOS))


def emitted_code(function: EmittedFunction, kind: SinCosKind = "own", dtype: str = "float64") -> EmittedCode:
    """The operations of a function.

    Parameters
    ----------
    function : EmittedFunction
    kind : {"own", "libm"}
        Whose sine and cosine.
    dtype : {"float64", "float32"}

    Raises
    ------
    OptionError
        Another kind, or a function that float32 cannot compute.
    """
    check_sincos(kind)
    numbers: Any = sincos(dtype)
    if kind == "libm":
        numbers = LibraryCalls(numbers.magic, numbers.most_half_turns)
    code = straight_line_code(function.symbolic, numbers, is_flagged=False)
    if dtype != "float64" and any(node.op in _BY_BITS for node in code.nodes):
        raise OptionError(
            "dtype", repr(dtype), f"float64: {function.name} has exponentials, which are of float64 alone"
        )
    return EmittedCode(function, code, kind, dtype)
