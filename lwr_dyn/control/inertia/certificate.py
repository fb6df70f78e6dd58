"""The proven upper bound of B_ii over the joint box: boxes are halved until none can hold more than what is known.

A box is its control values, a flat array with the last joint fastest. The largest bounds the function on the box; those
at corners are values of the function. A box whose bound is not above the threshold is done; any other is halved along
the joint whose control values bend most.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.control.inertia.bernstein import WAVES, InertiaTable, halves
from lwr_dyn.control.inertia.worst_case import InertiaMaximum, JointInertia, first_joint
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm

LEVELS = 26
"""Halvings of one joint at most: then its interval is 1e-8 of the first one."""

ROWS = 160
"""Boxes that wait at most, each with its control values."""


@dataclass(frozen=True, slots=True, eq=False)
class Halvings:
    """How boxes are halved.

    `counts` (d,) control values a joint; `lefts`, `rights` (d, LEVELS, 5, 5) by joint and level; `corners` (2^d,) the
    places of a box's corners among its control values.
    """

    counts: NDArray[np.int64]
    lefts: Array
    rights: Array
    corners: NDArray[np.int64]

    @classmethod
    def of(cls, table: InertiaTable) -> "Halvings":
        """Those of a table's boxes."""
        d, shape = len(table.shape), table.shape
        lefts, rights = np.zeros((2, max(d, 1), LEVELS, WAVES, WAVES))
        for j, (turns, count) in enumerate(zip(table.is_turning, shape, strict=True)):
            for level in range(LEVELS):
                left, right = halves(turns, table.half_width(j) / 2**level)
                lefts[j, level, :count, :count], rights[j, level, :count, :count] = left, right
        ends = np.ix_(*[[0, count - 1] for count in shape])
        corners = np.arange(int(np.prod(shape, dtype=int))).reshape(shape)[ends].ravel()
        return cls(np.array(shape, dtype=np.int64), lefts, rights, corners)


BoxSearch = Callable[[Halvings, Array, float, float, int], tuple[float, float, int]]
"""(halvings, pool, gap, known, most) -> (bound, best value met, boxes), over the box whose control values stand in
pool[0]. `known` is the best value before; a box is done at known (1 + gap). Where `most` boxes or the rows of the pool
are not enough, the bound is larger than that, and holds all the same."""

BOX_SEARCHES: Registry[Callable[[], BoxSearch]] = Registry(
    "search over boxes",
    {"compiled": Row("lwr_dyn.codegen.kernels.box_search:box_search", "machine code, made once", "batch")},
)


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
    MissingPackageError
        The extra `batch` is not installed.
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
    search, halvings = BOX_SEARCHES.load("compiled")(), Halvings.of(table)
    pool = np.empty((ROWS, int(np.prod(table.shape, dtype=int))))
    bound, boxes, allowance = -np.inf, 0, 0.0
    for values, growth in table.boxes():
        pool[0] = values.ravel()
        highest, known, used = search(halvings, pool, (1.0 - IDLE) * gap, known, max(MOST_BOXES - boxes, 1))
        bound, boxes = max(bound, highest), boxes + used
        halved = LEVELS * len(halvings.counts) * HALVING * float(np.abs(values).max())
        allowance = max(allowance, table.rounding(growth) + halved)
    upper = max(bound, known) + table.left_out + allowance
    met = maximum.value if known <= maximum.value + allowance + table.left_out else known - table.left_out
    return InertiaCertificate(maximum.joint, float(met), float(upper), boxes, allowance, table.left_out, gap)
