"""The largest inertia a joint can feel: max over the joint box of B_ii(q), found by a stated global search.

Along one turning joint B_ii is a trigonometric polynomial of degree two, B_ii = a0 + a1 cos + b1 sin + a2 cos 2 + b2
sin 2, so five values give the whole line and its maximum inside the limits exactly; along a sliding joint it is a
convex parabola, largest at an end. The search climbs coordinate by coordinate with exact line maxima, from every
corner of a 90 deg lattice and from seeded random starts.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.arm import Arm
from lwr_dyn.arrays import Array
from lwr_dyn.dh import JointKind
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.recursion import inverse_dynamics
from lwr_dyn.errors import MissingDataError
from lwr_dyn.vectors import ZERO

RANDOM_STARTS = 128
LATTICE_STARTS = 128
"""Best corners of the lattice that are climbed from; all corners are evaluated."""
LATTICE_MOST = 20000
SEED = 7
SAME = 1e-9
"""Relative: climbs that end within this of the best ended in the best."""
FREE = 1e-5
"""Relative: a joint that changes the value by less, moved alone through its whole range, counts as free; papers print
four digits, and products of 1e-7 kg m^2 would otherwise tie every joint to an odd angle."""
_LINE = 181
"""Points on which a line's maximum is looked for before Newton's method sharpens it."""


@dataclass(frozen=True, slots=True, eq=False)
class WorstCase:
    """max B_ii of one joint: value [kg m^2], where, and how sure the search is."""

    joint: int
    value: float
    q: Array
    """One maximiser (n,) [rad]; free joints at the middle of their range."""
    free: tuple[bool, ...]
    """Joints that do not change the value at the maximiser when moved alone."""
    maximisers: tuple[tuple[float, ...], ...]
    """Distinct maximisers found [rad], NaN for free joints; at most `MAXIMISERS_SHOWN`."""
    distinct: int
    runner_up: float | None
    """The next best value a climb ended in: another local maximum, or none."""
    starts: int
    share: float
    """Share of the climbs that ended in the best value."""

    def statement(self) -> str:
        """How it was searched, in one sentence."""
        second = "no other local maximum was met" if self.runner_up is None else f"next best {self.runner_up:.6g}"
        return (
            f"{self.starts} climbs with exact line maxima over the joint box "
            f"(90 deg lattice and random, seed {SEED}); {self.share:.0%} ended here, {second}"
        )


MAXIMISERS_SHOWN = 8


def diagonal(recursion: Recursion, i: int, q: Array) -> Array:
    """B_ii(q), (...), for q (..., n): the torque at joint i of a unit acceleration of joint i."""
    n = len(recursion.links)
    unit = [1.0 if j == i else 0.0 for j in range(n)]
    split = [q[..., j] for j in range(n)]
    tau: Any = inverse_dynamics(recursion.links, ZERO, split, [0.0] * n, unit, recursion.rotors)[i]
    return np.broadcast_to(np.asarray(tau, dtype=np.float64), q.shape[:-1])


def worst_case_inertia(
    arm: Arm, joint: int, fixed: Mapping[int, float] | None = None, smallest: bool = False, starts: Array | None = None
) -> WorstCase:
    """Largest (or smallest) B_ii over the joint box, with the joints in `fixed` held [rad].

    With `starts` (k, n) given, it is climbed from there alone: for an arm that is little changed.

    Raises
    ------
    MissingDataError
        No inertias, or a sliding joint without limits.
    """
    recursion = Recursion.of(arm.require_dynamics())
    lower, upper = _box(arm, fixed or {})
    sign = -1.0 if smallest else 1.0
    moving = [j for j in range(arm.n) if j > joint and upper[j] > lower[j]]
    q = _starts(recursion, joint, lower, upper, moving, sign) if starts is None else np.clip(starts, lower, upper)
    kinds = [link.kind for link in arm.chain.links]
    value = sign * diagonal(recursion, joint, q)
    for _ in range(60):
        before = value
        for j in moving:
            q[:, j] = _best_on_line(recursion, joint, q, j, kinds[j], (lower[j], upper[j]), sign)
        value = sign * diagonal(recursion, joint, q)
        if np.all(value - before <= 1e-14 * np.abs(value)):
            break
    return _result(recursion, joint, q, sign * value, lower, upper, moving, sign)


def worst_cases(arm: Arm) -> tuple[WorstCase, ...]:
    """Every joint's largest inertia; raises as `worst_case_inertia`."""
    return tuple(worst_case_inertia(arm, i) for i in range(arm.n))


def _box(arm: Arm, fixed: Mapping[int, float]) -> tuple[Array, Array]:
    lower, upper = arm.lower.copy(), arm.upper.copy()
    for j, link in enumerate(arm.chain.links):
        if not np.isfinite([lower[j], upper[j]]).all():
            if link.kind is JointKind.PRISMATIC:
                raise MissingDataError(arm.name, f"limits of {link.joint}", "its largest inertia")
            lower[j], upper[j] = -np.pi, np.pi
    for j, value in fixed.items():
        lower[j] = upper[j] = value
    return lower, upper


def _starts(recursion: Recursion, i: int, lower: Array, upper: Array, moving: list[int], sign: float) -> Array:
    """The best corners of the 90 deg lattice inside the box, and seeded random points."""
    rng = np.random.default_rng(SEED)
    middle = (lower + upper) / 2
    quarter = np.pi / 2
    axes = [[x for x in quarter * np.arange(-4, 5) if lower[j] <= x <= upper[j]] or [middle[j]] for j in moving]
    while np.prod([len(a) for a in axes]) > LATTICE_MOST:
        widest = max(range(len(axes)), key=lambda k: len(axes[k]))
        axes[widest] = axes[widest][::2] if len(axes[widest]) > 1 else axes[widest]
    points = list(itertools.product(*axes))
    corners = np.array(points, dtype=np.float64).reshape(len(points), len(moving))
    lattice = np.tile(middle, (len(corners), 1))
    lattice[:, moving] = corners
    order = np.argsort(-sign * diagonal(recursion, i, lattice), kind="stable")
    random = np.tile(middle, (RANDOM_STARTS, 1))
    random[:, moving] = rng.uniform(lower[moving], upper[moving], (RANDOM_STARTS, len(moving)))
    return np.concatenate([lattice[order[:LATTICE_STARTS]], random])


def _best_on_line(
    recursion: Recursion, i: int, q: Array, j: int, kind: JointKind, span: tuple[float, float], sign: float
) -> Array:
    """The q_j in its range that makes sign B_ii largest, all else held, for every row of q."""
    low, up = span
    if kind is JointKind.PRISMATIC:
        return _best_on_parabola(recursion, i, q, j, span, sign)
    nodes = 2 * np.pi * np.arange(5) / 5
    samples = sign * diagonal(recursion, i, _moved(q, j, nodes))
    wave = np.array([np.ones(5), np.cos(nodes), np.sin(nodes), np.cos(2 * nodes), np.sin(2 * nodes)])
    a0, a1, b1, a2, b2 = np.linalg.solve(wave.T, samples.T)
    x = np.linspace(low, up, _LINE)
    line = a0[:, None] + np.outer(a1, np.cos(x)) + np.outer(b1, np.sin(x)) + np.outer(a2, np.cos(2 * x))
    line += np.outer(b2, np.sin(2 * x))
    best = x[np.argmax(line, axis=-1)]
    for _ in range(6):
        c, s, c2, s2 = np.cos(best), np.sin(best), np.cos(2 * best), np.sin(2 * best)
        slope = -a1 * s + b1 * c - 2 * a2 * s2 + 2 * b2 * c2
        curve = -a1 * c - b1 * s - 4 * a2 * c2 - 4 * b2 * s2
        step = np.where(curve < 0.0, -slope / np.where(curve < 0.0, curve, -1.0), 0.0)
        best = np.clip(best + np.clip(step, -0.05, 0.05), low, up)
    flat = np.ptp(samples, axis=-1) <= 1e-13 * np.abs(a0)
    return np.where(flat, q[:, j], best)


def _best_on_parabola(recursion: Recursion, i: int, q: Array, j: int, span: tuple[float, float], sign: float) -> Array:
    """The same along a sliding joint: three values give the parabola; its ends or its vertex are best."""
    low, up = span
    half = (up - low) / 2
    left, middle, right = (sign * diagonal(recursion, i, _moved(q, j, np.array([low, low + half, up])))).T
    bend, slope = left - 2 * middle + right, (right - left) / 2
    vertex = np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, -1.0), np.where(right > left, 1.0, -1.0))
    places = np.stack([np.full(len(q), -1.0), np.clip(vertex, -1.0, 1.0), np.full(len(q), 1.0)], axis=-1)
    values = middle[:, None] + slope[:, None] * places + bend[:, None] / 2 * places**2
    best = low + half * (1.0 + places[np.arange(len(q)), np.argmax(values, axis=-1)])
    flat = np.abs(bend) + np.abs(slope) <= 1e-13 * np.abs(middle)
    return np.where(flat, q[:, j], best)


def _moved(q: Array, j: int, values: Array) -> Array:
    """Every row of q with q_j at each of the values, (rows, len(values), n)."""
    out = np.repeat(q[:, None, :], len(values), axis=1)
    out[:, :, j] = values
    return out


def _result(
    recursion: Recursion, i: int, q: Array, value: Array, lower: Array, upper: Array, moving: list[int], sign: float
) -> WorstCase:
    k = int(np.argmax(sign * value))
    best = float(value[k])
    close = np.abs(value - best) <= SAME * abs(best)
    others = value[~close]
    at, middle = q[k].copy(), (lower + upper) / 2
    free = [True] * len(at)
    for j in moving:
        line = diagonal(recursion, i, _moved(q[k][None, :], j, np.linspace(lower[j], upper[j], 9)))
        free[j] = bool(np.ptp(line) <= FREE * abs(best))
    at[free] = middle[free]
    rows = np.where(free, np.nan, np.round(q[close], 2))
    distinct = np.unique(np.where(np.isnan(rows), np.inf, rows + 0.0), axis=0)
    shown = tuple(tuple(float("nan") if np.isinf(x) else float(x) for x in row) for row in distinct[:MAXIMISERS_SHOWN])
    return WorstCase(
        joint=i, value=best, q=at, free=tuple(free), maximisers=shown, distinct=len(distinct),
        runner_up=float(others[np.argmax(sign * others)]) if len(others) else None,
        starts=len(q), share=float(np.mean(close)),
    )  # fmt: skip
