"""The body that a load can be: nearest to what the torques say, with positive mass everywhere in it.

    min over phi   1/2 (phi - b)^T Lambda (phi - b) + w D(P, P0)

b and Lambda are the least-squares parameters and their precision, D the log-det distance of `bodies.body_prior` to a
solid ball of the same mass and centre. With w = 1 the ball is believed to a factor of e or so: it gives values where
the motion shows nothing, a tensor after a slow motion say, and keeps the rest positive.
"""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.bodies.body_prior import BodyPrior
from lwr_dyn.identification.bodies.newton import NearestBodies, Target, nearest_bodies
from lwr_dyn.identification.bodies.pseudo_inertia import are_bodies, inertial_parameters
from lwr_dyn.identification.payload.identify_load import LoadIdentification
from lwr_dyn.identification.payload.load_columns import body_of
from lwr_dyn.model.chain import Body

DENSITY = 2000.0
"""[kg/m^3] Of the ball that stands for a load of unknown shape: between plastic and aluminium."""
WEIGHT = 1.0
_LEAST_MASS = 1e-3
_FIRST, _FASTER = 1e3, 100.0
"""The torques are believed little by little, or a log without noise leads straight to the edge of what is a body."""
_ROWS, _COLUMNS = [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]
NAMES = ("mass", "com_x", "com_y", "com_z", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
"""[kg], [m] in the flange's frame, [kg m^2] about the centre of mass along its axes."""


@dataclass(frozen=True, slots=True, eq=False)
class PossibleLoad:
    """A body (10,) about the flange's origin, its covariance (10, 10), and what it costs against least squares.

    `was_possible`: least squares alone gave a body already. `price` is the chi^2 above that of least squares.
    """

    parameters: Array
    covariance: Array
    weight: float
    price: float
    was_possible: bool

    def __post_init__(self) -> None:
        freeze_arrays(self, "parameters", "covariance")

    @property
    def body(self) -> Body:
        """In the flange's frame, as `simulate` and `with_payload` take it."""
        return body_of(self.parameters)

    @property
    def values(self) -> Array:
        """Mass, centre of mass and tensor about it (10,), in the order of `NAMES`."""
        return _values(self.parameters)

    @property
    def sigma(self) -> Array:
        """Standard errors of `values` (10,), to first order."""
        steps = 1e-6 * np.sqrt(np.diag(self.covariance))
        slopes = np.array([(_values(self.parameters + h) - _values(self.parameters - h)) / (2 * h[i])
                           for i, h in enumerate(np.diag(steps))]).T  # fmt: skip
        return np.sqrt(np.diag(slopes @ self.covariance @ slopes.T))


def possible_load(found: LoadIdentification, weight: float = WEIGHT) -> PossibleLoad:
    """The load as a body.

    Parameters
    ----------
    found : LoadIdentification
    weight : float
        Of the distance to the ball, above 0: 1/deviation^2.

    Returns
    -------
    PossibleLoad

    Raises
    ------
    OptionError
        A weight that is not above 0.
    """
    if not (np.isfinite(weight) and weight > 0.0):
        raise OptionError("weight of the ball", weight, "a number above 0")
    prior, shown = _ball(found), found.determined
    precision = np.zeros((10, 10))
    precision[np.ix_(shown, shown)] = np.linalg.inv(found.covariance[np.ix_(shown, shown)])
    sharpest = float(np.linalg.eigvalsh(precision * np.outer(prior.units, prior.units))[-1])
    phi, share = prior.table, min(1.0, _FIRST / sharpest)
    while share < 1.0:
        phi, share = _nearest(found, share * precision, prior, weight, phi).parameters, min(1.0, share * _FASTER)
    nearest = _nearest(found, precision, prior, weight, phi)
    off = nearest.parameters - found.parameters
    possible = bool(are_bodies(found.parameters)) and bool(shown.all())
    return PossibleLoad(nearest.parameters, nearest.covariance, float(weight), float(off @ precision @ off), possible)


def _nearest(
    found: LoadIdentification, precision: Array, prior: BodyPrior, weight: float, start: Array
) -> NearestBodies:
    return nearest_bodies(Target(found.parameters, precision, np.eye(10)), prior, weight, start)


def _ball(found: LoadIdentification) -> BodyPrior:
    """A solid ball of the load's mass about its centre of mass, (10,)."""
    mass = max(float(found.parameters[0]), _LEAST_MASS)
    radius = (3.0 * mass / (4.0 * np.pi * DENSITY)) ** (1.0 / 3.0)
    com = found.parameters[1:4] / mass if found.found else np.zeros(3)
    P = np.empty((4, 4))
    P[:3, :3] = mass * (np.eye(3) * radius**2 / 5.0 + np.outer(com, com))
    P[:3, 3] = P[3, :3] = mass * com
    P[3, 3] = mass
    none = np.zeros(0, dtype=np.intp)
    return BodyPrior(inertial_parameters(P), 10, none, none.astype(bool), (), np.ones(10))


def _values(parameters: Array) -> Array:
    body = body_of(parameters)
    return np.concatenate([[body.mass], body.com, body.inertia_com[_ROWS, _COLUMNS]])
