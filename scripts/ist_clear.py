"""Where `ist-clear` comes from: the shift of the IST letters with the largest joint-limit margin, on a grid of 0.1 m.

Shifts out of reach, outside a limit or over a speed limit do not count. Prints the best few (some minutes).
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.references.ist import CLEAR_SHIFT, ist_reference

TENTHS = (range(10), range(-6, 11), range(-6, 4))
"""Shifts in x, y and z [0.1 m] in frame 0; the other side, x below 0, is the mirror image."""
TIMES = np.linspace(0.0, 14.0, 1401)
SHOWN = 5


class Candidate(NamedTuple):
    """A shift of the letters [m], the least margin of a joint [deg], the largest share of a speed limit."""

    margin: float
    speed: float
    shift: tuple[float, ...]

    def __str__(self) -> str:
        return f"{self.shift} m: {self.margin:.1f} deg, {self.speed:.0%} of the speed"


def candidate(arm: Arm, shift: tuple[float, ...]) -> Candidate | None:
    """One shift; None where it does not count."""
    try:
        reference = ist_reference(arm, shift=shift)
    except LwrDynError:
        return None
    speed = float((np.abs(reference.sample(TIMES).dq).max(axis=0) / arm.velocity).max())
    return Candidate(math.degrees(reference.margin), speed, shift) if speed <= 1.0 else None


def search(arm: Arm) -> list[Candidate]:
    """All shifts that count, largest margin first."""
    shifts = (tuple(x / 10 for x in tenths) for tenths in itertools.product(*TENTHS))
    return sorted((one for shift in shifts if (one := candidate(arm, shift))), reverse=True)


def line() -> tuple[str, bool]:
    """The search, for `soak.py`: whether it gives the shift of `ist-clear`."""
    found = search(lwr_dyn.load("lwr4plus"))
    return f"of {len(found)} shifts that keep the limits the best: {found[0]}", found[0].shift == CLEAR_SHIFT


if __name__ == "__main__":
    print("\n".join(map(str, search(lwr_dyn.load("lwr4plus"))[:SHOWN])))
