"""The search for one motion: starts, the best of them searched further, and what its check asks to be done again."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FaultError
from lwr_dyn.identification.excitation.clearance import Clearance
from lwr_dyn.identification.excitation.fourier import FourierBasis, FourierMotion, fourier_basis
from lwr_dyn.identification.excitation.motion_limits import MotionLimits
from lwr_dyn.identification.excitation.objectives import MotionObjective, ObjectiveName
from lwr_dyn.identification.excitation.search import SearchSpace, random_start
from lwr_dyn.identification.excitation.torque_use import TorqueUse
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm

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


@dataclass(frozen=True, slots=True)
class StartSummary:
    """What one start came to: the objective, the least distance less what is kept [m], its time [s]."""

    value: float
    clear: float
    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class SearchedMotion:
    """A motion by its coordinates X (b, n), inside the limits of position and speed; `torque` is a share of them."""

    X: Array
    value: float
    clear: float
    torque: float
    seconds: float = 0.0

    @property
    def good(self) -> bool:
        """Whether it may go out."""
        return self.clear >= 0.0 and self.torque <= 1.0

    @property
    def summary(self) -> StartSummary:
        """Without the motion."""
        return StartSummary(self.value, self.clear, self.seconds)


@dataclass(frozen=True, slots=True, eq=False)
class MotionDesign:
    """What is designed, for what, and what it must keep."""

    arm: Arm
    duration: float
    harmonics: int
    objective: ObjectiveName
    noise: Array
    columns: TorqueColumns
    limits: MotionLimits
    clearance: Clearance
    torques: TorqueUse = field(init=False)
    check: FourierBasis = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "torques", TorqueUse.of(self.arm, self.limits.torque))
        fourier_basis(self.duration, self.harmonics, 1)  # refuse bad numbers before they size an array
        instants = int(min(MOST_CHECKS, max(self.duration * CHECK_RATE, 20.0 * self.harmonics)))
        object.__setattr__(self, "check", fourier_basis(self.duration, self.harmonics, instants))

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

    def motion(self, X: Array) -> FourierMotion:
        """The series of coordinates X (b, n)."""
        return self.check.motion(X)

    def states(self, X: Array) -> tuple[Array, Array, Array]:
        """q, dq, ddq (k, n) at the instants of the check."""
        return self.check.position @ X, self.check.speed @ X, self.check.acceleration @ X

    def _space(self, size: Resolution, buffer: float = BUFFER, torque: float = np.inf) -> SearchSpace:
        basis, limits = (
            fourier_basis(self.duration, self.harmonics, k * self.harmonics) for k in (size.objective, size.limits)
        )
        objective = MotionObjective(self.columns, basis, self.noise, self.objective)
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
