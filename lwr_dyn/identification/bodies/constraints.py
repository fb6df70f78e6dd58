"""What is known for certain of an arm's parameters: a total mass from scales, values that a maker gives, any sum.

They are equations A pi = c. The table moves onto them by as little as possible (the log-det distance of `body_prior`);
the dual of that has one unknown a constraint and starts anywhere, and it grows without end where no bodies obey.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from lwr_dyn.foundation.arrays import Array, freeze_arrays, number_of
from lwr_dyn.foundation.errors import FaultError, OptionError, UnknownNameError
from lwr_dyn.identification.bodies.body_prior import BodyPrior
from lwr_dyn.identification.bodies.pseudo_inertia import inertial_parameters, pseudo_inertia_weights, pseudo_inertias

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

    def free(self, units: Array) -> Array:
        """Directions (p, f) in which parameters can move, orthonormal when parameters are counted in `units` (p,)."""
        rows = self.matrix * units
        return np.asarray(units[:, None] * null_space(rows / np.linalg.norm(rows, axis=1, keepdims=True)))


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
    prior = _without_rotors(prior, constraints)
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


def _without_rotors(prior: BodyPrior, constraints: Constraints) -> BodyPrior:
    """Rotors that are said to be 0 are none: no distance keeps them above 0."""
    alone = np.count_nonzero(constraints.matrix, axis=1) == 1
    zero = constraints.matrix[alone & (constraints.values == 0.0)].any(axis=0)
    kept, table = ~zero[prior.rotors], prior.table.copy()
    table[prior.rotors[~kept]] = 0.0
    return replace(prior, table=table, rotors=prior.rotors[kept], unknown_rotors=prior.unknown_rotors[kept])


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
    pull = pseudo_inertia_weights(slope[: prior.bodies].reshape(-1, 10))
    inverse = np.linalg.inv(pseudo_inertias(links)) - pull
    rotors = 1.0 / table[prior.rotors] - slope[prior.rotors]
    if np.linalg.eigvalsh(inverse).min() <= 0.0 or (rotors <= 0.0).any():
        return None
    out = table + prior.spread**2 * slope
    out[: prior.bodies] = inertial_parameters(np.asarray(np.linalg.inv(inverse), dtype=np.float64)).ravel()
    out[prior.rotors] = 1.0 / rotors
    return np.asarray(out)


def _dual(prior: BodyPrior, here: Array, A: Array, c: Array, units: Array, multipliers: Array) -> float:
    """A bound from below on the distance of all parameters that obey."""
    return prior.distance(here, 1.0) + float(multipliers @ (c - A @ (here / units)))
