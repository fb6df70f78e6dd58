"""The physically consistent fit: bodies that explain the torques and are as near to the table as the log allows.

    min over pi   1/2 (pi - mean)^T C^-1 (pi - mean) + w sum_i D(P_i, P0_i),   w falling

Mean and covariance C are those of `table_posterior`, D is the log-det distance to bodies P0 (`body_prior`). It is
convex and its own barrier: a damped Newton method needs neither bounds nor a solver of cones, and every link of what it
gives is a body. The errors are those of C: a thin link at the edge of what bodies can be is not known better for it.

What is found is held against the least squares of the log, which know no bodies: `Price` says whether chance explains
the difference.

References
----------
Boyd, Vandenberghe, Convex Optimization (2004), section 9.5: Newton's method with backtracking; 10.2 under equations.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.bodies import body_prior
from lwr_dyn.identification.bodies.link_spreads import Scales
from lwr_dyn.identification.bodies.possible_bodies import are_bodies
from lwr_dyn.identification.bodies.table_posterior import TablePosterior, logs_of, scales_of
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

    parameters: Array
    hessian: Array
    free: Array | None
    """(p, f) directions in which the parameters may move; None for all."""

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

    here, value = start, cost(start)
    for _ in range(_ROUNDS):
        slope, curvature = prior.derivatives(here, weight)
        slope, hessian = reduced(slope + target.slope(here)), reduced(curvature + target.curvature)
        step = _newton_step(hessian, slope)
        decrement, share = -float(slope @ step), 1.0
        if decrement < _SETTLED:
            break
        move = step if free is None else free @ step
        while (there := cost(here + share * move)) > value - _ARMIJO * share * decrement:
            share *= 0.5
            if share < _SHORTEST:  # rounding is all that is left
                return NearestBodies(here, hessian, free)
        here, value = here + share * move, there
    return NearestBodies(here, hessian, free)


def _newton_step(hessian: Array, slope: Array) -> Array:
    """-H^-1 slope. A log without noise leaves more digits between directions than a number has: the least ones then
    count as rounding does."""
    scale = 1.0 / np.sqrt(np.diag(hessian))
    scaled = hessian * np.outer(scale, scale)
    try:
        return np.asarray(-scale * cho_solve(cho_factor(scaled), scale * slope))
    except LinAlgError:
        values, vectors = np.linalg.eigh(scaled)
        values = np.maximum(values, len(values) * np.finfo(float).eps * values[-1])
        return np.asarray(-scale * (vectors @ ((vectors.T @ (scale * slope)) / values)))


PATH = (1e6, 1e5, 1e4, 1e3, 1e2, 10.0, 1.0)
"""Weights of the distance to the table on the way to the mean: each optimum is near the one before."""
INWARD = (0.1, 0.05)
"""Weights of the distance to the bodies that were reached: it keeps them bodies, and pulls them nowhere."""
LEVEL = 1e-3
"""Probability below which bodies are not those of the log."""
_ROUNDING = 1e-12
_LARGEST_LOG = 3.0
"""Of the standard error of a rotor's log: beyond it, its error is twenty times its value."""


@dataclass(frozen=True, slots=True, eq=False)
class Price:
    """What bodies cost against the least squares of the base parameters, and whether chance explains it.

    `pull`: by how many standard errors the base parameter that is furthest off is off; `parameter` is its index.
    `probability`: that chance gives so large a pull to any of them (Bonferroni), or so large a chi^2: the smaller one,
    doubled.
    """

    chi2: float
    """Of the consistent fit less that of least squares."""
    rms: Array
    """(n,) root mean square of the torque between the two, per joint, on the log's rows [N m; N for a sliding joint]"""
    parameter: int
    pull: float
    probability: float

    @property
    def refused(self) -> bool:
        """Whether the log contradicts the bodies."""
        return self.probability < LEVEL

    @classmethod
    def of(cls, information: Information, parameters: Array) -> "Price":
        """Of parameters (p,)."""
        off, normal = information.base.of(parameters) - information.values, information.normal
        seen = information.determined
        squares = np.einsum("b,jbc,c->j", off, normal.matrices, off)
        rms = np.sqrt(np.maximum(squares, 0.0) / np.maximum(normal.equations, 1))
        chi2 = float(off @ information.precision @ off)
        if not seen.any():
            return cls(chi2, rms, 0, 0.0, 1.0)
        pulls = np.where(seen, np.abs(off) / np.where(seen, information.sigma, 1.0), 0.0)
        count, worst = int(np.count_nonzero(seen)), int(np.argmax(pulls))
        chances = 2.0 * count * stats.norm.sf(pulls[worst]), stats.chi2.sf(chi2, count)
        return cls(chi2, rms, worst, float(pulls[worst]), float(min(1.0, 2.0 * min(chances))))


@dataclass(frozen=True, slots=True, eq=False)
class ConsistentFit:
    """Parameters (p,) of which every link is a body, and the covariance (p, p) of their mean given log and table."""

    parameters: Array
    covariance: Array
    """With the doubt of the scales; being a body takes nothing off it."""
    sigma: Array
    """Standard errors (p,). That of a rotor is one of its log."""
    left: Array
    """(p,) share of the table's standard errors that the log leaves, at the likeliest scales."""
    bodies: int
    """Inertial columns: the first ones, ten a link."""
    scales: Scales
    """How far links and rotors are expected off the table."""
    local: Array
    """(n, 4) factors on the variances of single links: of shape, centre, tensor, mass."""
    chosen: bool
    """Whether the scales are those of the log (False: a deviation was given)."""
    price: Price
    lifted: tuple[int, ...]
    """Links, from 1, whose values in the table no body has: the prior is a thicker body there."""
    constraints: tuple[str, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "parameters", "covariance", "sigma", "left", "local")

    @property
    def total_mass(self) -> tuple[float, float]:
        """Of all links, and its standard error [kg]."""
        masses = slice(0, self.bodies, 10)
        return float(self.parameters[masses].sum()), float(np.sqrt(max(0.0, self.covariance[masses, masses].sum())))

    @property
    def physical(self) -> NDArray[np.bool_]:
        """Whether each link can be a body, (n,): all of them, looked at again."""
        return are_bodies(self.parameters[: self.bodies].reshape(-1, 10))


def consistent_fit(
    information: Information,
    table: Array,
    *,
    deviation: float | None = None,
    like: ConsistentFit | None = None,
    constraints: body_prior.Constraints | None = None,
) -> ConsistentFit:
    """Bodies, rotors and friction that explain a log, near a table.

    Parameters
    ----------
    information : Information
        What the log says of the base parameters.
    table : (p,) array
        The table's parameters in the order of `information.columns` [SI]; a link that no body can be is thickened.
    deviation : float, optional
        One share for all kinds of difference (`Scales.of_deviation`), in place of scales that the log finds.
    like : ConsistentFit, optional
        Takes the scales and factors of another fit.
    constraints : Constraints, optional
        What is known for certain (`constraints_of`).

    Raises
    ------
    OptionError
        A deviation that is not above 0.
    ShapeError
        A table of another size, or with friction or rotors that are not finite.
    ConstraintError
        No bodies obey the constraints; names those that contradict each other.
    """
    if deviation is not None and not (np.isfinite(deviation) and deviation > 0.0):
        raise OptionError("deviation from the table", deviation, "a number above 0")
    constrained = prior = body_prior.body_prior(information.columns, np.asarray(table, dtype=np.float64))
    if constraints is not None:
        constrained = body_prior.constrained_prior(prior, constraints)
    posterior = TablePosterior(information, prior, constraints)
    if deviation is None and like is None:
        logs = posterior.likeliest()
        belief = posterior.mixed(logs)
    else:
        logs = logs_of(Scales.of_deviation(deviation) if like is None else like.scales)  # type: ignore[arg-type]
        if like is not None:
            posterior.weigh(like.local)
        posterior.linearise(logs)
        belief = posterior.given(logs)
    free = np.diag(prior.units) if constraints is None else constraints.free(prior.units)
    read = (free / np.square(prior.units)[:, None]).T  # read @ free = 1
    covariance, alone = (
        free @ (read @ x @ read.T) @ free.T for x in (belief.covariance, posterior.given(logs).covariance)
    )
    left = np.sqrt(np.maximum(np.diag(alone), 0.0)) / posterior.table_sigma(logs)
    sigma, J = np.sqrt(np.maximum(np.diag(covariance), 0.0)), posterior.rotors
    sigma[prior.rotors] = J * np.expm1(np.minimum(sigma[prior.rotors] / J, _LARGEST_LOG))
    target = Target(read @ belief.mean, body_prior.scaled_inverse(read @ covariance @ read.T, _ROUNDING), read)
    parameters = bodies_of(target, constrained, None if constraints is None else free)
    return ConsistentFit(
        parameters, covariance, sigma, left, prior.bodies, scales_of(logs),
        posterior.local, deviation is None and like is None, Price.of(information, parameters), prior.lifted,
        () if constraints is None else constraints.names,
    )  # fmt: skip


def bodies_of(target: Target, prior: body_prior.BodyPrior, free: Array | None) -> Array:
    """The bodies (p,) nearest to a target, whatever the table; `free` (p, f) as in `nearest_bodies`.

    From the table's bodies along a falling weight of the distance to them: straight from the table Newton's steps
    stall. The last steps are held to the bodies that were reached, which is a barrier without a pull.
    """
    alike, loose = np.zeros_like(prior.unknown_rotors), np.full(prior.spread.shape, np.inf)
    held, here = replace(prior, unknown_rotors=alike, spread=loose), prior.table
    for weight in PATH:
        here = nearest_bodies(target, held, weight, here, free).parameters
    for weight in INWARD:
        here = nearest_bodies(target, replace(held, table=here), weight, here, free).parameters
    return here
