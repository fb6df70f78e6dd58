"""What a table says of the parameters before any log: how far bodies and rotors are from it, as a log-det distance.

    D(P, P0) = trace(P0^-1 P) - log det(P0^-1 P) - 4     (Bregman), weight w = 1/deviation^2

exp(-w D) is a Wishart density of P; D grows to infinity at P singular, which keeps every body a body. A rotor's inertia
is the same with a 1 x 1 matrix. Friction has a wide Gaussian about the table's value.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.identification.bodies.pseudo_inertia import UNITS, are_bodies, inertial_parameters, pseudo_inertias
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

UNKNOWN_FRICTION = 10.0
"""Standard deviation of friction that a table lacks [N m, N m s/rad]: wide, only to have a value without any data."""
FRICTION_DEVIATION, OFFSET_DEVIATION, LEAST_SPREAD = 0.3, 0.1, 1.0
"""The same where the table has friction: share of its viscous or Coulomb value; of an offset, share of the Coulomb one;
and never less than `LEAST_SPREAD` [N m, N m s/rad].
"""
UNKNOWN_ROTOR = 0.1
"""Guess for a rotor the table lacks, as share of the mean moment of inertia of the bodies from its link outward."""
_KINDS = (
    ("viscous", "viscous", FRICTION_DEVIATION),
    ("coulomb", "coulomb", FRICTION_DEVIATION),
    ("stribeck", "coulomb", FRICTION_DEVIATION),
    ("offset", "coulomb", OFFSET_DEVIATION),
)
"""Columns, those whose largest value is their measure, and the share of it."""
_THINNEST, _LIGHTEST = 1e-3, 1e-2
_LENGTH = 0.1
"""Length that makes the entries of a pseudo-inertia alike [m]."""
_TEN = len(INERTIAL)


@dataclass(frozen=True, slots=True, eq=False)
class BodyPrior:
    """The distance of parameters (p,) from a table's, with derivatives.

    `bodies` 10 n inertial columns come first; `rotors` are the columns of rotor inertias, all others are friction.
    """

    table: Array
    """(p,), every link a body."""
    bodies: int
    rotors: NDArray[np.intp]
    unknown_rotors: NDArray[np.bool_]
    """Which of `rotors` the table lacks: their weight is 1, whatever that of the table."""
    lifted: tuple[int, ...]
    """Links, from 1, whose values in the table no body has (or that have none): the nearest thicker body replaces them.
    """
    spread: Array
    """(p,) standard deviation of friction about the table's, used for the columns of friction only."""
    rotor_weight: float | None = None
    """Weight of the rotors that the table has; that of the bodies if not given."""

    friction: NDArray[np.intp] = field(init=False)
    """Columns that are neither bodies nor rotors."""
    _inverse: Array = field(init=False, repr=False)
    """P0^-1, (links, 4, 4)"""

    def __post_init__(self) -> None:
        freeze_arrays(self, "table", "spread")
        object.__setattr__(self, "friction", np.setdiff1d(np.arange(self.bodies, self.table.size), self.rotors))
        object.__setattr__(self, "_inverse", np.linalg.inv(self._pseudo(self.table)))

    @property
    def units(self) -> Array:
        """(p,) how far each parameter moves alone at a distance of one half: a scale for it."""
        return np.asarray(1.0 / np.sqrt(np.diag(self.derivatives(self.table, 1.0)[1])))

    @property
    def known_rotors(self) -> NDArray[np.intp]:
        """Columns of the rotors that the table has."""
        return self.rotors[~self.unknown_rotors]

    def distance(self, parameters: Array, weight: float) -> float:
        """w D summed over bodies and rotors, and half the squares of friction; infinite outside the bodies."""
        rotors = parameters[self.rotors] / self.table[self.rotors]
        pseudo = self._pseudo(parameters)
        try:
            roots = np.linalg.cholesky(pseudo)
        except np.linalg.LinAlgError:
            return float("inf")
        if (rotors <= 0.0).any():
            return float("inf")
        logs = 2.0 * np.log(np.diagonal(roots, axis1=1, axis2=2)).sum() + np.linalg.slogdet(self._inverse)[1].sum()
        bodies = (self._inverse * pseudo).sum() - logs - 4.0 * len(pseudo)
        of_rotors = self._rotor_weights(weight) @ (rotors - np.log(rotors) - 1.0)
        friction = np.square((parameters - self.table) / self.spread)[self.friction].sum()
        return float(weight * bodies + of_rotors + 0.5 * friction)

    def derivatives(self, parameters: Array, weight: float) -> tuple[Array, Array]:
        """Gradient (p,) and Hessian (p, p) of `distance`."""
        gradient, hessian = np.zeros(self.table.size), np.zeros((self.table.size,) * 2)
        inverse = np.linalg.inv(self._pseudo(parameters))
        gradient[: self.bodies] = (
            weight * ((self._inverse - inverse).reshape(-1, 16) @ UNITS.reshape(_TEN, 16).T).ravel()
        )
        steps = (inverse[:, None] @ UNITS).reshape(len(inverse), _TEN, 16)
        across = np.swapaxes(steps.reshape(-1, _TEN, 4, 4), 2, 3).reshape(steps.shape)
        blocks = weight * steps @ np.swapaxes(across, 1, 2)
        for i, block in enumerate(blocks):
            hessian[_TEN * i : _TEN * (i + 1), _TEN * i : _TEN * (i + 1)] = block
        of_rotors, rotors, own_rotors = self._rotor_weights(weight), parameters[self.rotors], self.table[self.rotors]
        gradient[self.rotors] = of_rotors * (1.0 / own_rotors - 1.0 / rotors)
        hessian[self.rotors, self.rotors] = of_rotors / rotors**2
        precise = 1.0 / self.spread[self.friction] ** 2
        gradient[self.friction] = precise * (parameters - self.table)[self.friction]
        hessian[self.friction, self.friction] = precise
        return gradient, hessian

    def covariance(self, weight: float) -> Array:
        """How far bodies of that weight lie from the table, (p, p): the inverse Hessian at the table."""
        return scaled_inverse(self.derivatives(self.table, weight)[1])

    def _pseudo(self, parameters: Array) -> Array:
        return pseudo_inertias(parameters[: self.bodies].reshape(-1, _TEN))

    def _rotor_weights(self, weight: float) -> Array:
        return np.where(self.unknown_rotors, 1.0, weight if self.rotor_weight is None else self.rotor_weight)


def body_prior(columns: TorqueColumns, table: Array) -> BodyPrior:
    """The prior of a table's parameters (p,) in the order of the columns.

    Raises
    ------
    ShapeError
        A table of another size than its columns, or with rotors or friction that are not finite.
    """
    if table.shape != (columns.count,):
        raise ShapeError("table", f"an array {table.shape}", f"{columns.count} numbers, one a column")
    if not np.isfinite(table[columns.bodies :]).all():
        raise ShapeError("table", "values that are not finite", "finite rotor inertias and friction")
    links, rotors = table[: columns.bodies].reshape(-1, _TEN), columns.rotor_indices
    good = are_bodies(links)
    masses = np.where(np.isfinite(links[:, 0]) & (links[:, 0] > 0.0), links[:, 0], 0.0)
    lightest = _LIGHTEST * (masses.sum() or 1.0)
    filled = np.array([link if fine else _thicker(link, lightest) for link, fine in zip(links, good, strict=True)])
    own = np.concatenate([filled.ravel(), table[columns.bodies :]])
    unknown = ~(own[rotors] > 0.0)
    moments = filled[:, [4, 7, 9]].mean(axis=1)[::-1].cumsum()[::-1]
    own[rotors] = np.where(unknown, UNKNOWN_ROTOR * moments, own[rotors])
    lifted = tuple(int(i) + 1 for i in np.flatnonzero(~good))
    return BodyPrior(own, columns.bodies, rotors, unknown, lifted, _friction_spreads(columns, table))


def _friction_spreads(columns: TorqueColumns, table: Array) -> Array:
    """Per column (p,)."""
    spread = np.full(columns.count, UNKNOWN_FRICTION)
    for joint in range(columns.n):
        part = columns.of_joint(joint)
        for kind, others, deviation in _KINDS:
            chosen = [k for k in range(part.start, part.stop) if columns.names[k].startswith(kind)]
            alike = [k for k in range(part.start, part.stop) if columns.names[k].startswith(others)]
            own = float(np.abs(table[alike]).max(initial=0.0))
            if own > 0.0:
                spread[chosen] = max(deviation * own, LEAST_SPREAD)
    return spread


def _thicker(link: Array, lightest: float) -> Array:
    """The nearest parameters of a body: eigenvalues of P raised to a thousandth of its trace, a mass to `lightest`."""
    P = pseudo_inertias(np.where(np.isfinite(link), link, 0.0))
    scale = np.array([_LENGTH, _LENGTH, _LENGTH, 1.0])
    values, vectors = np.linalg.eigh(P / np.outer(scale, scale))
    floor = _THINNEST * max(float(values.max()), lightest)
    raised = (vectors * np.maximum(values, floor)) @ vectors.T * np.outer(scale, scale)
    if raised[3, 3] < lightest:  # a link without mass: a small ball
        raised = np.diag([lightest * _LENGTH**2 / 10.0] * 3 + [lightest])
    return inertial_parameters(raised)


def scaled_inverse(matrix: Array) -> Array:
    """Of a positive definite matrix whose entries differ in unit."""
    scale = 1.0 / np.sqrt(np.diag(matrix))
    return np.asarray(np.linalg.inv(matrix * np.outer(scale, scale)) * np.outer(scale, scale))
