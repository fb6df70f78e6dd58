"""The search for one motion: starts, the best of them searched further, and what its check asks to be done again.

A start is sequential quadratic programming on the coordinates of the series. Limits of positions and speeds are linear
in them; distances and, where they bind, torques are not. All hold at instants of the motion; what they leave between
them is met by `MotionLimits.fitted` and by a buffer on distances. Some pairs are never far apart, such as two links of
which only a short one is between: a buffer takes at most `SHARE_OF_WIDEST` of what they can have.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.excitation import objectives
from lwr_dyn.identification.excitation.motion_limits import Clearance, MotionLimits, TorqueUse
from lwr_dyn.identification.excitation.room import widest_distances
from lwr_dyn.identification.excitation.watch import FOR_ALL, FOR_STARTS, SearchEnd, SearchWatch
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm

DRAWS, NEAR = 200, -0.05
"""Random motions of which a start takes the first that is not nearer than this [m], or else the clearest."""
OUTSIDE = 1e-2
"""[rad, m, rad/s, shares] Up to here outside of the limits an iterate of the search may be kept."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchSpace:
    """The objective and all that a motion must keep, at the instants of `basis`.

    `buffer` [m], one or (m,) one a pair, is added to what distances keep; `torque` is None where torques do not bind.
    """

    objective: objectives.MotionObjective
    basis: objectives.FourierBasis
    limits: MotionLimits
    clearance: Clearance
    buffer: float | Array = 0.02
    torque: TorqueUse | None = None
    _linear: Array = field(init=False)
    _room: Array = field(init=False)
    _scale: Array = field(init=False)

    def __post_init__(self) -> None:
        n, k, at = len(self.limits.speed), len(self.basis.position), self.limits
        q, dq = (np.kron(part, np.eye(n)) for part in (self.basis.position, self.basis.speed))
        travel = at.upper - at.lower
        room, scale = (at.upper, -at.lower, at.speed, at.speed), (travel, travel, at.speed, at.speed)
        object.__setattr__(self, "_linear", np.vstack([-q, q, -dq, dq]))
        object.__setattr__(self, "_room", np.concatenate([np.tile(x, k) for x in room]))
        object.__setattr__(self, "_scale", np.concatenate([np.tile(x, k) for x in scale]))

    def slack(self, x: Array) -> Array:
        """Distance from every limit, (r,), below 0 outside: positions, speeds, distances, then torques as shares."""
        return np.concatenate([self._room + self._linear @ x, self._curved(x)])

    def solve(
        self, x: Array, rounds: int, tolerance: float, near: float = np.inf, reach: float = np.inf,
        watch: SearchWatch | None = None, share: float = FOR_ALL,
    ) -> Array:  # fmt: skip
        """The best coordinates that a search from x (b n,) met inside the limits; the nearest to it if it met none.

        Limits of positions and speeds that x is further away from than `near`, a share of the travel or of the limit,
        are left out of the search, and so are distances of more than `reach` [m]: a start that is nearly at its end
        does not come to them, and each costs time. An iterate that comes to them all the same is not kept. The search
        ends where `watch` says so, at this `share` of its time.
        """
        best = _Best(self, x, watch or SearchWatch(), share, rounds)
        rows = self._room + self._linear @ x < near * self._scale
        slope, room = self._linear[rows], self._room[rows]
        linear = {"type": "ineq", "fun": lambda x: room + slope @ x, "jac": lambda _: slope}
        bent = self._within(x, reach)
        curved = {
            "type": "ineq",
            "fun": lambda x: self._curved(x)[bent],
            "jac": lambda x: self._curved_gradient(x, bent),
        }
        options = {"maxiter": rounds, "ftol": tolerance}
        solve: Any = minimize  # its stubs know no function that gives value and gradient with constraints
        terms = [linear, curved]
        try:
            end = solve(best.value_of, x, method="SLSQP", jac=True, constraints=terms, options=options, callback=best)
        except SearchEnd:
            return best.x
        best(end.x)
        return best.x

    def _curved(self, x: Array) -> Array:
        X = x.reshape(self.basis.count, -1)
        distances = self.clearance.of(self.basis.position @ X) - self.buffer
        return np.append(distances.ravel(), [] if self.torque is None else self.torque.room(self.basis, X).ravel())

    def _within(self, x: Array, reach: float) -> NDArray[np.bool_]:
        """The rows of `_curved` that a search from x takes: distances within `reach`, and all torques."""
        values = self._curved(x)
        count = len(self.basis.position) * len(self.clearance.names)
        return np.asarray((values < reach) | (np.arange(len(values)) >= count))

    def _curved_gradient(self, x: Array, rows: NDArray[np.bool_]) -> Array:
        X = x.reshape(self.basis.count, -1)
        _, slope = self.clearance.with_gradient(self.basis.position @ X)
        k, m, n = slope.shape
        kept = rows[: k * m]
        parts = np.repeat(self.basis.position, m, axis=0)[kept]
        out = np.einsum("rj,rc->rcj", slope.reshape(-1, n)[kept], parts).reshape(-1, x.size)
        return out if self.torque is None else np.vstack([out, self.torque.room_gradient(self.basis, X)])


class _Best:
    """The best iterate inside the limits: a search may end outside, after a step to a degenerate motion.

    Where none was inside, it is the one that is least outside.
    """

    def __init__(self, space: SearchSpace, x: Array, watch: SearchWatch, share: float, rounds: int) -> None:
        self.space, self.x, self.watch, self.share, self.rounds = space, x, watch, share, rounds
        self.rank = self._outside(x), objectives.LARGE
        self.last = x, objectives.LARGE
        self.round = 0

    def value_of(self, x: Array) -> tuple[float, Array]:
        """The objective with its gradient; the last value is kept. Raises `SearchEnd`."""
        if self.watch.is_over(self.share):
            raise SearchEnd
        value, gradient = self.space.objective(x)
        self.last = np.array(x), value
        return value, gradient

    def __call__(self, x: Array) -> None:
        """Keep x if it is better; a round is done."""
        self.round += 1
        self.watch.inside(self.round / self.rounds)
        if not np.isfinite(x).all():
            return
        outside = self._outside(x)
        if outside > self.rank[0]:
            return
        if not np.array_equal(x, self.last[0]):
            self.last = np.array(x), self.space.objective(x)[0]
        if (outside, self.last[1]) < self.rank:
            self.x, self.rank = self.last[0], (outside, self.last[1])

    def _outside(self, x: Array) -> float:
        """By how much x is further outside than it may be."""
        return max(0.0, float(-self.space.slack(x).min(initial=np.inf)) - OUTSIDE)


def random_start(space: SearchSpace, rng: np.random.Generator) -> Array:
    """Coordinates (b, n) of a random motion that fills its limits and is nearly clear."""
    n, basis = len(space.limits.speed), space.basis
    found: list[tuple[float, Array]] = []
    for _ in range(DRAWS):
        X = rng.normal(size=(basis.count, n))
        X[0] = rng.uniform(space.limits.lower, space.limits.upper)
        X = space.limits.fitted(X, basis, fill=True)
        found.append((float(space.clearance.of(basis.position @ X).min(initial=np.inf)), X))
        if found[-1][0] > NEAR:
            break
    return max(found, key=lambda x: x[0])[1]


CHECK_RATE = 1000.0
"""[Hz] At which limits and distances of a motion are checked."""
MOST_CHECKS = 200_000
"""Instants of a check at most: a motion that takes longer than 200 s is checked at a lower rate."""
POLISHED = 2
"""How many of the best starts are searched further."""
REPAIRS = 4
"""How often a motion that its check refuses is searched again."""
HOPELESS = -0.1
"""[m] A motion that is nearer than this, less what is to be kept, is not searched again."""
BUFFER, MORE = 0.02, 0.005
"""[m] Added to what distances keep at the instants of the search, and beyond what a check found missing."""
SHARE_OF_WIDEST = 0.3
"""Of a pair's largest distance in drawn poses, less what is kept: a buffer is at most this."""


@dataclass(frozen=True, slots=True)
class Resolution:
    """Instants of the objective and of the limits in a period of the highest harmonic; when SLSQP ends.

    `near` and `reach`: which limits and distances it sees, as `SearchSpace.solve` takes them.
    """

    objective: int
    limits: int
    rounds: int
    tolerance: float
    near: float
    reach: float


COARSE, FINE = Resolution(14, 12, 60, 2e-4, np.inf, np.inf), Resolution(22, 26, 150, 1e-6, 0.25, 0.15)
"""Of a start, and of the best ones."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchedMotion:
    """What a search came to: coordinates X (b, n) of a motion inside the limits of position and speed."""

    X: Array
    value: float
    """Of the objective."""
    clear: float
    """[m] The least distance less what is kept."""
    torque: float
    """A share of the limits."""
    seconds: float = 0.0

    @property
    def good(self) -> bool:
        """Whether it may go out."""
        return self.clear >= 0.0 and self.torque <= 1.0


@dataclass(frozen=True, slots=True, eq=False)
class MotionDesign:
    """What is designed, for what, and what it must keep."""

    arm: Arm
    duration: float
    harmonics: int
    objective: objectives.ObjectiveName
    noise: Array
    columns: TorqueColumns
    limits: MotionLimits
    clearance: Clearance
    watch: SearchWatch = field(default_factory=SearchWatch)
    torques: TorqueUse = field(init=False)
    widest: Array = field(init=False)
    """(m,) [m] The largest distance of each pair in drawn poses, less what is kept."""
    check: objectives.FourierBasis = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "torques", TorqueUse.of(self.arm, self.limits.torque))
        object.__setattr__(self, "widest", widest_distances(self.clearance, self.limits))
        objectives.fourier_basis(self.duration, self.harmonics, 1)  # refuse bad numbers before they size an array
        instants = int(min(MOST_CHECKS, max(self.duration * CHECK_RATE, 20.0 * self.harmonics)))
        object.__setattr__(self, "check", objectives.fourier_basis(self.duration, self.harmonics, instants))

    @property
    def check_rate(self) -> float:
        """[Hz] Of the instants at which limits and distances are checked."""
        return len(self.check.position) / self.duration

    def start(self, rng: np.random.Generator) -> SearchedMotion:
        """What the search from a random motion comes to, checked."""
        begin = self.watch.elapsed
        space = self._space(COARSE)
        found = self._judged(self._solved(space, random_start(space, rng), COARSE, FOR_STARTS))
        self.watch.step_done()
        return replace(found, seconds=self.watch.elapsed - begin)

    def best_of(self, found: Sequence[SearchedMotion]) -> SearchedMotion:
        """The best of `POLISHED` starts searched further, or of as many as it takes.

        Where none is inside the limits and clear, it is the one that comes nearest to it.
        """
        good: list[SearchedMotion] = []
        ended = [*found]
        for one in sorted(found, key=lambda one: one.value):
            if len(good) == POLISHED or self.watch.is_over():
                break
            if one.clear >= HOPELESS:
                self.watch.step(f"best starts, {len(good) + 1} of {min(POLISHED, len(found))}")
                ended.append(self.refined(one))
                good += [ended[-1]] if ended[-1].good else []
            self.watch.step_done()
        return best_motion(ended)

    def refined(self, one: SearchedMotion) -> SearchedMotion:
        """The start searched on finer instants, and again with what its check found missing."""
        buffer, torque, best = BUFFER, 1.0 if one.torque > 1.0 else np.inf, one
        tried: list[SearchedMotion] = []
        for _ in range(REPAIRS):
            best = self._judged(self._solved(self._space(FINE, buffer, torque), best.X, FINE))
            tried.append(best)
            if best.good or best.clear < HOPELESS or self.watch.is_over():
                break
            buffer += MORE + max(0.0, -best.clear)
            torque = min(torque, 1.0) / max(best.torque + 0.01, 1.0) if best.torque > 1.0 else torque
        return best_motion(tried)

    def faults(self, X: Array) -> tuple[str, ...]:
        """Why the motion may not be run, in words: what is too near when, joints whose torque is too large."""
        q, dq, ddq = self.states(X)
        distances = self.clearance.of(q)
        said = []
        if distances.size and distances.min() < 0.0:
            k, pair = np.unravel_index(int(np.argmin(distances)), distances.shape)
            missing, when, kept = -distances[k, pair], k / self.check_rate, self.clearance.keeps[pair]
            said.append(
                f"{self.clearance.names[pair]} are {missing:.3g} m too near at {when:.2f} s: {kept:.3g} m is to be kept"
            )
        share = self.torques.share(q, dq, ddq)
        for name, x in zip(self.arm.joint_names, share, strict=True):
            said += [f"{name} needs {x:.6g} times the torque that it may use"] if x > 1.0 else []
        return tuple(said)

    def states(self, X: Array) -> tuple[Array, Array, Array]:
        """q, dq, ddq (k, n) at the instants of the check."""
        return self.check.position @ X, self.check.speed @ X, self.check.acceleration @ X

    def _space(self, size: Resolution, buffer: float = BUFFER, torque: float = np.inf) -> SearchSpace:
        basis, limits = (
            objectives.fourier_basis(self.duration, self.harmonics, k * self.harmonics)
            for k in (size.objective, size.limits)
        )
        objective = objectives.MotionObjective(self.columns, basis, self.noise, self.objective)
        use = replace(self.torques, limit=torque * self.limits.torque) if np.isfinite(torque) else None
        buffers = np.minimum(buffer, SHARE_OF_WIDEST * np.maximum(self.widest, 0.0))
        return SearchSpace(objective, limits, self.limits, self.clearance, buffers, use)

    def _solved(self, space: SearchSpace, X: Array, size: Resolution, share: float = FOR_ALL) -> Array:
        found = space.solve(X.ravel(), size.rounds, size.tolerance, size.near, size.reach, self.watch, share)
        return found.reshape(X.shape)

    def _judged(self, X: Array) -> SearchedMotion:
        X = self.limits.fitted(X, self.check)
        q, dq, ddq = self.states(X)
        value, _ = self._space(FINE).objective(X.ravel())
        clear = float(self.clearance.of(q).min(initial=np.inf))
        return SearchedMotion(X, value, clear, float(self.torques.share(q, dq, ddq).max()))


def best_motion(found: Sequence[SearchedMotion]) -> SearchedMotion:
    """The good one of the least value; where none is good, the one that comes nearest to it."""
    good = [one for one in found if one.good]
    if good:
        return min(good, key=lambda one: one.value)
    return max(found, key=lambda one: min(one.clear, 1.0 - one.torque))
