"""The functions of a batch, and the specification of their kernels: arm, inputs, number type, options; its digest.

Inputs are quantities that a kernel takes as arrays instead of constants. The torque is linear in the ten inertial
parameters of each link (Siciliano et al., Robotics, section 7.2.2), so a kernel does not divide by a mass and accepts
any values, such as base parameters from identification (a mass of 0).
"""

import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.result_form import Layout, Structure, check_form
from lwr_dyn.dynamics.recursion import Rotors
from lwr_dyn.dynamics.regressor import body_parameters, chain_with_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError, UnknownNameError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, Chain, ChainLink, JointKind, with_payload
from lwr_dyn.model.friction import FRICTIONLESS, JointFriction
from lwr_dyn.model.spatial import Pose

INPUTS = ("inertia", "payload", "gravity", "friction")
"""Possible inputs of a kernel, in the order of its arguments."""

PER_LINK = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Inertial parameters of a link: mass [kg], first moment [kg m], tensor about the origin of its frame [kg m^2]."""

FRICTION = ("positive_coulomb", "positive_viscous", "negative_coulomb", "negative_viscous", "offset")
"""Rows of the friction of an arm: magnitudes per direction as in `model.friction`, [N m] and [N m s/rad]."""

TENSOR = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
"""Entries of the tensor in the order of `PER_LINK`, which is Pinocchio's; `dynamics.regressor` goes row by row."""


def parameter_shape(name: str, n: int) -> tuple[int, ...]:
    """Shape of one set of an input.

    >>> parameter_shape("inertia", 7), parameter_shape("friction", 7)
    ((7, 10), (5, 7))
    """
    return {"inertia": (n, 10), "payload": (10,), "gravity": (3,), "friction": (len(FRICTION), n)}[name]


def chosen_inputs(inputs: Iterable[str]) -> tuple[str, ...]:
    """The inputs in their order, each once; raises `OptionError` for one that cannot be an input.

    >>> chosen_inputs(["gravity", "inertia"])
    ('inertia', 'gravity')
    """
    wanted = set((inputs,) if isinstance(inputs, str) else inputs)
    for name in sorted(wanted - set(INPUTS)):
        raise OptionError("inputs", repr(name), ", ".join(INPUTS))
    return tuple(name for name in INPUTS if name in wanted)


def inertial_parameters(chain: Chain) -> Array:
    """Inertial parameters of all links in their own frames, (n, 10), ordered as `PER_LINK`; zero where not given."""
    return np.array([body_parameters(link.body or Body.massless(), TENSOR) for link in chain.links])


def payload_parameters(mass: float, com: Any = (0.0, 0.0, 0.0), inertia_com: Any = None) -> Array:
    """Inertial parameters (10,) of a load in the flange frame; arguments and errors of `chain.with_payload`.

    >>> payload_parameters(2.0, (0.0, 0.0, 0.1))[[0, 3, 4]]
    array([2.  , 0.2 , 0.02])
    """
    identity = Pose.identity()
    bare = Chain((ChainLink("joint", "link", JointKind.REVOLUTE, identity, identity),), identity, np.zeros(3))
    body = with_payload(bare, mass, com, inertia_com).links[0].body
    return body_parameters(body or Body.massless(), TENSOR)


def friction_parameters(arm: Arm) -> Array:
    """Friction of the joints, (5, n), rows as `FRICTION`; zero where unknown.

    Raises `OptionError`: a joint with a Stribeck curve, a sigmoid or a share of the load, which kernels do not support.
    """
    return friction_table(arm.friction_models(), arm.joint_names)


def friction_table(models: Sequence[JointFriction | None], names: Sequence[str] = ()) -> Array:
    """The friction of joints as a table (5, n), rows as `FRICTION`; raises as `friction_parameters`."""
    columns = []
    for name, model in zip(names or [f"joint {i}" for i in range(1, len(models) + 1)], models, strict=True):
        friction = model or FRICTIONLESS
        sides = (friction.positive, friction.negative)
        if any(side.stribeck_velocity is not None and side.holding > side.coulomb for side in sides):
            allowed = "in kernels Coulomb and viscous friction per direction, and an offset"
            raise OptionError(f"friction of {name}", "a Stribeck curve", allowed)
        allowed = "in kernels Coulomb and viscous friction per direction, and an offset; or friction none"
        if friction.sigmoid is not None:
            raise OptionError(f"friction of {name}", "a sigmoid of the speed", allowed)
        if friction.load:
            raise OptionError(f"friction of {name}", f"{friction.load:.2g} of the load", allowed)
        columns.append([*(x for side in sides for x in (side.coulomb, side.viscous)), friction.offset])
    return np.array(columns).T


def to_parent(pose: Pose) -> Array:
    """The matrix (10, 10) from inertial parameters in a frame with this pose to those in its parent."""
    return np.array([in_parent_frame(unit, pose.rotation, pose.position) for unit in np.eye(10)]).T


def in_parent_frame(parameters: Array, rotation: Array, position: Array) -> Array:
    """Inertial parameters (10,) in the parent of a frame with this pose; linear in them.

    m' = m, (m c)' = R mc + m p, and the second moments tr(I)/2 E - I transform as R S R^T plus the terms of the shift.
    """
    m, first, tensor = parameters[0], parameters[1:4], np.empty((3, 3))
    for (i, j), value in zip(TENSOR, parameters[4:], strict=True):
        tensor[i, j] = tensor[j, i] = value
    turned = rotation @ first
    across = np.outer(turned, position)
    second = _half_trace(tensor) * np.eye(3) - tensor
    second = rotation @ second @ rotation.T + across + across.T + m * np.outer(position, position)
    tensor = 2 * _half_trace(second) * np.eye(3) - second
    return np.array([m, *(turned + m * position), *(tensor[i, j] for i, j in TENSOR)])


def _half_trace(tensor: Array) -> float:
    return float(tensor[0, 0] + tensor[1, 1] + tensor[2, 2]) / 2


GENERATOR = 18
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


_BODIES, _PULLED = INPUTS[:2], INPUTS[:3]
"""Inputs of what depends on the bodies, and on gravity too."""

_Q, _QV = ("q",), ("q", "dq")

_INVERSE, _FORWARD = ("q", "dq", "ddq"), ("q", "dq", "tau")

FUNCTIONS = {
    "inverse_dynamics": FunctionShape(_INVERSE, lambda n: (n,), INPUTS, "tau"),
    "mass_matrix": FunctionShape(_Q, lambda n: (n, n), _BODIES, "B"),
    "bias_torque": FunctionShape(_QV, lambda n: (n,), _PULLED, "C dq + g"),
    "gravity_vector": FunctionShape(_Q, lambda n: (n,), _PULLED, "g"),
    "coriolis_matrix": FunctionShape(_QV, lambda n: (n, n), _BODIES, "C"),
    "forward_dynamics": FunctionShape(_FORWARD, lambda n: (n,), INPUTS, "ddq"),
    "flange_pose": FunctionShape(_Q, lambda n: (4, 4), (), "T of the flange in the base"),
    "jacobian": FunctionShape(_Q, lambda n: (6, n), (), "J of the flange, linear rows over angular rows"),
    "kinetic_energy": FunctionShape(_QV, lambda n: (), _BODIES, "dq^T B dq / 2"),
    "potential_energy": FunctionShape(_Q, lambda n: (), _PULLED, "U"),
    "torque_regressor": FunctionShape(_INVERSE, lambda n: (n, 10 * n), ("gravity",), "Y with tau = Y pi + armature"),
    "inverse_dynamics_derivatives": FunctionShape(
        _INVERSE, lambda n: (3, n, n), INPUTS, "d tau by q, by dq, by ddq (the last is B)"
    ),
    "forward_dynamics_derivatives": FunctionShape(
        _FORWARD, lambda n: (3, n, n), INPUTS, "d ddq by q, by dq, by tau (the last is B^-1)"
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
    """With structure="compact": for every entry of the result, as `straight_line.compact` gives them."""
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
        text = [f"generator {GENERATOR}", function, self.dtype, str(self.rotors), self.layout, self.structure]
        text += self.inputs
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
    """The options of an arm's kernels, checked; they are those of `batch_dynamics`, whose errors it raises.

    Friction "arm" of an arm without any raises `MissingDataError` too.
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
    if friction == "arm" and not arm.has_friction:
        raise MissingDataError(arm.name, "friction", "kernels with friction='arm'")
    constants = friction_parameters(arm) if friction == "arm" else None
    name = f"{arm.name} ({arm.reading})"
    chain = chain_with_dynamics(arm)
    return KernelSpec(name, chain, constants, chosen, rotors, str(dtype), layout, structure)  # type: ignore[arg-type]
