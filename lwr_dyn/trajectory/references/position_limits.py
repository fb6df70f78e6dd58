"""Position limits that a reference must keep: the largest violation, and the smallest distance from one."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind


class LimitViolation(NamedTuple):
    """Row of the movement, the joint, the fault and what is allowed in words, and by how much [rad or m]."""

    row: int
    joint: str
    fault: str
    allowed: str
    excess: float


@dataclass(frozen=True, slots=True)
class LimitMargin:
    """The smallest distance from a position limit [rad or m], infinite where none is known; its joint; its time [s]."""

    margin: float
    joint: str
    t: float


def largest_violation(arm: Arm, q: Array) -> LimitViolation | None:
    """The largest violation of the limits by positions q (k, n) [rad or m], or None."""
    excess = np.maximum(q - arm.upper, arm.lower - q)
    i, j = (int(x) for x in np.unravel_index(int(np.argmax(excess)), excess.shape))
    if excess[i, j] <= 0.0:
        return None
    unit = "rad" if arm.chain.links[j].kind is JointKind.REVOLUTE else "m"
    name, past = arm.joint_names[j], float(excess[i, j])
    fault = f"{name} at {q[i, j]:.6g} {unit}, {past:.3g} {unit} outside its limits"
    return LimitViolation(i, name, fault, f"{arm.lower[j]:.6g} to {arm.upper[j]:.6g} {unit}", past)


def limit_margin(arm: Arm, t: Array, q: Array) -> LimitMargin:
    """Where the positions q (k, n) at times t (k,) come nearest to a limit."""
    margin = np.minimum(arm.upper - q, q - arm.lower)
    i, j = np.unravel_index(int(np.argmin(margin)), margin.shape)
    return LimitMargin(float(margin[i, j]), arm.joint_names[int(j)], float(t[i]))
