"""What a table says of the parameters before any log: how far bodies and rotors are from it, as a log-det distance.

    D(P, P0) = trace(P0^-1 P) - log det(P0^-1 P) - 4     (Bregman), weight w = 1/deviation^2

exp(-w D) is a Wishart density of P; D grows to infinity at P singular, which keeps every body a body. A rotor's inertia
is the same with a 1 x 1 matrix. Friction has a wide Gaussian about the table's value.

What is known for certain (a total mass from scales, values that a maker gives, any sum) are equations A pi = c. The
table moves onto them by as little of that distance as possible; the dual of that has one unknown a constraint and
starts anywhere, and it grows without end where no bodies obey.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array, freeze_arrays, number_of
from lwr_dyn.foundation.errors import FaultError, OptionError, ShapeError, UnknownNameError
from lwr_dyn.identification.bodies import possible_bodies
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model import inertial_parameters

UNKNOWN_FRICTION = 10.0
"""Standard deviation of friction that a table lacks [N m, N m s/rad]: wide, only to have a value without any data."""
FRICTION_DEVIATION, OFFSET_DEVIATION, LEAST_SPREAD = 0.3, 0.1, 1.0
"""The same where the table has friction: share of its viscous or Coulomb value; of an offset, share of the Coulomb one;
and never less than `LEAST_SPREAD` [N m, N m s/rad].
"""
UNKNOWN_ROTOR = 0.1
"""Guess for a rotor the table lacks: share of the geometric mean of the mean moment of inertia of the bodies from its
link outward, and the mean of that over all links. Motors of a wrist are larger than its load asks for."""
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
        of_rotors = np.where(self.unknown_rotors, 1.0, weight) @ (rotors - np.log(rotors) - 1.0)
        friction = np.square((parameters - self.table) / self.spread)[self.friction].sum()
        return float(weight * bodies + of_rotors + 0.5 * friction)

    def derivatives(self, parameters: Array, weight: float) -> tuple[Array, Array]:
        """Gradient (p,) and Hessian (p, p) of `distance`."""
        gradient, hessian = np.zeros(self.table.size), np.zeros((self.table.size,) * 2)
        inverse = np.linalg.inv(self._pseudo(parameters))
        units = inertial_parameters.UNITS
        gradient[: self.bodies] = (
            weight * ((self._inverse - inverse).reshape(-1, 16) @ units.reshape(_TEN, 16).T).ravel()
        )
        steps = (inverse[:, None] @ units).reshape(len(inverse), _TEN, 16)
        across = np.swapaxes(steps.reshape(-1, _TEN, 4, 4), 2, 3).reshape(steps.shape)
        blocks = weight * steps @ np.swapaxes(across, 1, 2)
        for i, block in enumerate(blocks):
            hessian[_TEN * i : _TEN * (i + 1), _TEN * i : _TEN * (i + 1)] = block
        rotors, own_rotors = parameters[self.rotors], self.table[self.rotors]
        of_rotors = np.where(self.unknown_rotors, 1.0, weight)
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
        return inertial_parameters.pseudo_inertias(parameters[: self.bodies].reshape(-1, _TEN))


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
    good = possible_bodies.are_bodies(links)
    masses = np.where(np.isfinite(links[:, 0]) & (links[:, 0] > 0.0), links[:, 0], 0.0)
    lightest = _LIGHTEST * (masses.sum() or 1.0)
    filled = np.array([link if fine else _thicker(link, lightest) for link, fine in zip(links, good, strict=True)])
    own = np.concatenate([filled.ravel(), table[columns.bodies :]])
    unknown = ~(own[rotors] > 0.0)
    moments = filled[:, [4, 7, 9]].mean(axis=1)[::-1].cumsum()[::-1]
    guess = UNKNOWN_ROTOR * np.sqrt(moments * moments.mean())
    own[rotors] = np.where(unknown, guess, own[rotors])
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
    P = inertial_parameters.pseudo_inertias(np.where(np.isfinite(link), link, 0.0))
    scale = np.array([_LENGTH, _LENGTH, _LENGTH, 1.0])
    values, vectors = np.linalg.eigh(P / np.outer(scale, scale))
    floor = _THINNEST * max(float(values.max()), lightest)
    raised = (vectors * np.maximum(values, floor)) @ vectors.T * np.outer(scale, scale)
    if raised[3, 3] < lightest:  # a link without mass: a small ball
        raised = np.diag([lightest * _LENGTH**2 / 10.0] * 3 + [lightest])
    return inertial_parameters.inertial_parameters(raised)


def scaled_inverse(matrix: Array, ridge: float = 0.0) -> Array:
    """Of a positive definite matrix whose entries differ in unit; `ridge` is added where they are scaled to 1."""
    scale = 1.0 / np.sqrt(np.diag(matrix))
    even = matrix * np.outer(scale, scale) + ridge * np.eye(scale.size)
    return np.asarray(np.linalg.inv(even) * np.outer(scale, scale))


TOTAL_MASS = "total mass"
_NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_TERM = re.compile(rf"([+-]?)\s*(?:({_NUMBER})\s*\*?\s*)?([A-Za-z]+[+-]?_[0-9]+)")
_ROUNDS, _SETTLED, _NEAR, _SHORTEST = 60, 1e-14, 1e-6, 1e-10
_NEAREST = 8
"""Names that are listed for one that is unknown; an arm has a hundred."""
_FARTHEST = 300.0
"""Distance from the table beyond which there are none: rank-deficient bodies have an infinite one."""


class ConstraintError(FaultError, ValueError):
    """Constraints that no bodies obey: `names` is a set of which every one is needed for the contradiction."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        together = "" if len(names) == 1 else " together"
        super().__init__("constraints", "; ".join(names) + together, "values that bodies of positive mass can have")


@dataclass(frozen=True, slots=True, eq=False)
class Constraints:
    """matrix (c, p) @ parameters = values (c,), one name a row."""

    names: tuple[str, ...]
    matrix: Array
    values: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "matrix", "values")

    def scaled(self, units: Array) -> "Constraints":
        """The same equations, each with a left side of length 1 where parameters are counted in `units` (p,)."""
        size = np.linalg.norm(self.matrix * units, axis=1)
        return Constraints(self.names, self.matrix / size[:, None], self.values / size)

    def free(self, units: Array) -> Array:
        """Directions (p, f) in which parameters can move, orthonormal when parameters are counted in `units` (p,)."""
        return np.asarray(units[:, None] * null_space(self.scaled(units).matrix * units))


def constraints_of(texts: Sequence[str], names: Sequence[str]) -> Constraints:
    """Constraints as they are written: `total mass = 15.8`, `m_4 = 2.1`, `mx_4 - 0.02 m_4 = 0`, `m_4 + m_5 = 3`.

    `names` (p,) are those of the parameters.

    Raises
    ------
    OptionError
        A text that is no equation with a number on its right.
    UnknownNameError
        A parameter that is not among `names`.

    >>> constraints_of(["m_1 - 2 m_2 = 0.5"], ["m_1", "m_2"]).matrix.tolist()
    [[1.0, -2.0]]
    """
    rows = [_equation(text, names) for text in texts]
    matrix = np.array([row for row, _ in rows]).reshape(len(texts), len(names))
    return Constraints(tuple(" ".join(t.split()) for t in texts), matrix, np.array([value for _, value in rows]))


def _equation(text: str, names: Sequence[str]) -> tuple[Array, float]:
    left, _, right = text.partition("=")
    try:
        value = number_of(right.strip())
    except ValueError:
        value = np.nan
    row = np.zeros(len(names))
    rest, first = left.strip(), True
    if rest == TOTAL_MASS:
        row[[name.startswith("m_") for name in names]] = 1.0
        rest = ""
    while rest and (term := _TERM.match(rest)):
        sign, factor, name = term.groups()
        if not (sign or first):
            break
        if name not in names:
            raise UnknownNameError("parameter", name, get_close_matches(name, names, _NEAREST, 0.0))
        row[list(names).index(name)] += (-1.0 if sign == "-" else 1.0) * float(factor or 1.0)
        rest, first = rest[term.end() :].strip(), False
    if rest or not (np.isfinite(value) and np.isfinite(row).all() and row.any()):
        raise OptionError("constraint", repr(text), f"an equation such as '{TOTAL_MASS} = 15.8' or 'm_4 + m_5 = 3.2'")
    return row, value


def constrained_prior(prior: BodyPrior, constraints: Constraints) -> BodyPrior:
    """The prior about the parameters nearest to the table that obey: on the constraints, its distance is the same one.

    That is Pythagoras' theorem for Bregman distances: D(P, P0) = D(P, P1) + D(P1, P0). It holds under the weights of
    the projection, which are one for all: a constraint that mixes bodies with rotors or friction is projected so too,
    and where the fit has another weight for rotors the point it starts from is near, not nearest.

    Raises
    ------
    ConstraintError
        No bodies obey; names a smallest set of constraints that contradict each other.

    References
    ----------
    Dhillon, Tropp, Matrix nearness problems with Bregman divergences (2007), section 2.4.
    """
    alone = np.count_nonzero(constraints.matrix, axis=1) == 1
    zero = constraints.matrix[alone & (constraints.values == 0.0)].any(axis=0)
    kept, table = ~zero[prior.rotors], prior.table.copy()
    table[prior.rotors[~kept]] = 0.0  # rotors that are said to be 0 are none: no distance keeps them above 0
    prior = replace(prior, table=table, rotors=prior.rotors[kept], unknown_rotors=prior.unknown_rotors[kept])
    every = np.arange(len(constraints.names))
    nearest = _nearest(prior, constraints, every)
    if nearest is not None:
        return replace(prior, table=nearest)
    needed = every
    for k in every:  # leave out whatever is not needed for the contradiction
        fewer = needed[needed != k]
        if fewer.size and _nearest(prior, constraints, fewer) is None:
            needed = fewer
    raise ConstraintError([constraints.names[k] for k in needed])


def _nearest(prior: BodyPrior, constraints: Constraints, rows: NDArray[np.intp]) -> Array | None:
    """The parameters (p,) nearest to the table that obey some constraints, or None if there are none."""
    units = prior.units
    A, c = constraints.matrix[rows] * units, constraints.values[rows]
    size = np.linalg.norm(A, axis=1)
    A, c = A / size[:, None], c / size
    fitted = np.linalg.lstsq(A, c, rcond=None)[0]
    if np.abs(A @ fitted - c).max() > 1e-9 * max(1.0, float(np.abs(c).max())):
        return None
    multipliers, here = np.zeros(rows.size), prior.table
    for _ in range(_ROUNDS):
        missing = c - A @ (here / units)
        inverse = np.linalg.inv(prior.derivatives(here, 1.0)[1] * np.outer(units, units))
        step = np.linalg.lstsq(A @ inverse @ A.T, missing, rcond=1e-12)[0]
        decrement, value = float(missing @ step), _dual(prior, here, A, c, units, multipliers)
        if decrement < _SETTLED:  # what rounding left is removed along the rows
            exact = here + units * np.linalg.lstsq(A, missing, rcond=None)[0]
            return exact if np.isfinite(prior.distance(exact, 1.0)) else None
        share = 1.0
        while value < _FARTHEST and share > _SHORTEST:
            trial = multipliers + share * step
            there = _of_multipliers(prior, A, units, trial)
            if there is not None:
                gain = _dual(prior, there, A, c, units, trial) - value
                if decrement < _NEAR or gain >= 0.1 * share * decrement:
                    break
            share *= 0.5
        else:
            return None
        multipliers, here = trial, there
    return None


def _of_multipliers(prior: BodyPrior, A: Array, units: Array, multipliers: Array) -> Array | None:
    """Where the distance has the gradient A^T multipliers; None where no bodies do."""
    slope = (multipliers @ A) / units
    table, links = prior.table, prior.table[: prior.bodies].reshape(-1, 10)
    pull = inertial_parameters.pseudo_inertia_weights(slope[: prior.bodies].reshape(-1, 10))
    inverse = np.linalg.inv(inertial_parameters.pseudo_inertias(links)) - pull
    rotors = 1.0 / table[prior.rotors] - slope[prior.rotors]
    if np.linalg.eigvalsh(inverse).min() <= 0.0 or (rotors <= 0.0).any():
        return None
    out = table + prior.spread**2 * slope
    bodies = np.asarray(np.linalg.inv(inverse), dtype=np.float64)
    out[: prior.bodies] = inertial_parameters.inertial_parameters(bodies).ravel()
    out[prior.rotors] = 1.0 / rotors
    return np.asarray(out)


def _dual(prior: BodyPrior, here: Array, A: Array, c: Array, units: Array, multipliers: Array) -> float:
    """A bound from below on the distance of all parameters that obey."""
    return prior.distance(here, 1.0) + float(multipliers @ (c - A @ (here / units)))
