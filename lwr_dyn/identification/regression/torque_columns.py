"""Torques of an arm as columns times parameters: bodies of one geometry, rotor and friction of each joint."""

from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.batch import BatchDynamics
from lwr_dyn.codegen.kernels.kernel import require_packages
from lwr_dyn.codegen.kernels.kernel_spec import PER_LINK, KernelSpec
from lwr_dyn.dynamics.regressor import INERTIAL, Regressor, body_parameters
from lwr_dyn.foundation.arrays import Array, fixed_array, read_only
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.identification.regression.joints_alone import seen_alone
from lwr_dyn.identification.regression.least_squares import BaseParameters, base_parameters
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, Chain
from lwr_dyn.model.friction import FRICTIONLESS, Direction, JointFriction
from lwr_dyn.model.transmission import Transmission

FrictionForm = Literal["symmetric", "directions"]
FORMS = get_args(FrictionForm)
_NAMES = {
    "symmetric": ("armature", "coulomb", "viscous", "offset"),
    "directions": ("armature", "coulomb+", "viscous+", "coulomb-", "viscous-"),
}
LOAD = "load"
"""Name of the column of friction that grows with the load."""
MOST_LOAD = 0.99
"""Largest share that a model is given: one of 1 is a gear that its load cannot drive back."""
_STRIBECK = {"symmetric": ("stribeck",), "directions": ("stribeck+", "stribeck-")}


@dataclass(frozen=True, slots=True)
class JointColumns:
    """Rotor and friction of a joint (or of a motor) as columns.

    symmetric:   tau = armature ddq + coulomb sign(dq) + viscous dq + offset + stribeck sign(dq) exp(-(dq/v_s)^2)
    directions:  the same with magnitudes of their own for dq > 0 and dq < 0, and without an offset, which is theirs:
                 half the difference of the two levels
    load:        load |tau_load| sign(dq), a share of the torque that the gear carries

    Parameters
    ----------
    form : {"symmetric", "directions"}
    stribeck : tuple of float
        v_s [rad/s or m/s]: none, one, or several to choose from (`regression.stribeck`).
    link_side : bool
        Whether torques are measured behind the gears: no rotor reaches them, and the armature's column is 0.
    load : bool
        Whether friction grows with the torque carried (`regression.load_friction`).

    References
    ----------
    `lwr_dyn.model.friction.Direction`, whose static - coulomb is the parameter stribeck.
    """

    form: FrictionForm
    stribeck: tuple[float, ...] = ()
    link_side: bool = False
    load: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Of the columns, without the joint's number.

        >>> JointColumns("symmetric", (0.05,)).names
        ('armature', 'coulomb', 'viscous', 'offset', 'stribeck')
        """
        several = len(self.stribeck) > 1
        drops = [f"{name}@{v:g}" if several else name for v in self.stribeck for name in _STRIBECK[self.form]]
        return (*_NAMES[self.form], *([LOAD] if self.load else []), *drops)

    @property
    def linear(self) -> int:
        """How many columns stand before those of the Stribeck drops."""
        return len(_NAMES[self.form]) + self.load

    def __call__(self, dq: Array, ddq: Array, carried: Array | None = None) -> Array:
        """(k, f) for dq, ddq (k,) and, where friction grows with it, the torque that the gear carries (k,) [N m or N].

        At dq = 0 all friction but the offset is 0.
        """
        sign, ddq = np.sign(dq), np.zeros_like(ddq) if self.link_side else ddq
        load = [] if carried is None else [np.abs(carried) * sign]
        drop = [sign * np.exp(-np.square(dq / v)) for v in self.stribeck]
        if self.form == "symmetric":
            return np.column_stack([ddq, sign, dq, np.ones_like(dq), *load, *drop])
        up, down = dq > 0.0, dq < 0.0
        sides = [x * side for side in (up, down) for x in (sign, dq)]
        return np.column_stack([ddq, *sides, *load, *(x * side for x in drop for side in (up, down))])

    def values_of(self, model: JointFriction | None, armature: float) -> list[float]:
        """The parameters (f,) of a friction model: the mean of its directions where the form is symmetric.

        The Stribeck term is taken as the model's own, whatever its v_s.
        """
        given = model or FRICTIONLESS
        sides = (given.positive, given.negative)
        load = [given.load] if self.load else []
        drops = [side.holding - side.coulomb for side in sides] if self.stribeck else []
        if self.form == "symmetric":
            up, down = sides
            offset = given.offset + (up.coulomb - down.coulomb) / 2
            levels = [(up.coulomb + down.coulomb) / 2, (up.viscous + down.viscous) / 2, offset]
            return [armature, *levels, *load, *([sum(drops) / 2] if drops else [])]
        offsets = (given.offset, -given.offset)
        pairs = [x for side, extra in zip(sides, offsets, strict=True) for x in (side.coulomb + extra, side.viscous)]
        return [armature, *pairs, *load, *drops]

    def friction_of(self, values: Array) -> JointFriction:
        """The model that parameters (f,) describe; a level or a Stribeck term that noise put below 0 is 0.

        With directions the model has no offset of its own unless a level is below 0: then half the difference of the
        two levels is the offset. A share of the load below 0 is 0, one of 1 and more `MOST_LOAD`.
        """
        load = float(np.clip(values[self.names.index(LOAD)], 0.0, MOST_LOAD)) if self.load else 0.0
        v, drops = [float(x) for x in values], [float(x) for x in values[self.linear :]]
        if self.form == "symmetric":
            side = self._direction(v[1], v[2], drops)
            return JointFriction(side, side, v[3], load=load)
        offset = 0.0 if min(v[1], v[3]) >= 0.0 else (v[1] - v[3]) / 2
        up, down = self._direction(v[1] - offset, v[2], drops[:1]), self._direction(v[3] + offset, v[4], drops[1:])
        return JointFriction(up, down, offset, load=load)

    def _direction(self, coulomb: float, viscous: float, drop: list[float]) -> Direction:
        level = max(coulomb, 0.0)
        if not drop or drop[0] <= 0.0:
            return Direction(level, viscous)
        return Direction(level, viscous, level + drop[0], self.stribeck[0])


PROBES = 400
"""Random states whose columns determine the base parameters of a geometry."""
WIDEST = 2.0
"""Largest position, speed and acceleration among them [rad, rad/s, rad/s^2; m for sliding joints]."""
BLOCK = 2048
"""States at once, where only torques are wanted."""
MANY = 20_000
"""States that are worth another kernel, which is compiled once for a geometry."""
FROM_KERNEL = np.array([PER_LINK.index(name) for name in INERTIAL])
"""Place of each of `INERTIAL` in a link's ten columns of the kernel, which has Pinocchio's order."""


@dataclass(frozen=True, slots=True, eq=False)
class TorqueColumns:
    """tau = Y(q, dq, ddq) pi for the geometry of one chain; its masses play no part.

    Columns: ten per link in the order of `dynamics.regressor.INERTIAL`, about the origin of the link's frame, then
    those of `JointColumns` joint by joint: rotor, friction and, where v_s is given, the Stribeck drop.

    Parameters
    ----------
    friction : {"symmetric", "directions"}
    stribeck_velocity : (n,) array_like, optional
        v_s of every joint [rad/s or m/s], NaN for a joint without a Stribeck column; (n, s) for several of each, to
        choose from.
    transmission : Transmission, optional
        The motor map dq_m = T dq: rotors and friction are those of the motors then, with their speeds, and act on the
        joints through T^T (v_s too is at the motor).
    link_side : bool
        As `JointColumns`.
    carried : (11 n,) array, optional
        Bodies and rotors (`table_indices`) whose torque friction grows with, a column a joint; none if not given.

    Raises
    ------
    OptionError
        Another form of friction, a Stribeck speed that is not above 0, a transmission of another size.
    ShapeError
        Not one Stribeck speed per joint.

    References
    ----------
    Siciliano et al., *Robotics*, section 7.2.2, eq. 7.52 (linearity in the dynamic parameters).
    """

    chain: Chain
    friction: FrictionForm = "symmetric"
    stribeck_velocity: Any = None
    transmission: Transmission | None = None
    link_side: bool = False
    carried: Any = None
    joints: tuple[JointColumns, ...] = field(init=False)
    names: tuple[str, ...] = field(init=False)
    _kernel: BatchDynamics | None = field(init=False, repr=False)
    _base: list[BaseParameters] = field(init=False, repr=False, default_factory=list)

    def __post_init__(self) -> None:
        if self.friction not in FORMS:
            raise OptionError("friction", repr(self.friction), ", ".join(FORMS))
        n = self.chain.n
        if self.transmission is not None and self.transmission.n != n:
            raise OptionError("transmission", f"of {self.transmission.n} motors", f"{n}, one per joint")
        speeds = _speeds(self.stribeck_velocity, n)
        form, load = self.friction, self.carried is not None
        joints = tuple(JointColumns(form, tuple(v[~np.isnan(v)].tolist()), self.link_side, load) for v in speeds)
        links = [f"{name}_{i}" for i in range(1, n + 1) for name in INERTIAL]
        own = [f"{name}_{i}" for i, joint in enumerate(joints, 1) for name in joint.names]
        if self.stribeck_velocity is not None:
            object.__setattr__(self, "stribeck_velocity", read_only(self.stribeck_velocity))
        if load:
            object.__setattr__(self, "carried", fixed_array("carried", self.carried, (11 * n,)))
        object.__setattr__(self, "joints", joints)
        object.__setattr__(self, "names", (*links, *own))
        object.__setattr__(self, "_kernel", _kernel_of(self.chain))

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.chain.n

    @property
    def count(self) -> int:
        """Number of columns p."""
        return len(self.names)

    @property
    def bodies(self) -> int:
        """How many columns, the first ones, are those of bodies: 10 n."""
        return len(INERTIAL) * self.n

    def of_joint(self, joint: int) -> slice:
        """The columns of rotor and friction of a joint (from 0)."""
        first = self.bodies + sum(len(j.names) for j in self.joints[:joint])
        return slice(first, first + len(self.joints[joint].names))

    @property
    def rotor_indices(self) -> NDArray[np.intp]:
        """Columns of the rotors, (n,)."""
        return np.array([self.of_joint(j).start for j in range(self.n)], dtype=np.intp)

    @property
    def table_indices(self) -> NDArray[np.intp]:
        """Columns of bodies, then of rotors, (11 n,): what a table of inertias gives."""
        return np.concatenate([np.arange(self.bodies), self.rotor_indices])

    @property
    def friction_indices(self) -> NDArray[np.intp]:
        """Columns that are neither of bodies nor of rotors."""
        return np.setdiff1d(np.arange(self.bodies, self.count), self.rotor_indices)

    @property
    def kernel(self) -> BatchDynamics | None:
        """The compiled bodies' columns, the tensor in Pinocchio's order (`FROM_KERNEL`); None without `batch`."""
        return self._kernel

    def __call__(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Y (k, n, p) for states (k, n): torque of a joint [N m or N] per unit of a parameter (SI)."""
        out = np.zeros((len(q), self.n, self.count))
        out[:, :, : self.bodies] = self.body_columns(q, dq, ddq)
        for i, values in enumerate(self.own_columns(q, dq, ddq)):
            for j in range(self.n):
                if reach := self.reach(j, i):
                    out[:, j, self.of_joint(i)] = reach * values
        return out

    def body_columns(self, q: Array, dq: Array, ddq: Array) -> Array:
        """The first 10 n columns, (k, n, 10 n)."""
        raw = self.raw_bodies(q, dq, ddq)
        if self._kernel is None:
            return raw
        by_link = raw.reshape(len(q), self.n, self.n, len(INERTIAL))
        return np.asarray(by_link[..., FROM_KERNEL].reshape(len(q), self.n, self.bodies))

    def raw_bodies(self, q: Array, dq: Array, ddq: Array) -> Array:
        """The same in the order of the kernel (`FROM_KERNEL`) where there is one; uncopied if rows are contiguous."""
        if self._kernel is None:
            return Regressor(self.chain)(q, dq, ddq)[:, :, : self.bodies]
        return self._kernel.torque_regressor(q, dq, ddq)

    def torques(self, q: Array, dq: Array, ddq: Array, parameters: Array) -> Array:
        """Y pi (k, n) [N m or N] of parameters (p,), or of base values (b,), without Y where there are many states."""
        pi = parameters
        if parameters.size != self.count:
            pi = np.zeros(self.count)
            pi[self.base().kept] = parameters
        out = self._of_bodies(q, dq, ddq, pi[: self.bodies])
        for first in range(0, len(q), BLOCK):
            rows = slice(first, first + BLOCK)
            for i, columns in enumerate(self.own_columns(q[rows], dq[rows], ddq[rows])):
                own = columns @ pi[self.of_joint(i)]
                for j in range(self.n):
                    if reach := self.reach(j, i):
                        out[rows, j] += reach * own
        return out

    def _of_bodies(self, q: Array, dq: Array, ddq: Array, bodies: Array) -> Array:
        """Torques (k, n) of bodies (10 n,) alone."""
        out, inertia = np.empty((len(q), self.n)), np.empty((self.n, len(INERTIAL)))
        inertia[:, FROM_KERNEL] = bodies.reshape(self.n, -1)
        for first in range(0, len(q), BLOCK):
            rows = slice(first, first + BLOCK)
            if self._kernel is None or len(q) <= MANY:
                out[rows] = self.body_columns(q[rows], dq[rows], ddq[rows]) @ bodies
            else:
                out[rows] = self._kernel.inverse_dynamics(q[rows], dq[rows], ddq[rows], inertia=inertia)
        return out

    def own_columns(self, q: Array, dq: Array, ddq: Array) -> list[Array]:
        """Rotor and friction of every joint (motor with a transmission) at its own speed, n of (k, f)."""
        speed, rate = self.drive_speeds(dq), self.drive_speeds(ddq)
        load = None if self.carried is None else self._loads(q, dq, ddq, rate).T
        return [
            joint(speed[:, i], rate[:, i], None if load is None else load[i]) for i, joint in enumerate(self.joints)
        ]

    def drive_speeds(self, dq: Array) -> Array:
        """Of joints (k, n), or of the motors with a transmission."""
        return dq if self.transmission is None else np.asarray(dq @ self.transmission.matrix.T)

    def _loads(self, q: Array, dq: Array, ddq: Array, rate: Array) -> Array:
        """Torques (k, n) of `carried` at the joints or motors, whose accelerations are `rate`."""
        bodies = self._of_bodies(q, dq, ddq, self.carried[: self.bodies])
        if self.transmission is not None:
            bodies = np.asarray(np.linalg.solve(self.transmission.matrix.T, bodies.T).T, dtype=np.float64)
        return bodies if self.link_side else np.asarray(bodies + rate * self.carried[self.bodies :])

    def reach(self, joint: int, other: int) -> float:
        """What the columns of `other` count in the equation of `joint`: 1 or 0; T[other, joint] with a transmission."""
        return float(joint == other) if self.transmission is None else float(self.transmission.matrix[other, joint])

    def own(self, arm: Arm) -> Array:
        """The arm's own values of the parameters, (p,): table's bodies and rotors, its friction where it has one.

        With a transmission they are those of motors that give the joints' (`seen_alone`), the smallest where several
        do; of motors with units of their own, friction, which the arm has at the joints, is left at 0.
        """
        links = [body_parameters(link.body or Body.massless()) for link in arm.chain.links]
        rotors = [0.0 if link.rotor is None else link.rotor.armature for link in arm.chain.links]
        alone = seen_alone(self.names, self.transmission)
        if self.transmission is not None and alone is None:
            out = np.concatenate([*links, np.zeros(self.count - self.bodies)])
            out[self.rotor_indices] = np.linalg.lstsq(self.transmission.matrix.T**2, np.array(rotors), rcond=1e-9)[0]
            return out
        rows = zip(self.joints, arm.friction_models(), rotors, strict=True)
        out = np.concatenate([*links, *(joint.values_of(model, rotor) for joint, model, rotor in rows)])
        if alone is not None:
            own = slice(self.bodies, None)
            out[own] = np.linalg.lstsq(alone[own, own], out[own], rcond=1e-9)[0]
        return out

    def friction_of(self, parameters: Array) -> tuple[JointFriction, ...]:
        """The friction models that parameters (p,) describe, one per joint (per motor with a transmission)."""
        return tuple(joint.friction_of(parameters[self.of_joint(i)]) for i, joint in enumerate(self.joints))

    def base(self) -> BaseParameters:
        """Which combinations any motion can determine, found once from `PROBES` random states.

        Never from a log: at 2 s of motion the rank already depends on the tolerance, here it does not. Friction that
        grows with the load stands beside them, whatever bodies it grows with.

        References
        ----------
        Gautier, Numerical calculation of the base inertial parameters of robots (1991).
        """
        if not self._base and self.carried is not None:
            self._base.append(self._with_loads(replace(self, carried=None).base()))
        if not self._base:
            q, dq, ddq = np.random.default_rng(0).uniform(-WIDEST, WIDEST, (3, PROBES, self.n))
            self._base.append(base_parameters(self(q, dq, ddq).reshape(-1, self.count), self.names))
        return self._base[0]

    def _with_loads(self, plain: BaseParameters) -> BaseParameters:
        at = {name: k for k, name in enumerate(self.names)}
        moved = np.array([at[name] for name in plain.names], dtype=np.intp)
        kept = np.sort(np.concatenate([moved[plain.kept], np.setdiff1d(np.arange(self.count), moved)]))
        grouping = np.zeros((kept.size, self.count))
        grouping[np.ix_(np.isin(kept, moved), moved)] = plain.grouping
        loads = np.flatnonzero(~np.isin(kept, moved))
        grouping[loads, kept[loads]] = 1.0
        return BaseParameters(self.names, kept, grouping)


def _speeds(given: Any, n: int) -> Array:
    """v_s of every joint, (n, s), NaN for none."""
    if given is None:
        return np.full((n, 1), np.nan)
    raw = np.asarray(given, dtype=np.float64)
    none = np.isnan(raw)
    shape = (n, raw.shape[1]) if raw.ndim == 2 else (n,)
    speeds = fixed_array("stribeck velocity", np.where(none, 1.0, raw), shape).reshape(n, -1)
    for j in np.flatnonzero((speeds <= 0.0).any(axis=1)):
        raise OptionError("stribeck velocity", f"{speeds[j].min():g} of joint {j + 1}", "above 0, or NaN for none")
    return np.where(none.reshape(n, -1), np.nan, speeds)


def _kernel_of(chain: Chain) -> BatchDynamics | None:
    """The kernel of the geometry alone, so that arms with other masses share it."""
    try:
        require_packages()
    except MissingPackageError:
        return None
    links = tuple(replace(link, body=Body.massless(), rotor=None) for link in chain.links)
    return BatchDynamics(KernelSpec("columns", replace(chain, links=links), None, ("inertia",), "none"))
