"""Springs, dampers, rotors, friction and links from logs with the encoders of both sides of the gears.

    drives:  Y(q, dq, ddq) pi + B ddtheta + f(dtheta) = tau
    gears:   Y(q, dq, ddq) pi - K (theta - q) - D (dtheta - dq) - o = 0

Both are linear in pi, B, f, K, D and o. The first is the sum of links and motors and has no spring in it: it has the
noise of the torques. The second has no torque in it, so it fixes K, D and pi up to a factor, with the noise of the
encoders. These noises are independent; those of the links and of the motors are not. o is K times the angle between the
zeros of the two encoders.

The deflection theta - q is small: 1e-5 rad where a wrist joint carries little, as much as the noise of an encoder, and
least squares would take the noise for the spring (K too small, by a tenth and more). So the deflection's instrument is
the links' torque from the fit itself, which has no encoder's difference in it.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Annotated, TypedDict

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.foundation.tables import Heading, Table, with_error
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.regression.information import BLOCK, equations_of, grouped
from lwr_dyn.identification.regression.instrumental import WINDOW, instrumental_fit
from lwr_dyn.identification.regression.least_squares import BaseParameters, base_parameters
from lwr_dyn.identification.regression.samples import SampleRule, Samples, samples_of
from lwr_dyn.identification.regression.torque_columns import PROBES, WIDEST, JointColumns, TorqueColumns
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.model.run import short_repr
from lwr_dyn.model.transmission import JointElasticity

TWO_ENCODERS = SampleRule(10.0)
"""At 20 Hz noise of accelerations, with nothing but encoders in the gears' equations, moved links by 0.3 sigma."""
GEAR = ("stiffness", "damping", "zero")
"""K [N m/rad], D [N m s/rad] and o [N m] of a gear."""
DRIVE = JointColumns("symmetric")
"""Rotor and friction of a motor, seen at its joint."""


@dataclass(frozen=True, slots=True, eq=False)
class ElasticIdentification:
    """Parameters (p,): the links' base parameters, then rotor, friction and gear, joint by joint (`names`).

    `covariance` (p, p); `base` groups the links' ten parameters each, rotors are none of them; `noise` (2n,) [N m] is
    that of the drives' torques, then that of the gears', which is K times the encoders'.
    """

    names: tuple[str, ...]
    base: BaseParameters
    values: Array
    covariance: Array
    noise: Array
    equations: int
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "values", "covariance", "noise")

    @property
    def sigma(self) -> Array:
        """Standard errors (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def n(self) -> int:
        """Number of joints."""
        return (len(self.names) - self.base.count) // _PER_JOINT

    def of(self, name: str, sigma: bool = False) -> Array:
        """A parameter of all joints (n,) or its standard errors: armature, coulomb, viscous, offset, one of `GEAR`."""
        place = self.base.count + (*DRIVE.names, *GEAR).index(name)
        return np.asarray((self.sigma if sigma else self.values)[place::_PER_JOINT])

    @property
    def links(self) -> Array:
        """The links' base parameters (b,)."""
        return self.values[: self.base.count]

    @property
    def friction(self) -> tuple[JointFriction, ...]:
        """Of the motors, seen at the joints."""
        rows = np.array([self.of(name) for name in DRIVE.names]).T
        return tuple(DRIVE.friction_of(row) for row in rows)

    @property
    def bends(self) -> NDArray[np.bool_]:
        """(n,): whether a joint's stiffness is above 3 sigma; one that carries little bends by less than its noise."""
        return np.asarray(self.of("stiffness") > 3.0 * self.of("stiffness", sigma=True))

    def elasticity(self, otherwise: JointElasticity | None = None, source: str = "identified") -> JointElasticity:
        """The gears as a simulation takes them; a damping that noise put below 0 is 0.

        Joints whose stiffness is not identified have that of `otherwise`; without it raises `OptionError`.
        """
        stiffness, damping = self.of("stiffness"), np.maximum(self.of("damping"), 0.0)
        if otherwise is None:
            for joint in np.flatnonzero(~self.bends):
                wide = self.of("stiffness", sigma=True)[joint]
                found = f"{stiffness[joint]:.4g} +- {wide:.2g}"
                raise OptionError(f"stiffness of joint {joint + 1}", found, "a motion that bends it, or a value for it")
            return JointElasticity(stiffness, damping, source)
        stiffness = np.where(self.bends, stiffness, otherwise.stiffness)
        return JointElasticity(stiffness, np.where(self.bends, damping, otherwise.damping), source)


_PER_JOINT = len(DRIVE.names) + len(GEAR)
ROUNDS = 3
"""Of instruments and estimate in turn. Any torque that follows the links' will do; a better one is more precise."""


def identify_elastic(logs: Iterable[JointLog], arm: Arm, rule: SampleRule = TWO_ENCODERS) -> ElasticIdentification:
    """Gears, drives and links from logs with `motor_q`, the motors' positions seen at the joints (theta) [rad].

    Parameters
    ----------
    logs : iterable of JointLog
        `tau` is what the motors exert, seen at the joints.
    arm : Arm
        Gives the geometry; masses, rotors and stiffness play no part.
    rule : SampleRule
        How instants are taken; both encoders go through the same filter.

    Raises
    ------
    LogError
        A log without motor positions, uneven rows, or a motion that does not determine all parameters.

    References
    ----------
    Spong, Modeling and control of elastic joint robots (1987), for the model; Janot, Gautier, Jubien, Vandanjon,
    Comparison between the CLOE method and the DIDIM method for robots identification (2014), for fits by links and
    motors with both positions.
    """
    several = list(logs)
    links, motors = _both_sides(several, rule)
    columns = TorqueColumns(arm.chain)
    q, dq, ddq = np.random.default_rng(0).uniform(-WIDEST, WIDEST, (3, PROBES, columns.n))
    Y = columns.body_columns(q, dq, ddq)
    base, n = base_parameters(Y.reshape(-1, columns.bodies), columns.names[: columns.bodies]), columns.n
    y = np.concatenate([motors.tau, np.zeros_like(motors.tau)], axis=1)
    taper = np.concatenate([motors.used, np.ones_like(motors.used)], axis=1).astype(np.float64)
    torque = _torque_of(links, columns, base, _first_links(links, motors, columns, base))
    for _ in range(ROUNDS):
        slope = _slopes(torque, links)

        def blocks(torque: Array = torque, slope: Array = slope) -> Iterator[tuple[slice, Array, Array]]:
            for first in range(0, len(links), BLOCK):
                rows = slice(first, first + BLOCK)
                yield rows, *_rows(links.select(rows), motors.select(rows), columns, base, torque[rows], slope[rows])

        window = 3.0 * WINDOW  # both encoders are filtered: their noise lasts longer
        values, covariance, noise = instrumental_fit(blocks, y, taper, links, window)
        torque = _torque_of(links, columns, base, values[: base.count])
    names = tuple(base.names[k] for k in base.kept)
    names += tuple(f"{name}_{i}" for i in range(1, n + 1) for name in (*DRIVE.names, *GEAR))
    return ElasticIdentification(names, base, values, covariance, noise, int(taper.sum()))


def _both_sides(logs: list[JointLog], rule: SampleRule) -> tuple[Samples, Samples]:
    """The same instants of the links and of the motors."""
    turned = []
    for log in logs:
        if log.motor_q is None:
            needed = "the motors' positions too, qm1.., seen at the joints"
            raise LogError(log.source, "columns qm1..", "none", needed)
        turned.append(replace(log, q=log.motor_q))
    return samples_of(logs, rule), samples_of(turned, rule)


def _first_links(links: Samples, motors: Samples, columns: TorqueColumns, base: BaseParameters) -> Array:
    """The links' parameters (b,) from the drives alone; what they share with rotors is split by least norm."""
    n, parts = columns.n, []
    for first in range(0, len(links), BLOCK):
        rows = slice(first, first + BLOCK)
        X = np.zeros((*links.q[rows].shape, base.count + len(DRIVE.names) * n))
        X[:, :, : base.count] = _link_columns(links.select(rows), columns, base)
        for j in range(n):
            own = slice(base.count + len(DRIVE.names) * j, base.count + len(DRIVE.names) * (j + 1))
            X[:, j, own] = DRIVE(motors.dq[rows, j], motors.ddq[rows, j])
        parts.append(equations_of(X, motors.tau[rows], motors.used[rows]))
    total = sum(parts[1:], parts[0])  # samples have at least one instant
    start = np.sqrt(total.squares / np.maximum(total.equations, 1)) + 1e-9
    return grouped(total, start).values[: base.count]


def _link_columns(links: Samples, columns: TorqueColumns, base: BaseParameters) -> Array:
    return columns.body_columns(links.q, links.dq, links.ddq)[:, :, base.kept]


def _torque_of(links: Samples, columns: TorqueColumns, base: BaseParameters, values: Array) -> Array:
    """What the links need, (k, n) [N m]."""
    rows = [slice(i, i + BLOCK) for i in range(0, len(links), BLOCK)]
    return np.concatenate([_link_columns(links.select(r), columns, base) @ values for r in rows])


def _slopes(torque: Array, links: Samples) -> Array:
    """Its time derivative, (k, n), inside each recording."""
    out = np.zeros_like(torque)
    for each in np.unique(links.recording):
        rows = np.flatnonzero(links.recording == each)
        if rows.size > 1:
            out[rows] = np.gradient(torque[rows], links.t[rows], axis=0)
    return out


def _rows(
    links: Samples, motors: Samples, columns: TorqueColumns, base: BaseParameters, torque: Array, slope: Array
) -> tuple[Array, Array]:
    """W and Z (k, 2n, p): drives, then gears; they differ in what stands for the deflection and its speed."""
    k, n = links.q.shape
    W = np.zeros((k, 2 * n, base.count + _PER_JOINT * n))
    W[:, :n, : base.count] = W[:, n:, : base.count] = _link_columns(links, columns, base)
    Z = W.copy()
    for j in range(n):
        first = base.count + _PER_JOINT * j
        gear = first + len(DRIVE.names)
        W[:, j, first:gear] = Z[:, j, first:gear] = DRIVE(motors.dq[:, j], motors.ddq[:, j])
        W[:, n + j, gear], Z[:, n + j, gear] = links.q[:, j] - motors.q[:, j], -torque[:, j]
        W[:, n + j, gear + 1], Z[:, n + j, gear + 1] = links.dq[:, j] - motors.dq[:, j], -slope[:, j]
        W[:, n + j, gear + 2] = Z[:, n + j, gear + 2] = -1.0
    return W, Z


SHOWN = ("stiffness", "damping", "armature", "coulomb", "viscous", "offset")
UNITS = {
    "stiffness": "N m/rad", "damping": "N m s/rad", "armature": "kg m^2", "coulomb": "N m", "viscous": "N m s/rad",
    "offset": "N m", "zero": "N m",
}  # fmt: skip


class JointParameterRecord(TypedDict):
    """A parameter of a joint."""

    value: Annotated[float, "As seen at the joint."]
    standard_error: Annotated[float, "Of the value."]
    unit: Annotated[str, "Of both."]


def elastic_document(found: ElasticIdentification, arm: Arm, robot: str = "") -> Document:
    """Springs, dampers, rotors and friction of every joint, the noise of both sides, the links' base parameters."""
    cells = {name: (found.of(name), found.of(name, sigma=True)) for name in (*GEAR, *DRIVE.names)}
    own = ["-"] * found.n if arm.elasticity is None else arm.elasticity.stiffness.tolist()
    noise = [*zip(range(1, found.n + 1), found.noise[: found.n], found.noise[found.n :], strict=True)]
    rows = []
    for j, torque, gear in noise:
        shown = [with_error(*(float(x[j - 1]) for x in cells[name])) for name in SHOWN]
        parameters = {
            name: {"value": v[j - 1], "standard_error": s[j - 1], "unit": UNITS[name]} for name, (v, s) in cells.items()
        }
        rows.append((j, *shown, own[j - 1], bool(found.bends[j - 1]), torque, gear, parameters))
    columns = (
        Heading("joint", says="From 1."), *(Heading(name, UNITS[name], key=None) for name in SHOWN),
        Heading("stiffness of the model", "", ".5g", None),
        Heading(key="bends", says="Whether the stiffness is above 3 sigma."),
        Heading(key="torque_noise", says="Of the motor's torque, N m."),
        Heading(key="gear_noise", says="Of the gear's torque, N m: the stiffness times the encoders' noise."),
        Heading(key="parameters", kind=dict[str, JointParameterRecord], says="Stiffness, damping, zero (stiffness "
                "times the angle between the encoders' zeros), rotor and friction of the motor seen at the joint."),
    )  # fmt: skip
    weak = [
        f"stiffness of joint {j + 1} not identified: it carries too little to bend beyond its encoders"
        for j in np.flatnonzero(~found.bends)
    ]
    said = "rotors and friction are the motors', seen at the joints"
    sides = (
        Heading("joint"), Heading("noise of the torque", "N m", ".4g"), Heading("of the gear", "N m", ".4g"),
    )  # fmt: skip
    links = zip(found.base.statements(), found.links, found.sigma, strict=False)
    names = (Heading(key="parameter", says="A combination of the links' masses, first moments and tensors, SI."),
             Heading(key="value", says="SI."), Heading(key="standard_error", says="Of the value."))  # fmt: skip
    sections = [
        Section("", [Table("", columns, rows, said, "joints", "Joint by joint."), Note(weak)]),
        Section("Noise", [Table("", sides, noise)]),
        Section("Links", [Table("", names, [*links], "", "links", "Base parameters of the links, without rotors.")]),
    ]
    verdict = f"{len(found.values)} parameters from {found.equations} equations, {found.base.count} of them the links'"
    facts = [Fact("robot", robot, "Name of the robot."), Fact("equations", found.equations, "How many were used.")]
    return Document("Elastic joints", verdict, sections, "lwr-dyn identify elastic", facts=facts, caveats=())
