"""Searches for the largest B_ii, cached by all that it depends on: a changed table repeats only those it touches."""

import itertools
import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_readings
from lwr_dyn.control.inertia.maxima import diagonal
from lwr_dyn.control.inertia.worst_case import worst_case_inertia
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm

PAPER_ZERO = (0.0, 90.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Printed angle minus DH angle [deg]: the paper counts joint 2 from the horizontal."""
_cache: dict[bytes, tuple[float, float]] = {}
"""What B_ii depends on -> its least and most value, or the most value twice."""


def arms() -> dict[str, Arm]:
    """The arm under each of its readings."""
    return {paper.reading.name: arm_from_paper(paper) for paper in open_readings("lwr4plus")}


def largest(arm: Arm, joint: int, from_known_maxima: bool = False) -> float:
    """max B_ii [kg m^2] of one joint: by a search, or the largest value at the maxima of the paper's own readings."""
    key = _key(arm, joint) + bytes([from_known_maxima])
    if key not in _cache:
        if from_known_maxima:
            value = float(diagonal(Recursion.of(arm.require_dynamics()), joint, _ends(joint)).max())
        else:
            value = worst_case_inertia(arm, joint).value
        _cache[key] = value, value
    return _cache[key][1]


def at_printed(arm: Arm, joint: int, printed_q: Sequence[str]) -> tuple[float, float]:
    """Least and most B_ii [kg m^2] at a printed configuration: both signs of "+-", "-" free; from a lattice."""
    key = _key(arm, joint) + "/".join(printed_q).encode()
    if key not in _cache:
        _cache[key] = _span(arm, joint, printed_q)
    return _cache[key]


def _span(arm: Arm, joint: int, printed_q: Sequence[str]) -> tuple[float, float]:
    choices = []
    for j, text in enumerate(printed_q):
        if text != "-":
            size = float(text.removeprefix("+-"))
            angles = (size, -size) if text.startswith("+-") else (size,)
            choices.append([(j, math.radians(a - PAPER_ZERO[j])) for a in angles])
    values = []
    for combination in itertools.product(*choices):
        fixed = dict(combination)
        starts = _lattice(arm, joint, fixed)
        values += [worst_case_inertia(arm, joint, fixed, small, starts).value for small in (True, False)]
    return min(values), max(values)


def _lattice(arm: Arm, joint: int, fixed: dict[int, float]) -> Array:
    """Corners of a 60 deg lattice of the free joints that B_ii depends on; the last joint turns a near-round body."""
    free = [j for j in range(joint + 1, arm.n) if j not in fixed]
    axes = [[0.0] if j == arm.n - 1 else [x for x in (-2.0, -1.0, 0.1, 1.0, 2.0)] for j in free]
    rows = list(itertools.product(*axes))
    points = np.tile((arm.lower + arm.upper) / 2, (len(rows), 1))
    for j, value in fixed.items():
        points[:, j] = value
    points[:, free] = np.array(rows).reshape(len(rows), len(free))
    return points


def _key(arm: Arm, joint: int) -> bytes:
    """All that B_ii depends on: the links from joint i outward, its rotor, the limits of the joints after it."""
    parts = [arm.lower[joint + 1 :], arm.upper[joint + 1 :], arm.armature[joint : joint + 1]]
    for link in arm.chain.links[joint:]:
        body = link.body
        parts += [link.before.matrix(), link.after.matrix()]
        parts += [] if body is None else [np.array([body.mass]), body.com, body.inertia_com]
    return bytes([joint]) + b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


@cache
def _ends(joint: int) -> Array:
    """Where the searches of the package's own readings ended, (k, n)."""
    return np.array([worst_case_inertia(arm, joint).q for arm in arms().values()])
