"""The quantities that a kernel may take as inputs instead of constants, as arrays.

The torque is linear in the ten inertial parameters of each link (Siciliano et al., Robotics, section 7.2.2), so a
kernel does not divide by a mass and accepts any values, such as base parameters from identification (a mass of 0).
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, Chain, with_payload
from lwr_dyn.model.friction import FRICTIONLESS

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
    shapes: dict[str, tuple[int, ...]] = {
        "inertia": (n, 10),
        "payload": (10,),
        "gravity": (3,),
        "friction": (len(FRICTION), n),
    }
    return shapes[name]


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
    from lwr_dyn.model.chain import ChainLink
    from lwr_dyn.model.dh import JointKind
    from lwr_dyn.model.spatial import Pose

    identity = Pose.identity()
    bare = Chain((ChainLink("joint", "link", JointKind.REVOLUTE, identity, identity),), identity, np.zeros(3))
    body = with_payload(bare, mass, com, inertia_com).links[0].body
    return body_parameters(body or Body.massless(), TENSOR)


def friction_parameters(arm: Arm) -> Array:
    """Friction of the joints, (5, n), rows as `FRICTION`; zero where unknown.

    Raises
    ------
    OptionError
        A joint with a Stribeck curve, which kernels do not support.
    """
    columns = []
    for name, model in zip(arm.joint_names, arm.friction_models(), strict=True):
        friction = model or FRICTIONLESS
        for side in (friction.positive, friction.negative):
            if side.stribeck_velocity is not None and side.holding > side.coulomb:
                allowed = "Coulomb and viscous friction per direction, and an offset"
                raise OptionError(f"friction of {name}", "a Stribeck curve", f"in kernels {allowed}")
        sides = [x for side in (friction.positive, friction.negative) for x in (side.coulomb, side.viscous)]
        columns.append([*sides, friction.offset])
    return np.array(columns).T


def in_parent_frame(parameters: Any, rotation: Array, position: Array) -> list[Any]:
    """Inertial parameters (numbers or symbols) in the parent of a frame with this pose; linear in them.

    m' = m, (m c)' = R mc + m p, and the second moments tr(I)/2 E - I transform as R S R^T plus the terms of the shift.
    """
    m, first = _scalar(parameters[0]), np.array([*parameters[1:4]], dtype=object)
    tensor = np.empty((3, 3), dtype=object)
    for (i, j), value in zip(TENSOR, parameters[4:], strict=True):
        tensor[i, j] = tensor[j, i] = value
    turned = rotation @ first
    across = np.outer(turned, position)
    second = _half_trace(tensor) * np.eye(3) - tensor
    second = rotation @ second @ rotation.T + across + across.T + m * np.outer(position, position)
    tensor = 2 * _half_trace(second) * np.eye(3) - second
    return [parameters[0], *(turned + m * position), *(tensor[i, j] for i, j in TENSOR)]


def _half_trace(tensor: Any) -> Any:
    return _scalar((tensor[0, 0] + tensor[1, 1] + tensor[2, 2]) / 2)


def _scalar(x: Any) -> Any:
    """An array of one, so that a symbol times an array is an array of symbols."""
    out = np.empty(1, dtype=object)
    out[0] = x
    return out
