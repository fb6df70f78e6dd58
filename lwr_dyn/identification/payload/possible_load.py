"""The body that a load can be: nearest to what the torques say, of positive mass everywhere.

    min over phi   1/2 (phi - b)^T Lambda (phi - b) + w D(P, P0)

b and Lambda are the least-squares parameters and their precision, D the log-det distance of `bodies.body_prior` to a
solid ball of the same mass and centre. With w = 1 the ball is believed to a factor of e or so: it gives values where
the motion shows nothing, a tensor after a slow motion say, and keeps the rest positive.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Table, with_error
from lwr_dyn.identification.bodies.body_prior import BodyPrior
from lwr_dyn.identification.bodies.consistent import NearestBodies, Target, nearest_bodies
from lwr_dyn.identification.bodies.possible_bodies import are_bodies
from lwr_dyn.identification.payload.identify_load import NAMES as LINEAR
from lwr_dyn.identification.payload.identify_load import SYSTEMATIC, LoadIdentification, body_of
from lwr_dyn.model.chain import Body
from lwr_dyn.model.inertial_parameters import inertial_parameters

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
    weight : float
        Of the distance to the ball, above 0: 1/deviation^2.

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

    def nearest_to(believed: Array) -> NearestBodies:
        return nearest_bodies(Target(found.parameters, believed, np.eye(10)), prior, weight, phi)

    while share < 1.0:
        phi, share = nearest_to(share * precision).parameters, min(1.0, share * _FASTER)
    nearest = nearest_to(precision)
    off = nearest.parameters - found.parameters
    possible = bool(are_bodies(found.parameters)) and bool(shown.all())
    return PossibleLoad(nearest.parameters, nearest.covariance, float(weight), float(off @ precision @ off), possible)


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


Maybe = float | None
UNITS = ("kg", *("m",) * 3, *("kg m^2",) * 6)
SIGMAS = 3.0
STATES = {True: "identified", False: "not excited"}
"""A linear parameter is excited where its 3-sigma interval is below what a body of the load's mass can have."""
_ARM_LENGTH = 0.1
"""[m] The size of a hand-held load, which makes mass, first moment and tensor comparable."""


def load_document(found: LoadIdentification, robot: str = "") -> Document:
    """The body, how sure each of its numbers is, and the torques with and without it; no body without a load."""
    load = possible_load(found) if found.found else None
    torques = zip(found.without, found.left, found.noise, found.slow, found.equations.tolist(), strict=True)
    linear = zip(LINEAR, found.parameters, found.sigma, states(found), strict=True)
    facts = [
        Fact("robot", robot, "Name of the robot."),
        Fact("found", found.found, "Whether the load's mass is above 3 sigma."),
        Fact("weight", load and load.weight, "Of the log-det distance to a solid ball of that mass.", kind=Maybe),
        Fact("price", load and load.price, "Chi^2 of the body above that of least squares.", kind=Maybe),
        Fact("least_squares_is_a_body", load is not None and load.was_possible,
             "Whether some body has what least squares gives."),
    ]  # fmt: skip
    body = Section("", [
        _body(found, load),
        Note(_about(load) if load else ()),
        Fact("cutoff", found.cutoff, "Of the filter on positions, Hz.", "positions filtered at", "Hz", "g", Maybe),
        Note("positions not filtered", found.cutoff is None),
        Fact("known", found.known, "What was taken as known.", "taken as known"),
        Fact("motors", found.motors, "Which motors turn several joints, where rotors and friction are theirs."),
        Note(f"{found.motors}: rotors and friction are those of motors", bool(found.motors)),
        Fact("fitted_beside", list(found.nuisance), "Parameters that were fitted beside the load.", "fitted beside it",
             format=_kinds, kind=list[str]),
        Note(load_warnings(found), key="warnings", says="Where the residual is not noise."),
    ])  # fmt: skip
    columns = (
        Heading("joint", says="From 1."),
        Heading("RMS torque left without it", "", ".4g", "left_without",
                "Left when no load is assumed and all else is fitted."),
        Heading("with it", "", ".4g", "left", "Left with the load."),
        Heading("noise", "", ".4g", "noise", "Of the torque."),
        Heading("in slow sums", "", ".4g", "in_slow_sums",
                "The noise in slow sums: more than the noise where the model is wrong."),
        Heading("equations", key="equations", says="How many were used."),
    )  # fmt: skip
    joints = Table("", columns, [(j, *row) for j, row in enumerate(torques, 1)], key="joints",
                   says="RMS torques of each joint.")  # fmt: skip
    least_squares = Table(
        "", (Heading(key="parameter", says="Mass, first moment and tensor, SI."), Heading(key="value", says="SI."),
             Heading(key="standard_error", says="Null where the motion does not show it."),
             Heading(key="state", says="identified, or not excited.")),
        [*linear], key="least_squares", says="The ten linear parameters about the flange's origin.",
    )  # fmt: skip
    mass, sigma = (found.parameters, found.sigma) if load is None else (load.values, load.sigma)
    wide = f"its errors are those of an arm {found.share:.0%} off its table" if found.share else ""
    doubt = "IN DOUBT: residuals are not noise alone" if found.in_doubt else ""
    said = ", ".join(text for text in (doubt, wide) if text)
    kilograms = f"{with_error(float(mass[0]), float(sigma[0]))} kg{'; ' * bool(said)}{said}"
    verdict = f"load of {kilograms}" if load else f"no load found: torques give {kilograms}"
    return Document("Load in the hand", verdict, [body, Section("Torques", [joints, least_squares])],
                    "lwr-dyn identify payload", facts=facts, caveats=())  # fmt: skip


def _body(found: LoadIdentification, load: PossibleLoad | None) -> Table:
    columns = (
        Heading("of the load", key=None), Heading("value", key="value", says="SI.", sigma="standard_error"),
        Heading("by the motion", key=None), Heading(key="name", says="mass, com_x, ..., Ixx, ..."),
        Heading(key="unit", says="Of the value."), Heading(key="standard_error", says="Of the value."),
    )  # fmt: skip
    rows = () if load is None else [
        (f"{name} [{unit}]", value, state, name, unit, sigma)
        for name, unit, value, state, sigma in zip(NAMES, UNITS, load.values, states(found), load.sigma, strict=True)
    ]  # fmt: skip
    note = (
        "com in the frame of the flange (of the tool's point where the arm has one), tensor about com along its axes\n"
        "by the motion: of the mass, m com and the tensor about that frame, which are what least squares determines"
    )
    says = (
        "The nearest body: mass, centre of mass in the flange's frame, tensor about it along its axes. Empty when no "
        "load is found."
    )
    return Table("", columns, rows, note, "load", says)


def load_warnings(found: LoadIdentification) -> tuple[str, ...]:
    """Where the residual is not noise; the errors are too small then."""
    if not found.systematic:
        return ()
    joints = ", ".join(map(str, found.systematic))
    return (
        f"not noise alone: what is left at joint{'s' * (len(found.systematic) > 1)} {joints} is more than "
        f"{SYSTEMATIC:g} times larger in slow sums, so the true errors are larger too; the arm's table or its friction "
        "is off, and logs without the load take that out (--without)",
    )


def states(found: LoadIdentification) -> tuple[str, ...]:
    """Of each linear parameter: whether the motion shows it, by what a body of that mass and a hand's size can have."""
    mass = max(abs(float(found.parameters[0])), 3.0 * float(found.sigma[0]))
    size = mass * np.array([1.0, *(_ARM_LENGTH,) * 3, *(_ARM_LENGTH**2,) * 6])
    return tuple(STATES[bool(x)] for x in SIGMAS * found.sigma < size)


def _about(load: PossibleLoad) -> str:
    if load.was_possible:
        return f"least squares gives a body already; the ball of its mass moves it by a chi^2 of {load.price:.3g}"
    return (
        f"no body has what least squares gives; this one, {load.price:.3g} of chi^2 away, is near it and, where the "
        f"motion says little, near a solid ball of its mass (weight {load.weight:g})"
    )


def _kinds(names: Sequence[str]) -> str:
    kinds = dict.fromkeys(name.rsplit("_", 1)[0] for name in names)
    if not kinds:
        return ""
    return ", ".join(kinds) + " of the joints" if len(kinds) < 10 else f"{len(names)} parameters of the arm"
