"""The physically consistent fit: bodies that explain the torques and are as near to the table as the log allows.

    min over pi   1/2 (G pi - b)^T Lambda (G pi - b) + w sum_i D(P_i, P0_i)

b and Lambda are the base parameters of the log and their precision, G the grouping, D the log-det distance to the table
(`body_prior`). It is convex and its own barrier: a damped Newton method needs neither bounds nor a solver of cones, and
every link of what it gives is a body. The weight w = 1/deviation^2 is the one under which the log is most likely, near
`USUAL_WEIGHT` where a log says nothing of it.

References
----------
Boyd, Vandenberghe, Convex Optimization (2004), section 9.5: Newton's method with backtracking; 10.2 under equations.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize_scalar

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.bodies import body_prior
from lwr_dyn.identification.bodies.possible_bodies import are_bodies
from lwr_dyn.identification.regression.information import Information

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
    """The optimum under given weights of the prior, with the Hessian there in the free directions."""

    weight: float
    """Of the bodies."""
    rotor_weight: float
    parameters: Array
    value: float
    hessian: Array
    free: Array | None
    """(p, f) directions in which the parameters may move; None for all."""
    iterations: int

    @property
    def covariance(self) -> Array:
        """(p, p) of the parameters: the inverse of the Hessian, none across the free directions."""
        inverse = body_prior.scaled_inverse(self.hessian)
        return inverse if self.free is None else np.asarray(self.free @ inverse @ self.free.T)


def nearest_bodies(
    target: Target, prior: body_prior.BodyPrior, weight: float, start: Array, free: Array | None = None
) -> NearestBodies:
    """Newton's method with backtracking.

    Parameters
    ----------
    weight : float
        Of the distance, 1/deviation^2.
    start : (p,) array
        Parameters of bodies that obey the constraints.
    free : (p, f) array, optional
        Directions that constraints leave; all if not given.
    """

    def reduced(array: Array) -> Array:
        if free is None:
            return array
        return np.asarray(free.T @ array if array.ndim == 1 else free.T @ array @ free)

    def cost(parameters: Array) -> float:
        return target.half_chi2(parameters) + prior.distance(parameters, weight)

    weights = weight, weight if prior.rotor_weight is None else prior.rotor_weight
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
                return NearestBodies(*weights, here, value, hessian, free, iteration)
        here, value = here + share * move, there
    return NearestBodies(*weights, here, value, hessian, free, iteration)


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


class WeightedProblem:
    """The cost of one log, one table and its constraints."""

    def __init__(
        self, information: Information, prior: body_prior.BodyPrior, constraints: body_prior.Constraints | None
    ) -> None:
        self.prior = prior
        self._target = Target(information.values, information.precision, information.base.grouping)
        self._free = None if constraints is None else constraints.free(prior.units)
        self._dimensions = [prior.bodies, prior.known_rotors.size]
        if constraints is not None:
            rows = constraints.matrix * prior.units
            for k, columns in enumerate((np.arange(prior.bodies), prior.known_rotors)):
                self._dimensions[k] -= int(np.linalg.matrix_rank(rows[:, columns])) if columns.size else 0

    def fit(self, weight: float, rotors: float, start: Array) -> NearestBodies:
        """From parameters that obey the constraints."""
        return nearest_bodies(self._target, replace(self.prior, rotor_weight=rotors), weight, start, self._free)

    def search(self) -> NearestBodies:
        """The fit of most evidence: one weight for the table, or another for its rotors where the log asks for it.

        A rotor's inertia in a table is often off by the square of a gear, which says nothing of the bodies beside it.
        """
        one = self._line(lambda weight, start: self.fit(weight, weight, start), self.prior.table)
        if not self.prior.known_rotors.size:
            return one
        bodies = self._line(lambda weight, start: self.fit(weight, NO_DEVIATION, start), self.prior.table)
        two = self._line(lambda weight, start: self.fit(bodies.weight, weight, start), bodies.parameters, NO_DEVIATION)
        return two if self.evidence(two) > self.evidence(one) + APART else one

    def _line(
        self, fit: Callable[[float, Array], NearestBodies], start: Array, least: float = WEIGHTS[0]
    ) -> NearestBodies:
        """The best fit along one weight; every fit starts where the one before ended."""
        fits: list[tuple[float, NearestBodies]] = []

        def unlikely(log_weight: float) -> float:
            found = fit(float(np.exp(log_weight)), fits[-1][1].parameters if fits else start)
            fits.append((log_weight, found))
            usual = (log_weight - np.log(USUAL_WEIGHT)) / np.log(USUAL_FACTOR)
            return 0.5 * float(usual) ** 2 - self.evidence(found)

        bounds = (float(np.log(least)), float(np.log(WEIGHTS[1])))
        found = minimize_scalar(unlikely, bounds=bounds, method="bounded", options={"xatol": _WEIGHT_STEP})
        return min(fits, key=lambda pair: abs(pair[0] - found.x))[1]

    def evidence(self, fit: NearestBodies) -> float:
        """Log evidence of a weight by Laplace's method about the fit.

        The normaliser of the prior is Laplace's too: what the method neglects cancels where the log says nothing.
        """
        hessian = fit.hessian
        scale = 1.0 / np.sqrt(np.diag(hessian))
        half_log = np.log(np.diag(np.linalg.cholesky(hessian * np.outer(scale, scale)))).sum() - np.log(scale).sum()
        logs = np.log([fit.weight, fit.rotor_weight])
        return float(-fit.value - half_log + 0.5 * logs @ np.array(self._dimensions))


@dataclass(frozen=True, slots=True, eq=False)
class Price:
    """What consistency costs against the least squares of the base parameters."""

    chi2: float
    """Of the consistent fit less that of least squares."""
    rms: Array
    """(n,) root mean square of the torque between the two, per joint, on the log's rows [N m; N for a sliding joint]"""


@dataclass(frozen=True, slots=True, eq=False)
class ConsistentFit:
    """Full parameters (p,) of which every link is a body, and their covariance (p, p) given log, table and weight."""

    parameters: Array
    covariance: Array
    bodies: int
    """Inertial columns: the first ones, ten a link."""
    weight: float
    """Of the distance of bodies to the table."""
    rotor_weight: float
    """The same of rotors."""
    chosen: bool
    """Whether the weights are those of most evidence (False: one was given)."""
    price: Price
    iterations: int
    """Newton steps of the last fit."""
    lifted: tuple[int, ...]
    """Links, from 1, whose values in the table no body has: the prior is a thicker body there."""
    constraints: tuple[str, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "parameters", "covariance")

    @property
    def deviation(self) -> float:
        """The relative deviation from the table that the weight stands for."""
        return float(self.weight**-0.5)

    @property
    def sigma(self) -> Array:
        """Standard errors (p,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    @property
    def physical(self) -> NDArray[np.bool_]:
        """Whether each link can be a body, (n,): all of them, looked at again."""
        return are_bodies(self.parameters[: self.bodies].reshape(-1, 10))


def consistent_fit(
    information: Information,
    table: Array,
    *,
    weight: float | None = None,
    rotor_weight: float | None = None,
    constraints: body_prior.Constraints | None = None,
) -> ConsistentFit:
    """Bodies, rotors and friction that explain a log, near a table.

    Parameters
    ----------
    information : Information
        What the log says of the base parameters.
    table : (p,) array
        The table's parameters in the order of `information.columns` [SI]; a link that no body can be is thickened.
    weight : float, optional
        Of the distance to the table, 1/deviation^2 (20 % -> 25); by default that of most evidence.
    rotor_weight : float, optional
        The same of the table's rotors, beside a given weight; by default that weight.
    constraints : Constraints, optional
        What is known for certain (`constraints_of`).

    Raises
    ------
    OptionError
        A weight that is not above 0.
    ShapeError
        A table of another size, or with friction or rotors that are not finite.
    ConstraintError
        No bodies obey the constraints; names those that contradict each other.

    References
    ----------
    Lee, Wensing, Park, Geometric robot dynamic identification: a convex programming approach (2020), eq. 24 (the
    distance); MacKay, Bayesian interpolation (1992), section 3 (the weight, by Laplace's method).
    """
    for given in (weight, rotor_weight):
        if given is not None and not (np.isfinite(given) and given > 0.0):
            raise OptionError("weight of the table", given, "a number above 0")
    prior = body_prior.body_prior(information.columns, np.asarray(table, dtype=np.float64))
    if constraints is not None:
        prior = body_prior.constrained_prior(prior, constraints)
    problem = WeightedProblem(information, prior, constraints)
    best = problem.search() if weight is None else problem.fit(weight, rotor_weight or weight, prior.table)
    names = () if constraints is None else constraints.names
    off, normal = information.base.of(best.parameters) - information.values, information.normal
    squares = np.einsum("b,jbc,c->j", off, normal.matrices, off)
    mean = np.maximum(squares, 0.0) / np.maximum(normal.equations, 1)
    return ConsistentFit(
        best.parameters, best.covariance, prior.bodies, best.weight, best.rotor_weight, weight is None,
        Price(float(off @ information.precision @ off), np.sqrt(mean)), best.iterations, prior.lifted, names,
    )  # fmt: skip
