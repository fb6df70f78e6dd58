"""The largest inertia seen at a joint: the maximum of B_ii(q) over the joint box, by a global search.

Along one turning joint B_ii is a trigonometric polynomial of degree two, B_ii = a0 + a1 cos + b1 sin + a2 cos 2 + b2
sin 2, so five values give the whole line and its maximum inside the limits exactly; along a sliding joint it is a
convex parabola, largest at an end. The search climbs coordinate by coordinate with exact line maxima, from every
corner of a 90 deg lattice (thinned where it has more than `LATTICE_MOST`) and from seeded random starts. Climbs along
long flat ridges end early: the best that did not end in the best value are refined by L-BFGS-B before one of them
is called another maximum.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.recursion import inverse_dynamics
from lwr_dyn.dynamics.regressor import chain_with_dynamics
from lwr_dyn.dynamics.seen_inertia import seen_inertia, seen_inertia_along
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.spatial import ZERO

_LINE = 181
"""Points of a line among which Newton's method starts at the best."""

_NODES = 2 * np.pi * np.arange(5) / 5
_WAVES = np.array([np.ones(5), np.cos(_NODES), np.sin(_NODES), np.cos(2 * _NODES), np.sin(2 * _NODES)]).T
"""Five angles of a line, and at each the five waves that B_ii is made of."""

_ROWS = 64
"""Lines whose points are looked at together."""

_STEP = 1e-5
"""[rad or m] Of the central differences of `local_maximum`."""


def diagonal(recursion: Recursion, i: int, q: Array) -> Array:
    """B_ii(q), (...), for q (..., n): the torque at joint i of a unit acceleration of joint i; links before it rest."""
    links = recursion.links[i:]
    if recursion.rotors != "full":
        seen = seen_inertia(links, q[..., i:].reshape(-1, len(links))).reshape(q.shape[:-1])
        return seen + _rotor(recursion, i)
    unit = [1.0] + [0.0] * (len(links) - 1)  # the rotors of links behind it turn with them
    split = [q[..., i + j] for j in range(len(links))]
    tau: Any = inverse_dynamics(links, ZERO, split, [0.0] * len(links), unit, recursion.rotors)[0]
    return np.broadcast_to(np.asarray(tau, dtype=np.float64), q.shape[:-1])


def diagonal_along(recursion: Recursion, i: int, q: Array, j: int, values: Array) -> Array:
    """`diagonal` (k, m) with joint j of the rows q (k, n) at each of m values [rad or m]; j is behind joint i."""
    if recursion.rotors == "full":
        return diagonal(recursion, i, with_joint_values(q, j, values))
    return seen_inertia_along(recursion.links[i:], q[:, i:], j - i, values) + _rotor(recursion, i)


def _rotor(recursion: Recursion, i: int) -> float:
    """Rotor inertia seen at joint i as armature."""
    link = recursion.links[i]
    return link.gear_ratio**2 * link.rotor_inertia if recursion.rotors == "armature" else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class JointInertia:
    """sign B_ii(q) of joint i over the box from `lower` to `upper` (n,); with sign -1 its maxima are minima of B_ii."""

    recursion: Recursion
    kinds: tuple[JointKind, ...]
    joint: int
    lower: Array
    upper: Array
    sign: float = 1.0

    @property
    def moving(self) -> list[int]:
        """Joints that can change the value: those behind joint i that are not held."""
        return [j for j in range(self.joint + 1, len(self.kinds)) if self.upper[j] > self.lower[j]]

    @property
    def content(self) -> str:
        """Everything that the values depend on, apart from the joint and the sign."""
        return repr((self.recursion, self.kinds, self.lower.tolist(), self.upper.tolist()))

    def at(self, q: Array) -> Array:
        """The values (...) [kg m^2; kg for a sliding joint] at q (..., n)."""
        return self.sign * diagonal(self.recursion, self.joint, q)

    def _along(self, q: Array, j: int, values: Array) -> Array:
        """The values (rows, m) at the rows of q with joint j at each of m values."""
        return self.sign * diagonal_along(self.recursion, self.joint, q, j, values)

    def line_maximum(self, q: Array, j: int) -> Array:
        """The q_j (rows,) in its range with the largest value, all else held, for every row of q (rows, n)."""
        if self.kinds[j] is JointKind.PRISMATIC:
            return self._parabola_maximum(q, j)
        samples = self._along(q, j, _NODES)
        a0, a1, b1, a2, b2 = np.linalg.solve(_WAVES, samples.T)
        best = _best_of_line(np.linspace(self.lower[j], self.upper[j], _LINE), a0, a1, b1, a2, b2)
        for _ in range(6):
            c, s, c2, s2 = np.cos(best), np.sin(best), np.cos(2 * best), np.sin(2 * best)
            slope = -a1 * s + b1 * c - 2 * a2 * s2 + 2 * b2 * c2
            curve = -a1 * c - b1 * s - 4 * a2 * c2 - 4 * b2 * s2
            bent = curve < 0.0
            step = np.where(bent, -slope / np.where(bent, curve, -1.0), 0.0)
            best = best + np.minimum(np.maximum(step, -0.05), 0.05)
            best = np.minimum(np.maximum(best, self.lower[j]), self.upper[j])
        flat = np.ptp(samples, axis=-1) <= 1e-13 * np.abs(a0)
        return np.where(flat, q[:, j], best)

    def _parabola_maximum(self, q: Array, j: int) -> Array:
        """The same along a sliding joint: three values give the parabola; its ends or its vertex are best."""
        low, up = self.lower[j], self.upper[j]
        half = (up - low) / 2
        left, middle, right = self._along(q, j, np.array([low, low + half, up])).T
        bend, slope = left - 2 * middle + right, (right - left) / 2
        vertex = np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, -1.0), np.where(right > left, 1.0, -1.0))
        best = low + half * (1.0 + np.clip(vertex, -1.0, 1.0))
        flat = np.abs(bend) + np.abs(slope) <= 1e-13 * np.abs(middle)
        return np.where(flat, q[:, j], best)

    def local_maximum(self, q: Array) -> tuple[Array, float]:
        """The local maximum that L-BFGS-B reaches from q (n,), and the value there."""
        n = len(q)
        steps = _STEP * np.eye(n)

        def descent(x: Array) -> tuple[float, Array]:
            values = -self.at(np.vstack([x, x + steps, x - steps]))
            return float(values[0]), (values[1 : n + 1] - values[n + 1 :]) / (2 * _STEP)

        solution = minimize(
            descent, q, jac=True, method="L-BFGS-B", bounds=list(zip(self.lower, self.upper, strict=True)),
            options={"ftol": 1e-15, "gtol": 1e-12, "maxiter": 500},
        )  # fmt: skip
        return np.clip(solution.x, self.lower, self.upper), -float(solution.fun)


def _best_of_line(x: Array, *wave: Array) -> Array:
    """Where among x (m,) a0 + a1 cos x + b1 sin x + a2 cos 2x + b2 sin 2x is largest, for coefficients (k,) each: (k,).

    Some rows at a time: their values stay in the processor's cache.
    """
    forms, best = (np.cos(x), np.sin(x), np.cos(2 * x), np.sin(2 * x)), np.empty(len(wave[0]))
    term = np.empty((_ROWS, len(x)))
    for at in range(0, len(best), _ROWS):
        a0, first, *others = (weight[at : at + _ROWS, None] for weight in wave)
        line = first * forms[0]
        line += a0  # rounds alike what is as large on both sides of 0: the first of them is taken
        for weight, form in zip(others, forms[1:], strict=True):
            line += np.multiply(weight, form, out=term[: len(line)])
        best[at : at + _ROWS] = x[np.argmax(line, axis=-1)]
    return best


def with_joint_values(q: Array, j: int, values: Array) -> Array:
    """Every row of q (rows, n) with q_j at each of the values, (rows, len(values), n)."""
    out = np.repeat(q[:, None, :], len(values), axis=1)
    out[:, :, j] = values
    return out


RANDOM_STARTS = 128

LATTICE_STARTS = 128
"""Best corners of the lattice that are climbed from; all corners are evaluated."""

LATTICE_MOST = 20000

SEED = 7

SWEEPS = 60
"""Times that a climb may go through all joints."""

SAME = 1e-9
"""Relative: climbs that end within this of the best ended in the best."""

FOLLOWED = 8
"""Number of climbs that ended lower, best first, that are refined."""

SAME_FOLLOWED = 1e-6
"""Relative, for refined climbs, whose end is only as flat as differences of B_ii can show."""

FREE = 1e-5
"""Relative: a joint that changes the value by less, moved alone through its whole range, counts as free; papers print
four digits, and products of 1e-7 kg m^2 would otherwise tie every joint to an odd angle."""

MAXIMISERS_SHOWN = 8

KEPT = 32
"""Arms whose maxima are kept."""

_found: dict[str, dict[int, "InertiaMaximum"]] = {}


@dataclass(frozen=True, slots=True, eq=False)
class InertiaMaximum:
    """max B_ii of one joint: value [kg m^2; kg for a sliding joint], where, and how sure the search is."""

    joint: int
    value: float
    q: Array
    """One maximiser (n,) [rad or m]; free joints at the middle of their range."""
    free: tuple[bool, ...]
    """Joints that do not change the value at the maximiser when moved alone."""
    maximisers: tuple[tuple[float, ...], ...]
    """Distinct maximisers [rad or m], NaN for free joints; at most `MAXIMISERS_SHOWN`."""
    distinct: int
    runner_up: float | None
    """The best value of a refined climb that ended elsewhere: another local maximum, or none."""
    starts: int
    share: float
    """Share of the climbs that ended in the best value."""

    def statement(self) -> str:
        """How it was searched, in one sentence."""
        if self.runner_up is not None:
            rest = f"of the rest, followed on, one in another maximum, {self.runner_up:.8g}"
        elif self.share < 1.0:
            rest = f"the best {FOLLOWED} of the rest, followed on, did too"
        else:
            rest = "no other local maximum was met"
        return (
            f"{self.starts} climbs with exact line maxima over the joint box "
            f"(90 deg lattice and random, seed {SEED}); {self.share:.0%} ended here, {rest}"
        )


def worst_case_inertia(
    arm: Arm, joint: int, fixed: Mapping[int, float] | None = None, smallest: bool = False, starts: Array | None = None
) -> InertiaMaximum:
    """Largest (or smallest) B_ii over the joint box, with the joints in `fixed` held [rad or m].

    With `starts` (k, n) given, the search climbs from there alone: for an arm that is little changed. Raises
    `MissingDataError`: no inertias, or a sliding joint without limits.
    """
    first = first_joint(arm, fixed or {})
    if starts is None and not smallest:
        return _kept(first, joint)
    return _maximum(replace(first, joint=joint, sign=-1.0 if smallest else 1.0), starts)


def worst_case_inertias(arm: Arm) -> tuple[InertiaMaximum, ...]:
    """Every joint's largest inertia; raises as `worst_case_inertia`. Those of the last arms are kept in memory."""
    first = first_joint(arm, {})
    return tuple(_kept(first, i) for i in range(arm.n))


def _kept(first: JointInertia, joint: int) -> InertiaMaximum:
    """The maximum of a joint, searched once as long as the arm is among the last ones."""
    content = first.content
    if content not in _found and len(_found) >= KEPT:
        del _found[next(iter(_found))]
    of_arm = _found.setdefault(content, {})
    if joint not in of_arm:
        of_arm[joint] = _maximum(replace(first, joint=joint))
    return of_arm[joint]


def first_joint(arm: Arm, fixed: Mapping[int, float]) -> JointInertia:
    """The inertia at joint 0 over the joint box."""
    recursion = Recursion.of(chain_with_dynamics(arm))
    lower, upper = arm.lower.copy(), arm.upper.copy()
    for j, link in enumerate(arm.chain.links):
        if not np.isfinite([lower[j], upper[j]]).all():
            if link.kind is JointKind.PRISMATIC:
                raise MissingDataError(arm.name, f"limits of {link.joint}", "its largest inertia")
            lower[j], upper[j] = -np.pi, np.pi
    for j, value in fixed.items():
        lower[j] = upper[j] = value
    return JointInertia(recursion, tuple(link.kind for link in arm.chain.links), 0, lower, upper)


def _maximum(inertia: JointInertia, starts: Array | None = None) -> InertiaMaximum:
    q = _starts(inertia) if starts is None else np.clip(starts, inertia.lower, inertia.upper)
    value, moving, rising = inertia.at(q), inertia.moving, np.arange(len(q))
    for _ in range(SWEEPS):
        at, before = q[rising], value[rising]
        for j in moving:
            at[:, j] = inertia.line_maximum(at, j)
        q[rising], value[rising] = at, inertia.at(at)
        rising = rising[value[rising] - before > 1e-14 * np.abs(value[rising])]  # the others have arrived
        if not rising.size:
            break
    ends = _refine(inertia, q, value)
    others = [x for x in ends if x < value.max() - SAME_FOLLOWED * abs(value.max())]
    best, sign = _summary(inertia, q, value), inertia.sign
    return replace(best, value=sign * best.value, runner_up=sign * max(others) if others else None)


def _starts(inertia: JointInertia) -> Array:
    """The best corners of the 90 deg lattice inside the box, and seeded random points."""
    rng = np.random.default_rng(SEED)
    lower, upper, moving = inertia.lower, inertia.upper, inertia.moving
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
    order = np.argsort(-inertia.at(lattice), kind="stable")
    random = np.tile(middle, (RANDOM_STARTS, 1))
    random[:, moving] = rng.uniform(lower[moving], upper[moving], (RANDOM_STARTS, len(moving)))
    return np.concatenate([lattice[order[:LATTICE_STARTS]], random])


def _refine(inertia: JointInertia, q: Array, value: Array) -> list[float]:
    """Refine the `FOLLOWED` best other maxima in place; return their values and the best one."""
    best = int(np.argmax(value))
    ended_lower = np.flatnonzero(value < value[best] - SAME * abs(value[best]))
    ends = [float(value[best])]
    for k in ended_lower[np.argsort(-value[ended_lower], kind="stable")][:FOLLOWED]:
        at, reached = inertia.local_maximum(q[k])
        if abs(reached - value[best]) <= SAME_FOLLOWED * abs(value[best]):
            at, reached = q[best], float(value[best])
        q[k], value[k] = at, reached
        ends.append(reached)
    return ends


def _summary(inertia: JointInertia, q: Array, value: Array) -> InertiaMaximum:
    """The best of the climbs that ended at q (k, n) with `value` (k,)."""
    lower, upper, k = inertia.lower, inertia.upper, int(np.argmax(value))
    best = float(value[k])
    close = np.abs(value - best) <= SAME * abs(best)
    at, middle = q[k].copy(), (lower + upper) / 2
    free = [True] * len(at)
    for j in inertia.moving:
        line = inertia.at(with_joint_values(q[k][None, :], j, np.linspace(lower[j], upper[j], 9)))
        free[j] = bool(np.ptp(line) <= FREE * abs(best))
    at[free] = middle[free]
    rows = np.where(free, np.nan, np.round(q[close], 2))
    distinct = np.unique(np.where(np.isnan(rows), np.inf, rows + 0.0), axis=0)
    shown = tuple(tuple(float("nan") if np.isinf(x) else float(x) for x in row) for row in distinct[:MAXIMISERS_SHOWN])
    return InertiaMaximum(
        joint=inertia.joint, value=best, q=read_only(at), free=tuple(free), maximisers=shown, distinct=len(distinct),
        runner_up=None, starts=len(q), share=float(np.mean(close)),
    )  # fmt: skip
