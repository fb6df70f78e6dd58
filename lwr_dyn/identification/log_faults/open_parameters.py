"""What a motion leaves open, and which motion would show it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array
from lwr_dyn.identification.log_faults.log_fault import LogFault
from lwr_dyn.identification.log_faults.table_spread import efforts, table_spread
from lwr_dyn.identification.regression.information import Information, solve
from lwr_dyn.identification.regression.normal_equations import NormalEquations, normal_equations
from lwr_dyn.identification.regression.samples import exact_samples
from lwr_dyn.model.arm import Arm

FRICTION = 0.05
"""Share of a joint's torque limit that its friction is known to without a log."""
SIGMAS = 3.0
"""Of a parameter that must be within its spread about the table, or the log says less of it than the table."""
NOISE = 0.01
"""Share of a joint's torque limit that is taken for its noise where a log has no equation of it."""
POSTURES, ROWS = 8, 50
"""Random postures from which joints are moved to see what that shows, and instants of each move."""
SPEED = 0.5
"""Share of a joint's speed (2 rad/s where unknown) that such a move reaches; its acceleration is twice that [1/s]."""
LISTED = 8
"""Parameters that a fault names one by one."""
PAIRS = 4
"""Pairs of joints that a fault names; beyond, all joints must move."""


@dataclass(frozen=True, slots=True)
class OpenParameter:
    """A base parameter (`index`, `statement`) that logs leave open, and `joints` (from 1) whose motion would show it.

    More than one joint: they must move at the same time.
    """

    index: int
    statement: str
    joints: tuple[int, ...]


def open_parameters(information: Information, arm: Arm) -> tuple[OpenParameter, ...]:
    """Base parameters of which logs say less than the table, with the least motion that would show each.

    Tried are moves both ways of one joint, of two at the same time, of all, with the others at rest in several random
    postures, beside what the logs have.
    """
    spread = np.sqrt(np.square(information.base.grouping) @ table_spread(information.columns, arm, FRICTION) ** 2)
    left = set(np.flatnonzero(_open(information, spread)).tolist())
    statements, found = information.base.statements(), dict[int, OpenParameter]()
    noise = np.where(np.isfinite(information.noise), information.noise, NOISE * efforts(arm))
    everything = range(arm.n)
    for joints in (*combinations(everything, 1), *combinations(everything, 2), tuple(everything)):
        if left:
            normal = information.normal + _move(information, arm, joints)
            shown = left - set(np.flatnonzero(_open(_solved(information, normal, noise), spread)).tolist())
            found |= {k: OpenParameter(k, statements[k], tuple(j + 1 for j in joints)) for k in shown}
            left -= shown
    found |= {k: OpenParameter(k, statements[k], ()) for k in left}
    return tuple(found[k] for k in sorted(found))


def _solved(information: Information, normal: NormalEquations, noise: Array) -> Information:
    return solve(normal, information.columns, information.base, noise)


def _open(information: Information, spread: Array) -> NDArray[np.bool_]:
    return np.asarray(SIGMAS * information.sigma > spread)


def _move(information: Information, arm: Arm, joints: Sequence[int]) -> NormalEquations:
    """Normal equations of some joints moved at random, the others at rest."""
    rng, n = np.random.default_rng(0), arm.n
    low, high = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    fastest = SPEED * np.where(np.isfinite(arm.velocity), arm.velocity, 2.0)
    q = np.repeat(rng.uniform(low, high, (POSTURES, n)), ROWS, axis=0)
    dq, ddq = np.zeros(q.shape), np.zeros(q.shape)
    for j in joints:
        q[:, j] = rng.uniform(low[j], high[j], len(q))
        dq[:, j], ddq[:, j] = rng.uniform(-1.0, 1.0, (2, len(q))) * [[fastest[j]], [2 * fastest[j]]]
    samples = exact_samples(0.01 * np.arange(len(q), dtype=np.float64), q, dq, ddq, np.zeros_like(q), 1e-6)
    return normal_equations(samples, information.columns, information.base)


def open_fault(parameters: Iterable[OpenParameter], where: str, count: int) -> tuple[LogFault, ...]:
    """One fault that names open parameters, of `count` in all, and the motion that would show them."""
    several = list(parameters)
    if not several:
        return ()
    names = [one.statement for one in several]
    listed = ", ".join(names[:LISTED]) + (f" and {len(names) - LISTED} more" if len(names) > LISTED else "")
    moves = {one.joints for one in several}
    joints = tuple(sorted({j for move in moves for j in move}))
    found = f"the motion leaves {len(names)} of {count} base parameters open: {listed}"
    return (LogFault("undetermined", joints, where, found, _said(moves)),)


def _said(moves: set[tuple[int, ...]]) -> str:
    """The moves, those of one joint in one phrase; no pairs where all joints must move together anyway."""
    single = [str(move[0]) for move in sorted(moves) if len(move) == 1]
    pairs = [f"{move[0]} and {move[1]}" for move in sorted(moves) if len(move) == 2]
    whole = any(len(move) > 2 for move in moves) or len(pairs) > PAIRS
    parts = []
    if single:
        joints = f"joint{'s' if len(single) > 1 else ''} {', '.join(single)}"
        parts.append(f"{joints} moved both ways, the others in several postures")
    if pairs and not whole:
        parts.append(f"joints {', '.join(pairs)} moved at the same time")
    if whole:
        parts.append("all joints moved at the same time")
    return "; ".join(parts) or "a log with less noise"
