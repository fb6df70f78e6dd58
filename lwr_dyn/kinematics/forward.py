"""Forward kinematics on the native chain: the product of the paper's own matrices."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array
from lwr_dyn.model.chain import Chain, link_frames


def frames(chain: Chain, q: ArrayLike) -> Array:
    """T_{0,1} ... T_{0,n}, T_{0,flange}: (..., n + 1, 4, 4) for q (..., n) [rad or m]; raises `ShapeError`."""
    return np.stack(list(link_frames(chain, joint_array("q", q, chain.n))), axis=-3)


def forward_kinematics(chain: Chain, q: ArrayLike) -> Array:
    """T_{0,flange}, (..., 4, 4), for q (..., n) [rad or m]; raises `ShapeError`."""
    (pose,) = deque(link_frames(chain, joint_array("q", q, chain.n)), maxlen=1)
    return pose
