"""One start of the search for an exciting motion: sequential quadratic programming on the coordinates of the series.

Limits of positions and speeds are linear in the coordinates; distances and, where they bind, torques are not. All hold
at instants of the motion; what they leave between them is met by `MotionLimits.fitted` and by a buffer on distances.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import minimize

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.excitation.clearance import Clearance
from lwr_dyn.identification.excitation.fourier import FourierBasis
from lwr_dyn.identification.excitation.motion_limits import MotionLimits
from lwr_dyn.identification.excitation.objectives import LARGE, MotionObjective
from lwr_dyn.identification.excitation.torque_use import TorqueUse

DRAWS, NEAR = 200, -0.05
"""Random motions of which a start takes the first that is not nearer than this [m], or else the clearest."""
OUTSIDE = 1e-2
"""[rad, m, rad/s, shares] Up to here outside of the limits an iterate of the search may be kept."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchSpace:
    """The objective and all that a motion must keep, at the instants of `basis`.

    `buffer` [m] is added to what distances keep; `torque` is None where torques do not bind.
    """

    objective: MotionObjective
    basis: FourierBasis
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
        self.space, self.x, self.value = space, x, LARGE
        self.last = x, LARGE

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
