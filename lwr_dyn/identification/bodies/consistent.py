"""The physically consistent fit: bodies that explain the torques and are as near to the table as the log allows.

    min over pi   1/2 (G pi - b)^T Lambda (G pi - b) + w sum_i D(P_i, P0_i)

b and Lambda are the base parameters of the log and their precision, G the grouping, D the log-det distance to the table
(`body_prior`). It is convex and its own barrier: a damped Newton method needs neither bounds nor a solver of cones, and
every link of what it gives is a body. The weight w = 1/trust^2 is the one under which the log is most likely, near
`USUAL_WEIGHT` where a log says nothing of it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize_scalar

from lwr_dyn.arrays import Array, freeze_arrays
from lwr_dyn.errors import OptionError
from lwr_dyn.identification.bodies.body_prior import BodyPrior, body_prior
from lwr_dyn.identification.bodies.constraints import Constraints, constrained_prior
from lwr_dyn.identification.bodies.pseudo_inertia import are_bodies, pseudo_inertias
from lwr_dyn.identification.regression.information import Information

WEIGHTS = (0.3, 1e5)
"""Range in which the weight is looked for: trust in the table from a factor of three to 0.3 %."""
USUAL_WEIGHT, USUAL_FACTOR = 25.0, 10.0
"""Where the weight is when a log says nothing of it: tables are trusted to 20 %, give or take a factor of three (one
standard deviation of the log of the trust; ten in the weight)."""
_WEIGHT_STEP = 0.2
"""In log weight: a tenth is within what the fit can feel."""
_ROUNDS, _SETTLED, _ARMIJO = 60, 1e-9, 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Price:
    """What consistency costs against the least squares of the base parameters."""

    chi2: float
    """Of the consistent fit less that of least squares."""
    rms: Array
    """(n,) root mean square of the torque between the two, per joint, on the log's rows [N m; N for a sliding joint]"""


@dataclass(frozen=True, slots=True, eq=False)
class ConsistentFit:
    """Full parameters (p,) of which every link is a body, and their covariance (p, p) given log and table."""

    parameters: Array
    covariance: Array
    bodies: int
    """Inertial columns: the first ones, ten a link."""
    weight: float
    """Of the distance to the table."""
    chosen: bool
    """Whether the weight is that of most evidence (False: it was given)."""
    evidence: float
    """Log of the likelihood of the log under that weight, less what does not depend on the weight."""
    price: Price
    iterations: int
    """Newton steps of the last fit."""
    lifted: tuple[int, ...]
    """Links, from 1, whose values in the table no body has: the prior is a thicker body there."""
    constraints: tuple[str, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "parameters", "covariance")

    @property
    def trust(self) -> float:
        """The relative deviation from the table that the weight stands for."""
        return float(self.weight**-0.5)

    @property
    def sigma(self) -> Array:
        """Standard errors (p,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    @property
    def pseudo_inertias(self) -> Array:
        """(n, 4, 4), positive definite."""
        return pseudo_inertias(self.parameters[: self.bodies].reshape(-1, 10))

    @property
    def physical(self) -> NDArray[np.bool_]:
        """Whether each link can be a body, (n,): all of them, looked at again."""
        return are_bodies(self.parameters[: self.bodies].reshape(-1, 10))


def consistent_fit(
    information: Information,
    table: Array,
    *,
    weight: float | None = None,
    constraints: Constraints | None = None,
) -> ConsistentFit:
    """Bodies, rotors and friction that explain a log, near a table.

    Parameters
    ----------
    information : Information
        What the log says of the base parameters.
    table : (p,) array
        The table's parameters in the order of `information.columns` [SI]; a link that no body can be is thickened.
    weight : float, optional
        Of the distance to the table, 1/trust^2 (20 % -> 25); by default that of most evidence.
    constraints : Constraints, optional
        What is known for certain (`constraints_of`).

    Returns
    -------
    ConsistentFit

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
    if weight is not None and not (np.isfinite(weight) and weight > 0.0):
        raise OptionError("weight of the table", weight, "a number above 0")
    prior = body_prior(information.columns, np.asarray(table, dtype=np.float64))
    if constraints is not None:
        prior = constrained_prior(prior, constraints)
    problem = _Problem(information, prior, constraints)
    best = problem.fit(weight, prior.table) if weight is not None else problem.search()
    covariance = problem.covariance(best.hessian)
    names = () if constraints is None else constraints.names
    return ConsistentFit(
        best.parameters,
        covariance,
        prior.bodies,
        best.weight,
        weight is None,
        problem.evidence(best),
        problem.price(best.parameters),
        best.iterations,
        prior.lifted,
        names,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    weight: float
    parameters: Array
    value: float
    hessian: Array
    """In the free directions."""
    iterations: int


class _Problem:
    """The cost of one log, one table and its constraints."""

    def __init__(self, information: Information, prior: BodyPrior, constraints: Constraints | None) -> None:
        self.information, self.prior = information, prior
        grouping = information.base.grouping
        self._curvature = grouping.T @ information.precision @ grouping
        self._pull = grouping.T @ (information.precision @ information.values)
        self._free = None if constraints is None else constraints.free(prior.units)
        self._dimensions = prior.weighted.size
        if constraints is not None:
            self._dimensions -= int(np.linalg.matrix_rank((constraints.matrix * prior.units)[:, prior.weighted]))

    def cost(self, parameters: Array, weight: float) -> float:
        """Half the chi^2 above least squares, and the distance."""
        off = self.information.base.of(parameters) - self.information.values
        return 0.5 * float(off @ self.information.precision @ off) + self.prior.distance(parameters, weight)

    def fit(self, weight: float, start: Array) -> _Fit:
        """Newton's method with backtracking from parameters that obey the constraints."""
        here, value = start, self.cost(start, weight)
        for iteration in range(_ROUNDS):
            slope, curvature = self.prior.derivatives(here, weight)
            slope = self._reduced(slope + self._curvature @ here - self._pull)
            hessian = self._reduced(curvature + self._curvature)
            scale = 1.0 / np.sqrt(np.diag(hessian))
            step = -scale * cho_solve(cho_factor(hessian * np.outer(scale, scale)), scale * slope)
            decrement, share = -float(slope @ step), 1.0
            if decrement < _SETTLED:
                break
            move = step if self._free is None else self._free @ step
            while (there := self.cost(here + share * move, weight)) > value - _ARMIJO * share * decrement:
                share *= 0.5
                if share < 1e-10:  # rounding is all that is left
                    return _Fit(weight, here, value, hessian, iteration)
            here, value = here + share * move, there
        return _Fit(weight, here, value, hessian, iteration)

    def search(self) -> _Fit:
        """The fit of most evidence; every fit starts where the one before ended."""
        last = self.prior.table
        fits: list[_Fit] = []

        def unlikely(log_weight: float) -> float:
            nonlocal last
            found = self.fit(float(np.exp(log_weight)), last)
            last = found.parameters
            fits.append(found)
            usual = (log_weight - np.log(USUAL_WEIGHT)) / np.log(USUAL_FACTOR)
            return 0.5 * float(usual) ** 2 - self.evidence(found)

        bounds = (float(np.log(WEIGHTS[0])), float(np.log(WEIGHTS[1])))
        found = minimize_scalar(unlikely, bounds=bounds, method="bounded", options={"xatol": _WEIGHT_STEP})
        return min(fits, key=lambda fit: abs(np.log(fit.weight) - found.x))

    def evidence(self, fit: _Fit) -> float:
        """Log evidence of a weight by Laplace's method about the fit.

        The normaliser of the prior is Laplace's too: what the method neglects cancels where the log says nothing.
        """
        scale = 1.0 / np.sqrt(np.diag(fit.hessian))
        half_log = np.log(np.diag(np.linalg.cholesky(fit.hessian * np.outer(scale, scale)))).sum() - np.log(scale).sum()
        return float(-fit.value - half_log + 0.5 * self._dimensions * np.log(fit.weight))

    def covariance(self, hessian: Array) -> Array:
        """(p, p) from the Hessian in the free directions."""
        scale = 1.0 / np.sqrt(np.diag(hessian))
        inverse = np.linalg.inv(hessian * np.outer(scale, scale)) * np.outer(scale, scale)
        return inverse if self._free is None else self._free @ inverse @ self._free.T

    def price(self, parameters: Array) -> Price:
        """Against the least squares of the log."""
        off, normal = self.information.base.of(parameters) - self.information.values, self.information.normal
        squares = np.einsum("b,jbc,c->j", off, normal.matrices, off)
        mean = np.maximum(squares, 0.0) / np.maximum(normal.equations, 1)
        return Price(float(off @ self.information.precision @ off), np.sqrt(mean))

    def _reduced(self, array: Array) -> Array:
        if self._free is None:
            return array
        return self._free.T @ array if array.ndim == 1 else self._free.T @ array @ self._free
