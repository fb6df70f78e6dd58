"""The joint box of an arm: its limits, the way uphill inside it, and what a share of drawn poses says of all."""

from typing import Any

import numpy as np
from scipy.optimize import minimize

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind

DIFFERENCE = 1e-5
"""[rad or m] Step of the search's slopes."""


def joint_box(arm: Arm) -> tuple[Array, Array, tuple[str, ...]]:
    """Lower and upper position limits (n,) [rad or m], and the joints whose limits are unknown.

    An unknown limit is taken as half a turn to both sides, or as 1 m for a sliding joint.
    """
    kinds = (link.kind for link in arm.chain.links)
    reach = np.array([np.pi if kind is JointKind.REVOLUTE else 1.0 for kind in kinds])
    unknown = ~(np.isfinite(arm.lower) & np.isfinite(arm.upper))
    lower, upper = (np.where(unknown, side * reach, x) for side, x in ((-1.0, arm.lower), (1.0, arm.upper)))
    return lower, upper, tuple(name for name, is_unknown in zip(arm.joint_names, unknown, strict=True) if is_unknown)


def wilson_interval(found: int, tries: int, z: float = 1.959964) -> tuple[float, float]:
    """The interval of a share of which `found` of `tries` independent draws were met; 95 % with the default z.

    Wilson, J. Am. Stat. Assoc. 22 (1927) 209: it stays within 0 to 1 and says something where none, or all, are met.

    >>> [round(x, 4) for x in wilson_interval(459, 2000)], [round(x, 4) for x in wilson_interval(0, 2000)]
    ([0.2116, 0.2484], [0.0, 0.0019])
    """
    share, weight = found / tries, z * z / tries
    middle, half = share + weight / 2, z * np.sqrt(share * (1 - share) / tries + weight / tries / 4)
    low, high = (middle - half) / (1 + weight), (middle + half) / (1 + weight)
    return (0.0 if found == 0 else float(low)), (1.0 if found == tries else float(high))


def climb(function: Any, start: Array, lower: Array, upper: Array) -> Array:
    """A local maximum of log function(q (k, n)) inside the box, by L-BFGS-B with differences of one batch."""
    n = start.size
    offsets = DIFFERENCE * np.concatenate([np.zeros((1, n)), np.eye(n), -np.eye(n)])

    def descent(x: Array) -> tuple[float, Array]:
        values = -np.log(np.clip(function(x + offsets), 1e-300, 1e300))
        return float(values[0]), (values[1 : n + 1] - values[n + 1 :]) / (2 * DIFFERENCE)

    end = minimize(descent, start, jac=True, method="L-BFGS-B", bounds=list(zip(lower, upper, strict=True)))
    return np.asarray(np.clip(end.x, lower, upper))
