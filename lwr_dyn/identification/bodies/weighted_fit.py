"""The fit of a log, a table and constraints under given weights, its evidence, and the weights of most evidence."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.body_prior import BodyPrior
from lwr_dyn.identification.bodies.constraints import Constraints
from lwr_dyn.identification.bodies.newton import NearestBodies, Target, nearest_bodies
from lwr_dyn.identification.regression.information import Information

WEIGHTS = (0.3, 1e5)
"""Range in which a weight is looked for: deviation from the table from a factor of three to 0.3 %."""
USUAL_WEIGHT, USUAL_FACTOR = 25.0, 10.0
"""Where a weight is when a log says nothing of it: arms are 20 % off their tables, give or take a factor of three (one
standard deviation of the log of the deviation; ten in the weight)."""
NO_DEVIATION, APART = 1e-3, 5.0
"""Weight of rotors that are not believed at all, and the log evidence that a weight of their own must bring: odds of a
hundred and fifty to one."""
_WEIGHT_STEP = 0.2
"""In log weight: a tenth is within what the fit can feel."""


@dataclass(frozen=True, slots=True, eq=False)
class WeightedFit:
    """The optimum under the weights of bodies and of rotors."""

    rotor_weight: float
    nearest: NearestBodies

    @property
    def weight(self) -> float:
        """Of the bodies."""
        return self.nearest.weight

    @property
    def parameters(self) -> Array:
        """(p,)"""
        return self.nearest.parameters


class WeightedProblem:
    """The cost of one log, one table and its constraints."""

    def __init__(self, information: Information, prior: BodyPrior, constraints: Constraints | None) -> None:
        self.prior = prior
        self._target = Target(information.values, information.precision, information.base.grouping)
        self._free = None if constraints is None else constraints.free(prior.units)
        self._dimensions = [prior.bodies, prior.known_rotors.size]
        if constraints is not None:
            rows = constraints.matrix * prior.units
            for k, columns in enumerate((np.arange(prior.bodies), prior.known_rotors)):
                self._dimensions[k] -= int(np.linalg.matrix_rank(rows[:, columns])) if columns.size else 0

    def fit(self, weight: float, rotors: float, start: Array) -> WeightedFit:
        """From parameters that obey the constraints."""
        prior = replace(self.prior, rotor_weight=rotors)
        return WeightedFit(rotors, nearest_bodies(self._target, prior, weight, start, self._free))

    def search(self) -> WeightedFit:
        """The fit of most evidence: one weight for the table, or another for its rotors where the log asks for it.

        A rotor's inertia in a table is often off by the square of a gear, which says nothing of the bodies beside it.
        """
        one = self._line(lambda weight, start: self.fit(weight, weight, start), self.prior.table)
        if not self.prior.known_rotors.size:
            return one
        bodies = self._line(lambda weight, start: self.fit(weight, NO_DEVIATION, start), self.prior.table)
        two = self._line(lambda weight, start: self.fit(bodies.weight, weight, start), bodies.parameters, NO_DEVIATION)
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
        hessian = fit.nearest.hessian
        scale = 1.0 / np.sqrt(np.diag(hessian))
        half_log = np.log(np.diag(np.linalg.cholesky(hessian * np.outer(scale, scale)))).sum() - np.log(scale).sum()
        logs = np.log([fit.weight, fit.rotor_weight])
        return float(-fit.nearest.value - half_log + 0.5 * logs @ np.array(self._dimensions))
