"""The loop around the step of inverse kinematics: W starts at once, each in a lane of its own that is refilled.

Of many poses each lane takes one, and its starts one after the other. A single pose gets all lanes, and its solution is
that of the first start in order that ends in one; so both ways give the same solution. A lane takes a pose, begins a
start, judges a step and writes its row.

The loop is a text in the small part of C of the closed forms (`pose_driver.c`). It calls `body(b)`, the arm's step, on
a buffer b of rows of W lanes, and reads settings s; both are laid out here.
"""

from functools import cache
from importlib.resources import files

from lwr_dyn.kinematics.closed_forms import tree
from lwr_dyn.kinematics.closed_forms.text_parser import parsed
from lwr_dyn.kinematics.closed_forms.texts import with_shared
from lwr_dyn.kinematics.pose_solver import FOUND, INVALID, NOT_REACHED, OUTSIDE, TAIL, TOLERANCE

POSE, MEASURES, STATE = 12, 4, 9
"""Rows of T, of the measures and of the state."""

AT, START, STEPS, ALL, CODE, MISS, PLACE = range(STATE - 2)
"""The state of a lane: its pose (-1: none), its start, steps of the start and of the pose, the outcome of the nearest
miss, how far it misses, and its three measures."""

HEAD = 4
"""Settings before those of the joints: number of starts, whether to move angles by whole turns, whether the arm is
redundant, n."""

PULL, HOLD = 1.0, 2.0
"""How a solution outside the limits is repaired: pulled along the self-motion, or held at the limits that it passes."""

NUMBERS = {
    "FOUND": float(FOUND), "OUTSIDE": float(OUTSIDE), "NOT_REACHED": float(NOT_REACHED), "INVALID": float(INVALID),
    "SQUARE": TOLERANCE**2, "PULL": PULL, "HOLD": HOLD,
    # Steps of a start: of one whose E stays above CLOSE, above CLOSEST, and below (where the arm is stretched or its
    # axes are aligned, E falls by a constant factor a step, or less); the last for PATIENT starts of a pose.
    "FEW": 15.0, "MANY": 40.0, "MOST": 1000.0, "CLOSE": 1e-3, "CLOSEST": 1e-6, "PATIENT": 40.0,
    # Steps of each way of repair; the start from which holding is tried where pulling has failed.
    "REPAIR_STEPS": 20.0, "HOLD_FROM": 6.0,
    # [rad or m] An excess up to the first is repaired by holding, also where the arm has no self-motion.
    "SMALL": 1e-4, "LARGE": 1e30, "LARGEST": 1e300,
    # What a rotation may differ from one by (typed or printed numbers); the end of what is taken as a position.
    "ORTHONORMAL": 1e-6, "FAR": 1e5,
    # Adding and subtracting MAGIC rounds to a whole number.
    "MAGIC": 6755399441055744.0,
}  # fmt: skip
"""Constants of the text."""


def layout(n: int, lanes: int) -> dict[str, int]:
    """Whole numbers of the text for n joints: where the rows of the buffer and the settings begin, and their sizes.

    Rows of b: q (n), T (12), repair, flag, next q (n), the measures of the step, the state of the lane, its nearest
    miss (n), the position that solutions shall be near to (n). Settings: `HEAD`; lower, upper, middle, turning (n
    each); the starts.
    """
    rows = {"TARGET": n, "REPAIR": POSE, "NEXT": 2, "MEASURES": n, "STATE": MEASURES, "MISSED": STATE, "NEAR": n}
    places, at = {}, 0
    for name, size in rows.items():
        places[name] = at = at + size
    settings = {"STARTS": 0, "TURNS": 1, "REDUNDANT": 2}
    settings |= {name: HEAD + k * n for k, name in enumerate(("LOWER", "UPPER", "MIDDLE", "TURNING", "TABLE"))}
    state = {"START": START, "STEPS": STEPS, "ALL": ALL, "CODE": CODE, "MISS": MISS, "PLACE": PLACE}
    return {"N": n, "W": lanes, "ROW": n + TAIL, "ROOM": (at + n) * lanes} | places | settings | state


def buffer_size(n: int, lanes: int) -> int:
    """Numbers in the buffer for n joints."""
    return layout(n, lanes)["ROOM"]


@cache
def pose_driver(n: int, lanes: int) -> tree.CText:
    """The text for n joints.

    Its function `search` takes T, T_step, q0, q0_step (below 0: no q0), s, its size, out, b, start, stop: poses from
    start to stop, of 16 numbers T_step apart; each gets a row of `out` as `PoseSearch.rows` gives it.
    """
    text = (files("lwr_dyn.codegen.kernels") / "pose_driver.c").read_text(encoding="utf-8")
    return parsed(with_shared(text, "search"), layout(n, lanes))
