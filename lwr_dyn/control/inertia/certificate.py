"""The proven upper bound of B_ii over the joint box: boxes are halved until none can hold more than what is known.

A box is its control values, a flat array with the last joint fastest. The largest bounds the function on the box; those
at corners are values of the function. A box whose bound is not above the threshold is done; any other is halved along
the joint whose control values bend most.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numba import njit

from lwr_dyn.control.inertia.bernstein import WAVES, InertiaTable, halves
from lwr_dyn.control.inertia.worst_case import InertiaMaximum, JointInertia, first_joint
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm

jit = njit(error_model="numpy", nogil=True, cache=True)

LEVELS = 26
"""Halvings of one joint at most: then its interval is 1e-8 of the first one."""

ROWS = 160
"""Boxes that wait at most, each with its control values."""


@jit  # type: ignore[untyped-decorator]
def contract(values: Any, out: Any, size: int, inner: int, matrix: Any, count: int) -> None:
    """`matrix` (count, count) along the joint whose `count` control values are `inner` apart."""
    for start in range(0, size, count * inner):
        for m in range(count):
            at = start + m * inner
            for y in range(inner):
                out[at + y] = matrix[m, 0] * values[start + y]
            for k in range(1, count):
                a = matrix[m, k]
                if a != 0.0:
                    for y in range(inner):
                        out[at + y] += a * values[start + k * inner + y]


@jit  # type: ignore[untyped-decorator]
def bend(values: Any, size: int, inner: int, count: int) -> float:
    """The largest second difference of the control values along one joint."""
    most = 0.0
    for start in range(0, size, count * inner):
        for k in range(1, count - 1):
            for y in range(start + k * inner, start + (k + 1) * inner):
                most = max(most, abs(values[y - inner] - 2.0 * values[y] + values[y + inner]))
    return most


@jit  # type: ignore[untyped-decorator]
def extremes(values: Any, corners: Any, known: float) -> tuple[float, float]:
    """The largest control value, and the best of `known` and the values at the corners of the box."""
    highest = values[0]
    for x in range(len(values)):
        highest = max(highest, values[x])
    for x in corners:
        known = max(known, values[x])
    return highest, known


@jit  # type: ignore[untyped-decorator]
def most_bent(values: Any, levels: Any, counts: Any) -> tuple[int, int]:
    """The joint along which a box is halved, and how far apart its control values are; -1 where none bends any more."""
    chosen, its_inner, largest, inner = -1, 1, 0.0, 1
    for back in range(len(counts)):
        j = len(counts) - 1 - back
        if levels[j] < LEVELS:
            here = bend(values, len(values), inner, counts[j])
            if here > largest:
                chosen, its_inner, largest = j, inner, here
        inner *= counts[j]
    return chosen, its_inner


@jit  # type: ignore[untyped-decorator]
def search(
    counts: Any, lefts: Any, rights: Any, corners: Any, gap: float, known: float, most: int, pool: Any
) -> tuple[float, float, int]:
    """The bound over one box, whose control values stand in pool[0]: (bound, best value met, boxes).

    `counts` (d,) control values a joint; `lefts`, `rights` (d, LEVELS, 5, 5) halvings by level; `corners` (2^d,) places
    of corners; `known` the best value before; a box is done at known (1 + gap). Where `most` boxes or the rows of
    `pool` are not enough, the bound is larger than that, and holds all the same.
    """
    size, last = pool.shape[1], pool.shape[0] - 1  # the last row is for the box that is being halved
    levels = np.zeros((last, len(counts)), dtype=np.int64)
    bound, boxes, top = -np.inf, 0, 0
    while top >= 0:
        boxes += 1
        highest, known = extremes(pool[top], corners, known)
        j, inner = -1, 1
        if highest > known * (1.0 + gap) and boxes < most and top + 1 < last:
            j, inner = most_bent(pool[top], levels[top], counts)
        if j < 0:
            bound = max(bound, highest)
            top -= 1
            continue
        level = levels[top, j]
        pool[last] = pool[top]
        contract(pool[last], pool[top + 1], size, inner, lefts[j, level], counts[j])
        contract(pool[last], pool[top], size, inner, rights[j, level], counts[j])
        levels[top, j] = level + 1
        levels[top + 1] = levels[top]
        top += 1
    return bound, known, boxes


GAP = 1e-6
"""Relative distance of bound and value at which a box is done."""

MOST_BOXES = 2_000_000

IDLE = 0.1
"""Share of the gap that joints may add which are left out."""

KEPT = 256
"""Certificates that are kept in memory."""

_proven: dict[tuple[Any, ...], "InertiaCertificate"] = {}

HALVING = 20 * float(np.finfo(np.float64).eps)
"""Rounding of one halving, relative to the largest control value: five products and sums of rounded entries."""


@dataclass(frozen=True, slots=True, eq=False)
class InertiaCertificate:
    """max B_ii of one joint lies between `value` and `upper` [kg m^2; kg for a sliding joint]."""

    joint: int
    value: float
    """The largest that was met: B_ii at some position in the box."""
    upper: float
    """No position in the box has more, rounding allowed for."""
    boxes: int
    allowance: float
    """The part of `upper` that allows for rounding [kg m^2]."""
    left_out: float
    """The part of `upper` for joints that move B_ii by less than this [kg m^2]."""
    gap_asked: float

    @property
    def gap(self) -> float:
        """(upper - value) / value."""
        return (self.upper - self.value) / self.value if self.value else 0.0

    @property
    def holds(self) -> bool:
        """Whether the gap is as small as asked: where it is not, `upper` is a bound all the same."""
        return self.gap <= self.gap_asked

    def statement(self) -> str:
        """What is proven, in one sentence."""
        parts = f"{self.boxes} boxes, {self.allowance / (self.value or 1.0):.0e} of it for rounding"
        asked = "" if self.holds else f", NOT as asked, {self.gap_asked:.1e}"
        return f"certified: nowhere in the joint box above {self.upper:.12g}, a gap of {self.gap:.1e}{asked} ({parts})"

    def to_json(self) -> dict[str, Any]:
        """The certificate as JSON values."""
        names = ("value", "upper", "gap", "boxes", "allowance", "left_out")
        return {name: getattr(self, name) for name in names}


def inertia_certificate(arm: Arm, maximum: InertiaMaximum, gap: float = GAP) -> InertiaCertificate:
    """The proven bound of B_ii over the joint box of an arm.

    B_ii at 5 positions of every turning joint and 3 of every sliding one determines it everywhere; on a box its control
    values bound it; boxes are halved until none has more than `gap` above the best value.

    Parameters
    ----------
    maximum : InertiaMaximum
        What the search found for this arm (see `worst_case_inertia`).
    gap : float
        Relative distance of bound and value that is asked for.

    Returns
    -------
    InertiaCertificate
        Its `upper` holds whatever happens; `holds` is False where `MOST_BOXES` were not enough for the gap.

    Raises
    ------
    OptionError
        A gap that is not above 0 and below 1; more joints than a table can hold.
    """
    if not (np.isfinite(gap) and 0.0 < gap < 1.0):
        raise OptionError("gap", gap, "above 0 and below 1")
    inertia = replace(first_joint(arm, {}), joint=maximum.joint)
    key = (inertia.content, maximum.joint, maximum.value, gap, MOST_BOXES)
    if key not in _proven:
        if len(_proven) >= KEPT:
            del _proven[next(iter(_proven))]
        _proven[key] = _certificate(inertia, maximum, gap)
    return _proven[key]


def inertia_certificates(
    arm: Arm, maxima: Sequence[InertiaMaximum], gap: float = GAP
) -> tuple[InertiaCertificate, ...]:
    """`inertia_certificate` of several joints of an arm."""
    return tuple(inertia_certificate(arm, maximum, gap) for maximum in maxima)


def _certificate(inertia: JointInertia, maximum: InertiaMaximum, gap: float) -> InertiaCertificate:
    known = maximum.value
    table = InertiaTable.of(inertia).without_idle(IDLE * gap * abs(known))
    counts, lefts, rights, corners = _halvings(table)
    pool = np.empty((ROWS, int(np.prod(table.shape, dtype=int))))
    bound, boxes, allowance = -np.inf, 0, 0.0
    for values, growth in table.boxes():
        pool[0] = values.ravel()
        highest, known, used = search(
            counts, lefts, rights, corners, (1.0 - IDLE) * gap, known, max(MOST_BOXES - boxes, 1), pool
        )
        bound, boxes = max(bound, highest), boxes + used
        halved = LEVELS * len(counts) * HALVING * float(np.abs(values).max())
        allowance = max(allowance, table.rounding(growth) + halved)
    upper = max(bound, known) + table.left_out + allowance
    met = maximum.value if known <= maximum.value + allowance + table.left_out else known - table.left_out
    return InertiaCertificate(maximum.joint, float(met), float(upper), boxes, allowance, table.left_out, gap)


def _halvings(table: InertiaTable) -> tuple[Any, Any, Any, Any]:
    """Control values a joint; halvings of each joint by level, left and right; places of the corners of a box."""
    d, shape = len(table.shape), table.shape
    lefts, rights = np.zeros((2, max(d, 1), LEVELS, WAVES, WAVES))
    for j, (turns, count) in enumerate(zip(table.is_turning, shape, strict=True)):
        for level in range(LEVELS):
            left, right = halves(turns, table.half_width(j) / 2**level)
            lefts[j, level, :count, :count], rights[j, level, :count, :count] = left, right
    ends = np.ix_(*[[0, count - 1] for count in shape])
    corners = np.arange(int(np.prod(shape, dtype=int))).reshape(shape)[ends].ravel()
    return np.array(shape, dtype=np.int64), lefts, rights, corners
