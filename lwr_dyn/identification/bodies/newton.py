"""The bodies nearest to what torques say and to a prior, by a damped Newton method.

    min over pi   1/2 (G pi - b)^T Lambda (G pi - b) + w D(pi, pi0)

b and Lambda are values and their precision, G maps parameters to them, D is the log-det distance of `body_prior`, which
grows to infinity where a body stops to be one and so keeps every step inside.

References
----------
Boyd, Vandenberghe, Convex Optimization (2004), section 9.5: Newton's method with backtracking; 10.2 under equations.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.bodies.body_prior import BodyPrior, scaled_inverse

_ROUNDS, _SETTLED, _ARMIJO, _SHORTEST = 60, 1e-9, 1e-4, 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """Values (b,) with their precision (b, b) of linear combinations G (b, p) of the parameters."""

    values: Array
    precision: Array
    combinations: Array
    curvature: Array = field(init=False, repr=False)
    """Of half the chi^2, (p, p)."""
    _pull: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "precision", "combinations")
        weighted = self.combinations.T @ self.precision
        object.__setattr__(self, "curvature", weighted @ self.combinations)
        object.__setattr__(self, "_pull", weighted @ self.values)

    def half_chi2(self, parameters: Array) -> float:
        """Half the chi^2 of parameters (p,) above the least."""
        off = self.combinations @ parameters - self.values
        return 0.5 * float(off @ self.precision @ off)

    def slope(self, parameters: Array) -> Array:
        """Its gradient (p,)."""
        return np.asarray(self.curvature @ parameters - self._pull)


@dataclass(frozen=True, slots=True, eq=False)
class NearestBodies:
    """The optimum under one weight of the prior, with the Hessian there in the free directions."""

    weight: float
    parameters: Array
    value: float
    hessian: Array
    free: Array | None
    """(p, f) directions in which the parameters may move; None for all."""
    iterations: int

    @property
    def covariance(self) -> Array:
        """(p, p) of the parameters: the inverse of the Hessian, none across the free directions."""
        inverse = scaled_inverse(self.hessian)
        return inverse if self.free is None else np.asarray(self.free @ inverse @ self.free.T)


def nearest_bodies(
    target: Target, prior: BodyPrior, weight: float, start: Array, free: Array | None = None
) -> NearestBodies:
    """Newton's method with backtracking.

    Parameters
    ----------
    target : Target
    prior : BodyPrior
    weight : float
        Of the distance, 1/deviation^2.
    start : (p,) array
        Parameters of bodies that obey the constraints.
    free : (p, f) array, optional
        Directions that constraints leave; all if not given.

    Returns
    -------
    NearestBodies
    """

    def reduced(array: Array) -> Array:
        if free is None:
            return array
        return np.asarray(free.T @ array if array.ndim == 1 else free.T @ array @ free)

    def cost(parameters: Array) -> float:
        return target.half_chi2(parameters) + prior.distance(parameters, weight)

    here, value = start, cost(start)
    for iteration in range(_ROUNDS):
        slope, curvature = prior.derivatives(here, weight)
        slope, hessian = reduced(slope + target.slope(here)), reduced(curvature + target.curvature)
        scale = 1.0 / np.sqrt(np.diag(hessian))
        step = -scale * cho_solve(cho_factor(hessian * np.outer(scale, scale)), scale * slope)
        decrement, share = -float(slope @ step), 1.0
        if decrement < _SETTLED:
            break
        move = step if free is None else free @ step
        while (there := cost(here + share * move)) > value - _ARMIJO * share * decrement:
            share *= 0.5
            if share < _SHORTEST:  # rounding is all that is left
                return NearestBodies(weight, here, value, hessian, free, iteration)
        here, value = here + share * move, there
    return NearestBodies(weight, here, value, hessian, free, iteration)
