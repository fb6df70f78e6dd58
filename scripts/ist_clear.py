"""Where `ist-clear` comes from: shifts of the letters and turns of the tool are searched by the rule that it follows.

Taken is the smallest turn of the tool at which a shift keeps `KEPT`, and there the shift with the largest margin. The
search stops at the first such turn (2 minutes); --turns-deg looks at others.
"""

from __future__ import annotations

import argparse
import itertools
import math
from typing import NamedTuple

import numpy as np

import lwr_dyn
from lwr_dyn.errors import LwrDynError
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.references.ist import CLEAR_SHIFT, CLEAR_TURN, ist_reference

KEPT = 20.0
"""[deg] Margin that the rule asks for: 15 degrees, and 5 for what a controller with a wrong model adds."""
X, Y, Z = np.arange(-2, 6) / 10, np.arange(-3, 4) / 10, np.arange(-2, 3) * 0.15
SHIFTS = tuple(tuple(np.round(shift, 9).tolist()) for shift in itertools.product(X, Y, Z))
"""[m] in frame 0."""
TURNS = ((0,), (30, -30), (60, -60), (90, -90), (120, -120), (150, -150), (180,))
"""[deg] about the x axis of frame 0, smallest first."""
TIMES = np.linspace(0.0, 14.0, 1401)


class Candidate(NamedTuple):
    """A pose of the letters: least margin of a joint [deg], largest share of a speed limit, turn [deg], shift [m]."""

    margin: float
    speed: float
    turn: float
    shift: tuple[float, ...]

    def __str__(self) -> str:
        return f"turn {self.turn:g} deg, shift {self.shift} m: {self.margin:.1f} deg, {self.speed:.0%} of the speed"


def candidate(arm: Arm, turn: float, shift: tuple[float, ...]) -> Candidate | None:
    """One pose; None where the letters are out of reach, or a joint out of its limits or over its speed."""
    try:
        reference = ist_reference(arm, shift=shift, tool_turn=math.radians(turn))
    except LwrDynError:
        return None
    speed = float((np.abs(reference.sample(TIMES).dq).max(axis=0) / arm.velocity).max())
    return Candidate(math.degrees(reference.margin), speed, turn, shift) if speed <= 1.0 else None


def best(arm: Arm, turns: tuple[float, ...]) -> Candidate:
    """The pose with the largest margin of all shifts at these turns."""
    found = (candidate(arm, turn, shift) for turn in turns for shift in SHIFTS)
    return max((one for one in found if one), key=lambda one: one.margin)


def search(arm: Arm) -> list[Candidate]:
    """The best pose of each turn, smallest first, up to the one that the rule takes."""
    out = []
    for turns in TURNS:
        out.append(best(arm, turns))
        if out[-1].margin >= KEPT:
            break
    return out


def line() -> tuple[str, bool]:
    """The search, for `soak.py`: whether it gives the constants of `ist-clear`."""
    found = search(lwr_dyn.load("lwr4plus"))
    same = (found[-1].turn, found[-1].shift) == (round(math.degrees(CLEAR_TURN), 9), CLEAR_SHIFT)
    return "; ".join(map(str, found)), same


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--turns-deg", type=float, nargs="+", help="search these turns alone")
    options = parser.parse_args(arguments)
    arm = lwr_dyn.load("lwr4plus")
    found = [best(arm, (turn,)) for turn in options.turns_deg] if options.turns_deg else search(arm)
    print("\n".join(map(str, found)))


if __name__ == "__main__":
    main()
