"""The physically consistent fit: bodies that explain the torques and are as near to the table as the log allows.

    min over pi   1/2 (G pi - b)^T Lambda (G pi - b) + w sum_i D(P_i, P0_i)

b and Lambda are the base parameters of the log and their precision, G the grouping, D the log-det distance to the table
(`body_prior`). It is convex and its own barrier: a damped Newton method needs neither bounds nor a solver of cones, and
every link of what it gives is a body. The weight w = 1/deviation^2 is the one under which the log is most likely, near
`weighted_fit.USUAL_WEIGHT` where a log says nothing of it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.bodies.body_prior import body_prior
from lwr_dyn.identification.bodies.constraints import Constraints, constrained_prior
from lwr_dyn.identification.bodies.pseudo_inertia import are_bodies, pseudo_inertias
from lwr_dyn.identification.bodies.weighted_fit import WeightedProblem
from lwr_dyn.identification.regression.information import Information


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
    def deviation(self) -> float:
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
    rotor_weight: float | None = None,
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
        Of the distance to the table, 1/deviation^2 (20 % -> 25); by default that of most evidence.
    rotor_weight : float, optional
        The same of the table's rotors, beside a given weight; by default that weight.
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
    for given in (weight, rotor_weight):
        if given is not None and not (np.isfinite(given) and given > 0.0):
            raise OptionError("weight of the table", given, "a number above 0")
    prior = body_prior(information.columns, np.asarray(table, dtype=np.float64))
    if constraints is not None:
        prior = constrained_prior(prior, constraints)
    problem = WeightedProblem(information, prior, constraints)
    best = problem.search() if weight is None else problem.fit(weight, rotor_weight or weight, prior.table)
    names = () if constraints is None else constraints.names
    return ConsistentFit(
        best.parameters,
        best.nearest.covariance,
        prior.bodies,
        best.weight,
        best.rotor_weight,
        weight is None,
        problem.evidence(best),
        _price(information, best.parameters),
        best.nearest.iterations,
        prior.lifted,
        names,
    )


def _price(information: Information, parameters: Array) -> Price:
    """Against the least squares of the log."""
    off, normal = information.base.of(parameters) - information.values, information.normal
    squares = np.einsum("b,jbc,c->j", off, normal.matrices, off)
    mean = np.maximum(squares, 0.0) / np.maximum(normal.equations, 1)
    return Price(float(off @ information.precision @ off), np.sqrt(mean))
