"""The search for one motion: starts, the best of them searched further, and what its check asks to be done again.

A start is sequential quadratic programming on the coordinates of the series. Limits of positions and speeds are linear
in them; distances and, where they bind, torques are not. All hold at instants of the motion; what they leave between
them is met by `MotionLimits.fitted` and by a buffer on distances.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
from scipy.optimize import minimize

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FaultError, OptionError
from lwr_dyn.identification.excitation import objectives
from lwr_dyn.identification.excitation.motion_limits import Clearance, MotionLimits, TorqueUse, random_positions
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.kinematics.forward import joint_axes
from lwr_dyn.model.arm import Arm

DRAWS, NEAR = 200, -0.05
"""Random motions of which a start takes the first that is not nearer than this [m], or else the clearest."""
OUTSIDE = 1e-2
"""[rad, m, rad/s, shares] Up to here outside of the limits an iterate of the search may be kept."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchSpace:
    """The objective and all that a motion must keep, at the instants of `basis`.

    `buffer` [m] is added to what distances keep; `torque` is None where torques do not bind.
    """

    objective: objectives.MotionObjective
    basis: objectives.FourierBasis
    limits: MotionLimits
    clearance: Clearance
    buffer: float = 0.02
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

    def solve(self, x: Array, rounds: int, tolerance: float, near: float = np.inf) -> Array:
        """The best coordinates that a search from x (b n,) met inside the limits; x itself if it met none.

        Limits of positions and speeds that x is further away from than `near`, a share of the travel or of the limit,
        are left out of the search: a start that is nearly at its end does not come to them, and each costs time.
        """
        best = _Best(self, x)
        rows = self._room + self._linear @ x < near * self._scale
        slope, room = self._linear[rows], self._room[rows]
        linear = {"type": "ineq", "fun": lambda x: room + slope @ x, "jac": lambda _: slope}
        curved = {"type": "ineq", "fun": self._curved, "jac": self._curved_gradient}
        options = {"maxiter": rounds, "ftol": tolerance}
        solve: Any = minimize  # its stubs know no function that gives value and gradient with constraints
        terms = [linear, curved]
        end = solve(best.value_of, x, method="SLSQP", jac=True, constraints=terms, options=options, callback=best)
        best(end.x)
        return best.x

    def _curved(self, x: Array) -> Array:
        X = x.reshape(self.basis.count, -1)
        distances = self.clearance.of(self.basis.position @ X) - self.buffer
        return np.append(distances.ravel(), [] if self.torque is None else self.torque.room(self.basis, X).ravel())

    def _curved_gradient(self, x: Array) -> Array:
        X = x.reshape(self.basis.count, -1)
        _, slope = self.clearance.with_gradient(self.basis.position @ X)
        out = np.einsum("kmj,kc->kmcj", slope, self.basis.position).reshape(-1, x.size)
        return out if self.torque is None else np.vstack([out, self.torque.room_gradient(self.basis, X)])


class _Best:
    """The best iterate inside the limits: a search may end outside, after a step to a degenerate motion."""

    def __init__(self, space: SearchSpace, x: Array) -> None:
        self.space, self.x, self.value = space, x, objectives.LARGE
        self.last = x, objectives.LARGE

    def value_of(self, x: Array) -> tuple[float, Array]:
        """The objective with its gradient; the last value is kept."""
        value, gradient = self.space.objective(x)
        self.last = np.array(x), value
        return value, gradient

    def __call__(self, x: Array) -> None:
        """Keep x if it is better."""
        if np.isfinite(x).all() and self.space.slack(x).min() > -OUTSIDE:
            if not np.array_equal(x, self.last[0]):
                self.value_of(x)
            if self.last[1] < self.value:
                self.x, self.value = self.last


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


@dataclass(frozen=True, slots=True)
class Resolution:
    """Instants of the objective and of the limits in a period of the highest harmonic; when SLSQP ends.

    `near`: which limits it sees, as `SearchSpace.solve` takes it.
    """

    objective: int
    limits: int
    rounds: int
    tolerance: float
    near: float


COARSE, FINE = Resolution(14, 12, 60, 2e-4, np.inf), Resolution(22, 26, 150, 1e-6, 0.25)
"""Of a start, and of the best ones."""


class ExcitationError(FaultError, ValueError):
    """No start ended in a motion that is inside the limits and clear."""


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
    torques: TorqueUse = field(init=False)
    check: objectives.FourierBasis = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "torques", TorqueUse.of(self.arm, self.limits.torque))
        objectives.fourier_basis(self.duration, self.harmonics, 1)  # refuse bad numbers before they size an array
        instants = int(min(MOST_CHECKS, max(self.duration * CHECK_RATE, 20.0 * self.harmonics)))
        object.__setattr__(self, "check", objectives.fourier_basis(self.duration, self.harmonics, instants))

    @property
    def check_rate(self) -> float:
        """[Hz] Of the instants at which limits and distances are checked."""
        return len(self.check.position) / self.duration

    def start(self, rng: np.random.Generator) -> SearchedMotion:
        """What the search from a random motion comes to, checked."""
        begin = perf_counter()
        space = self._space(COARSE)
        X = self._solved(space, random_start(space, rng), COARSE)
        return self._judged(X, perf_counter() - begin)

    def best_of(self, found: Sequence[SearchedMotion]) -> SearchedMotion:
        """The best of `POLISHED` starts searched further, or of as many as it takes.

        Raises
        ------
        ExcitationError
            None of them came out inside the limits and clear; says how near the nearest was.
        """
        good: list[SearchedMotion] = []
        ended: list[SearchedMotion] = []
        for one in sorted(found, key=lambda one: one.value):
            ended.append(one if one.clear < HOPELESS else self.refined(one))
            good += [ended[-1]] if ended[-1].good else []
            if len(good) == POLISHED:
                break
        if not good:
            near = max(ended, key=lambda one: min(one.clear, 1.0 - one.torque))
            words = f"the best of {len(found)} starts is {-near.clear:.3g} m too near something"
            if near.clear >= 0.0:
                words = f"the best of {len(found)} starts needs {near.torque:.3g} times the torque that it may use"
            raise ExcitationError(f"excitation of {self.arm.name}", words, "more starts, a longer motion, less to keep")
        return min(good, key=lambda one: one.value)

    def refined(self, one: SearchedMotion) -> SearchedMotion:
        """The start searched on finer instants, and again with what its check found missing."""
        buffer, torque, best = BUFFER, 1.0 if one.torque > 1.0 else np.inf, one
        for _ in range(REPAIRS):
            best = self._judged(self._solved(self._space(FINE, buffer, torque), best.X, FINE))
            if best.good or best.clear < HOPELESS:
                break
            buffer += MORE + max(0.0, -best.clear)
            torque = min(torque, 1.0) / max(best.torque + 0.01, 1.0) if best.torque > 1.0 else torque
        return best

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
        return SearchSpace(objective, limits, self.limits, self.clearance, buffer, use)

    def _solved(self, space: SearchSpace, X: Array, size: Resolution) -> Array:
        return space.solve(X.ravel(), size.rounds, size.tolerance, size.near).reshape(X.shape)

    def _judged(self, X: Array, seconds: float = 0.0) -> SearchedMotion:
        X = self.limits.fitted(X, self.check)
        q, dq, ddq = self.states(X)
        value, _ = self._space(FINE).objective(X.ravel())
        clear = float(self.clearance.of(q).min(initial=np.inf))
        return SearchedMotion(X, value, clear, float(self.torques.share(q, dq, ddq).max()), seconds)


POSES = 2000
"""Random poses; where all are far from clear, no search is begun."""


def check_room(clearance: Clearance, column: float | None = None) -> None:
    """Raise where nothing can be clear.

    Raises
    ------
    OptionError
        A `column` [m] that was asked for holds the whole arm inside in most poses.
    ExcitationError
        Each of `POSES` random poses is more than `HOPELESS` too near something.
    """
    if column and len(links_inside(clearance)) == len(clearance.capsules) - 1:
        raise OptionError("column", column, "a radius in m that does not hold the whole arm inside")
    distances = clearance.of(random_positions(clearance.arm, POSES, np.random.default_rng(0)))
    if not distances.size:
        return
    nearest = distances.min(axis=1)
    best = int(np.argmax(nearest))
    if nearest[best] < HOPELESS:
        name = clearance.names[int(np.argmin(distances[best]))]
        words = f"the clearest of {POSES} random poses is {-nearest[best]:.3g} m too near ({name})"
        raise ExcitationError(f"excitation of {clearance.arm.name}", words, "a lower floor, or less to keep")


def links_inside(clearance: Clearance) -> tuple[str, ...]:
    """Links that are not held against the column: those beside it, and those inside it in most poses."""
    if not _has_column(clearance):
        return ()
    held = {b for a, b in clearance.pairs if a == 0}
    return tuple(
        clearance.arm.chain.links[start].link for b, (start, _) in enumerate(clearance.capsules) if b and b not in held
    )


def column_words(clearance: Clearance) -> str:
    """How thick the column is, to which height it reaches, and what is not held against it; empty without one."""
    if not _has_column(clearance):
        return ""
    arm, radius = clearance.arm, clearance.radii[0]
    top = float(joint_axes(arm.chain, np.zeros((1, arm.n))).p[0, 0, 2])
    inside = links_inside(clearance)
    but = f"; not held against it (next to it, or inside in most poses): {', '.join(inside)}" if inside else ""
    return f"column of radius {radius:.3g} m up to {arm.joint_names[0]} at {top:.3g} m, rounded above it{but}"


def _has_column(clearance: Clearance) -> bool:
    return bool(clearance.capsules) and clearance.capsules[0] == (0, clearance.arm.n + 1)
