"""The functions of a batch, and the specification of their kernels: arm data, inputs, number type; its digest."""

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.parameters import chosen_inputs, friction_parameters
from lwr_dyn.codegen.kernels.result_form import Layout, Structure, check_form
from lwr_dyn.dynamics.recursion import Rotors
from lwr_dyn.dynamics.unknown_inertia import chain_with_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError, UnknownNameError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain

GENERATOR = 16
"""Version of the generator: raised when it writes another kernel for the same arm, so that cached ones are not used."""
NUMBER_TYPES = ("float64", "float32")
FRICTIONS = ("none", "arm")


@dataclass(frozen=True, slots=True)
class FunctionShape:
    """The arguments and the result of one function of a batch."""

    states: tuple[str, ...]
    """Its joint vectors, of q, dq, ddq, tau."""
    result: Callable[[int], tuple[int, ...]]
    """Number of joints -> shape of one result."""
    parameters: tuple[str, ...]
    """The inputs of `KernelSpec` on which it depends."""
    formula: str
    """The result as a formula or in words."""


_BODIES = ("inertia", "payload")
_ALL = ("inertia", "payload", "gravity", "friction")
_Q, _QV = ("q",), ("q", "dq")
_INVERSE, _FORWARD = ("q", "dq", "ddq"), ("q", "dq", "tau")

FUNCTIONS = {
    "inverse_dynamics": FunctionShape(_INVERSE, lambda n: (n,), _ALL, "tau"),
    "mass_matrix": FunctionShape(_Q, lambda n: (n, n), _BODIES, "B"),
    "bias_torque": FunctionShape(_QV, lambda n: (n,), (*_BODIES, "gravity"), "C dq + g"),
    "gravity_vector": FunctionShape(_Q, lambda n: (n,), (*_BODIES, "gravity"), "g"),
    "coriolis_matrix": FunctionShape(_QV, lambda n: (n, n), _BODIES, "C"),
    "forward_dynamics": FunctionShape(_FORWARD, lambda n: (n,), _ALL, "ddq"),
    "flange_pose": FunctionShape(_Q, lambda n: (4, 4), (), "T of the flange in the base"),
    "jacobian": FunctionShape(_Q, lambda n: (6, n), (), "J of the flange, linear rows over angular rows"),
    "kinetic_energy": FunctionShape(_QV, lambda n: (), _BODIES, "dq^T B dq / 2"),
    "potential_energy": FunctionShape(_Q, lambda n: (), (*_BODIES, "gravity"), "U"),
    "torque_regressor": FunctionShape(_INVERSE, lambda n: (n, 10 * n), ("gravity",), "Y with tau = Y pi + armature"),
    "inverse_dynamics_derivatives": FunctionShape(
        _INVERSE, lambda n: (3, n, n), _ALL, "d tau by q, by dq, by ddq (the last is B)"
    ),
    "forward_dynamics_derivatives": FunctionShape(
        _FORWARD, lambda n: (3, n, n), _ALL, "d ddq by q, by dq, by tau (the last is B^-1)"
    ),
}


def function_shape(name: str) -> FunctionShape:
    """The function of that name; raises `UnknownNameError`.

    >>> function_shape("jacobian").result(7)
    (6, 7)
    """
    if name not in FUNCTIONS:
        raise UnknownNameError("function of a batch", name, FUNCTIONS)
    return FUNCTIONS[name]


@dataclass(frozen=True, slots=True)
class KernelInterface:
    """How a kernel is called, and its cost."""

    inputs: tuple[str, ...]
    """Names of its inputs, joint vectors first."""
    widths: tuple[int, ...]
    """Values in one row of each input."""
    width: int
    """Values stored for one state."""
    buffer: int
    """Numbers in the buffer of a block."""
    lanes: int
    """States in a block."""
    limit: float
    """[rad] Largest angle; a state with a larger one is counted as invalid."""
    operations: int
    fused: int
    """Operations when a product and a sum count as one."""
    entries: tuple[int, ...]
    """With structure="compact": for every entry of the result, as `result_form.compact` gives them."""
    constants: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class KernelSpec:
    """An arm with the options of its kernels."""

    name: str
    chain: Chain
    friction: Array | None
    """(5, n) as constants, None without friction (or with friction as an input)."""
    inputs: tuple[str, ...] = ()
    rotors: Rotors = "armature"
    dtype: str = "float64"
    layout: Layout = "rows"
    structure: Structure = "dense"

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.chain.n

    def parameters_of(self, function: str) -> tuple[str, ...]:
        """The inputs on which a function depends, in order."""
        return tuple(name for name in self.inputs if name in function_shape(function).parameters)

    def digest(self, function: str) -> str:
        """SHA-256 of everything on which the kernel of a function depends."""
        text = [
            f"generator {GENERATOR}",
            function,
            self.dtype,
            str(self.rotors),
            self.layout,
            self.structure,
            *self.inputs,
        ]
        for link in self.chain.links:
            text.append(link.kind.value)
            rotor = (0.0, 0.0) if link.rotor is None else (link.rotor.gear_ratio, link.rotor.inertia)
            arrays = [link.before.matrix(), link.after.matrix(), np.array(rotor)]
            if link.body is not None:
                arrays += [np.array(link.body.mass), link.body.com, link.body.inertia_com]
            text += [_hex(a) for a in arrays]
        text += [_hex(a) for a in (self.chain.flange.matrix(), self.chain.gravity)]
        text += [] if self.friction is None else [_hex(self.friction)]
        return hashlib.sha256("\n".join(text).encode()).hexdigest()


def _hex(array: Array) -> str:
    return np.asarray(array, dtype=np.float64).tobytes().hex()


def kernel_spec(
    arm: Arm,
    inputs: Iterable[str] = (),
    friction: str = "none",
    rotors: str = "armature",
    dtype: str = "float64",
    layout: Any = "rows",
    structure: Any = "dense",
) -> KernelSpec:
    """The options of an arm's kernels, checked.

    Parameters
    ----------
    arm : Arm
    inputs : names out of inertia, payload, gravity, friction
        The quantities that a kernel takes as inputs instead of the arm's constants.
    friction : {"none", "arm"}
        "arm" adds the arm's own friction (Coulomb and viscous per direction, offset) to inverse and subtracts it in
        forward dynamics.
    rotors : {"armature", "full", "none"}
    dtype : {"float64", "float32"}
    layout : {"rows", "padded", "blocks"}
    structure : {"dense", "compact"}
        How results lie in memory, and whether every distinct value is stored once (`result_form`).

    Raises
    ------
    OptionError
        A choice that does not exist, or the arm's friction has a Stribeck curve, which kernels do not support.
    MissingDataError
        The arm has no inertias, or no friction with friction="arm".
    """
    chosen = chosen_inputs(inputs)
    check_form(layout, structure)
    for option, value, allowed in (
        ("friction", friction, FRICTIONS),
        ("rotors", rotors, ("armature", "full", "none")),
        ("dtype", str(dtype), NUMBER_TYPES),
    ):
        if value not in allowed:
            raise OptionError(option, repr(value), ", ".join(allowed))
    if friction == "arm" and "friction" in chosen:
        raise OptionError("friction", "'arm' and an input", "one of them")
    if friction == "arm" and not any(arm.friction_models()):
        raise MissingDataError(arm.name, "friction", "kernels with friction='arm'")
    constants = friction_parameters(arm) if friction == "arm" else None
    name = f"{arm.name} ({arm.reading})"
    chain = chain_with_dynamics(arm)
    return KernelSpec(name, chain, constants, chosen, rotors, str(dtype), layout, structure)  # type: ignore[arg-type]
