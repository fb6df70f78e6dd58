"""What both closed forms of inverse kinematics share: eight branches, joint ranges, whole turns, the elbow's bend."""

from dataclasses import dataclass
from itertools import product
from math import prod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm

ALIGNED = 1e-13
"""Sine of a ball's tilt below which its two rolls turn about one line: only their sum (difference) is determined."""
REACH_SLACK = 1e-12
"""[m] The wrist of a stretched arm, recomputed from its pose, may be this far out of reach."""
TOUCH = 1e-12
"""[rad] A margin this little below a level keeps it: a joint at its limit is inside."""
TURN = 2.0 * np.pi
MOST_COPIES = 256
"""Copies of one branch, whole turns of joints apart, that are listed: two of each of seven joints, and twice that."""


class Branch(NamedTuple):
    """Which of the eight solutions.

    S-R-S arms: the signs of tilt 2, elbow 4 and tilt 6, counted from where rolls or arm align. Six joints with a
    spherical wrist: shoulder +1 with the wrist centre ahead of axis 1, elbow and wrist the signs of bend and tilt.
    """

    shoulder: int
    elbow: int
    wrist: int

    @property
    def label(self) -> str:
        """The three signs.

        >>> Branch(1, -1, 1).label
        '+-+'
        """
        return "".join("+" if sign > 0 else "-" for sign in self)


BRANCHES = tuple(Branch(*signs) for signs in product((1, -1), repeat=3))


@dataclass(frozen=True, slots=True, eq=False)
class JointRanges:
    """Position limits as middle and half width, (n,) each [rad]; half is infinite where a limit is not known."""

    middle: Array
    half: Array


def joint_ranges(arm: Arm) -> JointRanges:
    """The arm's limits; a joint with one known limit may make a whole turn from it."""
    lower, upper = arm.lower, arm.upper
    both, low, up = np.isfinite(lower) & np.isfinite(upper), np.isfinite(lower), np.isfinite(upper)
    lower, upper = np.where(low, lower, 0.0), np.where(up, upper, 0.0)
    one_sided = np.where(low, lower + np.pi, np.where(up, upper - np.pi, 0.0))
    half = np.where(both, (upper - lower) / 2.0, np.where(low | up, np.pi, np.inf))
    return JointRanges(np.where(both, (lower + upper) / 2.0, one_sided), half)


def drawing_range(turning: NDArray[np.bool_], lower: Array, upper: Array) -> tuple[Array, Array]:
    """Between which positions (n,) starts are drawn: the limits, and one turn [rad] or 2 m where one is not known."""
    wide = np.where(turning, np.pi, 1.0)
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - 2.0 * wide, -wide))
    return low, np.where(np.isfinite(upper), upper, low + 2.0 * wide)


def one_turn_note(arm: Arm) -> str:
    """Which joints with a range of more than one turn, or of unknown width, a path search counts as one; "" if none.

    >>> import lwr_dyn
    >>> one_turn_note(lwr_dyn.load("kr30ha"))
    'A1, A4, A6 counted as one turn about the middle of the range, which is wider'
    """
    wide = joint_ranges(arm).half > np.pi
    names = [name for name, is_wide in zip(arm.joint_names, wide, strict=True) if is_wide]
    return f"{', '.join(names)} counted as one turn about the middle of the range, which is wider" if names else ""


def wrap(angle: Array) -> Array:
    """The angle [rad] within -pi (excluded) and pi.

    >>> wrap(np.array([-np.pi, 4.0])).round(4)
    array([ 3.1416, -2.2832])
    """
    wrapped: Array = np.pi - np.mod(np.pi - angle, TURN)
    return wrapped


@dataclass(frozen=True, slots=True, eq=False)
class WholeTurns:
    """Positions q (k, n) [rad] whole turns of joints apart, and how many more there are inside the limits."""

    q: Array
    left_out: int


def whole_turns(arm: Arm, q: Array) -> WholeTurns:
    """All positions whole turns of joints away from q (n,) that are inside the limits, q included; q itself if none is.

    q is within half a turn of the middle of each range. A joint that lacks a limit keeps its position. Of more than
    `MOST_COPIES` only q is given.
    """
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    first = np.where(limited, np.ceil((np.where(limited, arm.lower, 0.0) - TOUCH - q) / TURN), 0.0)
    last = np.where(limited, np.floor((np.where(limited, arm.upper, 0.0) + TOUCH - q) / TURN), 0.0)
    counts = [int(count) for count in last - first + 1.0]
    total = prod(counts)
    if min(counts) < 1 or total > MOST_COPIES:
        return WholeTurns(q[None], max(total - 1, 0) if min(counts) >= 1 else 0)
    turns = product(*(np.arange(low, up + 1.0) for low, up in zip(first, last, strict=True)))
    return WholeTurns(q + TURN * np.array(list(turns)), 0)


def elbow_bend(lengths: tuple[float, float], distance: Array) -> tuple[Array, Array]:
    """Angle of the elbow from straight, 0 to pi [rad], and by how much the wrist is out of reach [m], <= 0 within.

    The wrist is at `distance` [m] from the shoulder; `lengths` [m] are those of upper arm and forearm.
    """
    first, second = lengths
    longest, shortest = first + second, abs(first - second)
    short, long = np.maximum(longest - distance, 0.0), np.maximum(distance - shortest, 0.0)
    bend = 2.0 * np.arctan2(np.sqrt(short * (longest + distance)), np.sqrt(long * (distance + shortest)))
    return bend, np.maximum(distance - longest, shortest - distance)
