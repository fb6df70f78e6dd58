"""The cost of a log, a table and constraints under given weights, its optimum by Newton's method, and its evidence."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize_scalar

from lwr_dyn.arrays import Array
from lwr_dyn.identification.bodies.body_prior import BodyPrior
from lwr_dyn.identification.bodies.constraints import Constraints
from lwr_dyn.identification.regression.information import Information

WEIGHTS = (0.3, 1e5)
"""Range in which a weight is looked for: trust in the table from a factor of three to 0.3 %."""
USUAL_WEIGHT, USUAL_FACTOR = 25.0, 10.0
"""Where a weight is when a log says nothing of it: tables are trusted to 20 %, give or take a factor of three (one
standard deviation of the log of the trust; ten in the weight)."""
NO_TRUST, APART = 1e-3, 5.0
"""Weight of rotors that are not believed at all, and the log evidence that a weight of their own must bring: odds of a
hundred and fifty to one."""
_WEIGHT_STEP = 0.2
"""In log weight: a tenth is within what the fit can feel."""
_ROUNDS, _SETTLED, _ARMIJO = 60, 1e-9, 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class WeightedFit:
    """The optimum under the weights of bodies and of rotors."""

    weight: float
    rotor_weight: float
    parameters: Array
    value: float
    hessian: Array
    """In the free directions."""
    iterations: int


class WeightedProblem:
    """The cost of one log, one table and its constraints."""

    def __init__(self, information: Information, prior: BodyPrior, constraints: Constraints | None) -> None:
        self.information, self.prior = information, prior
        grouping = information.base.grouping
        self._curvature = grouping.T @ information.precision @ grouping
        self._pull = grouping.T @ (information.precision @ information.values)
        self._free = None if constraints is None else constraints.free(prior.units)
        self._dimensions = [prior.bodies, prior.known_rotors.size]
        if constraints is not None:
            rows = constraints.matrix * prior.units
            for k, columns in enumerate((np.arange(prior.bodies), prior.known_rotors)):
                self._dimensions[k] -= int(np.linalg.matrix_rank(rows[:, columns])) if columns.size else 0

    def _cost(self, prior: BodyPrior, parameters: Array, weight: float) -> float:
        """Half the chi^2 above least squares, and the distance."""
        off = self.information.base.of(parameters) - self.information.values
        return 0.5 * float(off @ self.information.precision @ off) + prior.distance(parameters, weight)

    def fit(self, weight: float, rotors: float, start: Array) -> WeightedFit:
        """Newton's method with backtracking from parameters that obey the constraints."""
        prior = replace(self.prior, rotor_weight=rotors)
        here, value = start, self._cost(prior, start, weight)
        for iteration in range(_ROUNDS):
            slope, curvature = prior.derivatives(here, weight)
            slope = self._reduced(slope + self._curvature @ here - self._pull)
            hessian = self._reduced(curvature + self._curvature)
            scale = 1.0 / np.sqrt(np.diag(hessian))
            step = -scale * cho_solve(cho_factor(hessian * np.outer(scale, scale)), scale * slope)
            decrement, share = -float(slope @ step), 1.0
            if decrement < _SETTLED:
                break
            move = step if self._free is None else self._free @ step
            while (there := self._cost(prior, here + share * move, weight)) > value - _ARMIJO * share * decrement:
                share *= 0.5
                if share < 1e-10:  # rounding is all that is left
                    return WeightedFit(weight, rotors, here, value, hessian, iteration)
            here, value = here + share * move, there
        return WeightedFit(weight, rotors, here, value, hessian, iteration)

    def search(self) -> WeightedFit:
        """The fit of most evidence: one weight for the table, or another for its rotors where the log asks for it.

        A rotor's inertia in a table is often off by the square of a gear, which says nothing of the bodies beside it.
        """
        one = self._line(lambda weight, start: self.fit(weight, weight, start), self.prior.table)
        if not self.prior.known_rotors.size:
            return one
        bodies = self._line(lambda weight, start: self.fit(weight, NO_TRUST, start), self.prior.table)
        two = self._line(lambda weight, start: self.fit(bodies.weight, weight, start), bodies.parameters, NO_TRUST)
        return two if self.evidence(two) > self.evidence(one) + APART else one

    def _line(self, fit: Callable[[float, Array], WeightedFit], start: Array, least: float = WEIGHTS[0]) -> WeightedFit:
        """The best fit along one weight; every fit starts where the one before ended."""
        fits: list[tuple[float, WeightedFit]] = []

        def unlikely(log_weight: float) -> float:
            found = fit(float(np.exp(log_weight)), fits[-1][1].parameters if fits else start)
            fits.append((log_weight, found))
            usual = (log_weight - np.log(USUAL_WEIGHT)) / np.log(USUAL_FACTOR)
            return 0.5 * float(usual) ** 2 - self.evidence(found)

        bounds = (float(np.log(least)), float(np.log(WEIGHTS[1])))
        found = minimize_scalar(unlikely, bounds=bounds, method="bounded", options={"xatol": _WEIGHT_STEP})
        return min(fits, key=lambda pair: abs(pair[0] - found.x))[1]

    def evidence(self, fit: WeightedFit) -> float:
        """Log evidence of a weight by Laplace's method about the fit.

        The normaliser of the prior is Laplace's too: what the method neglects cancels where the log says nothing.
        """
        scale = 1.0 / np.sqrt(np.diag(fit.hessian))
        half_log = np.log(np.diag(np.linalg.cholesky(fit.hessian * np.outer(scale, scale)))).sum() - np.log(scale).sum()
        logs = np.log([fit.weight, fit.rotor_weight])
        return float(-fit.value - half_log + 0.5 * logs @ np.array(self._dimensions))

    def covariance(self, hessian: Array) -> Array:
        """(p, p) from the Hessian in the free directions."""
        scale = 1.0 / np.sqrt(np.diag(hessian))
        inverse = np.linalg.inv(hessian * np.outer(scale, scale)) * np.outer(scale, scale)
        return inverse if self._free is None else self._free @ inverse @ self._free.T

    def _reduced(self, array: Array) -> Array:
        if self._free is None:
            return array
        return self._free.T @ array if array.ndim == 1 else self._free.T @ array @ self._free
