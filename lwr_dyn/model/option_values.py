"""Values of options as people type them, in degrees, as rad and m: on the command line, in files of studies."""

from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array, fixed_array, joint_array
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.foundation.registry import Option, Quantity
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind


def positions(arm: Arm, values: tuple[float, ...], name: str) -> Array:
    """Joint positions of an option (n,) [rad or m]; raises `ShapeError`, which names the arm."""
    if len(values) != arm.n:
        raise ShapeError(name, f"{len(values)} numbers", f"{arm.n} numbers: {arm.name} has {arm.n} joints")
    return joint_array(name, values, arm.n)


def from_degrees(arm: Arm, values: tuple[float, ...], name: str) -> Array:
    """Joint positions given in deg (m for sliding joints) as rad and m; raises `ShapeError`."""
    q = positions(arm, values, name)
    turning = [link.kind is JointKind.REVOLUTE for link in arm.chain.links]
    return np.where(turning, np.radians(q), q)


def si_value(option: Option, value: Any, arm: Arm, name: str) -> Any:
    """A value of an option as its factory takes it [rad, m]; `name` is what messages call it. Raises `ShapeError`."""
    if option.kind is bool:
        return not option.default
    if option.kind is Quantity.ANGLE:
        return float(np.radians(value))
    if option.kind is Quantity.ANGLES:
        return np.radians(fixed_array(name, value, (3,)))
    return from_degrees(arm, value, name) if option.kind is Quantity.JOINT_POSITIONS else value
