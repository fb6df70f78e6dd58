"""Torques of one set and what is fitted beside it: friction, rotors, couplings, gains of the torques, a free load.

    tau_j = gain_j (model_j + Y_j load) + friction_j + armature_j ddq_j

Friction of a joint: a Coulomb level of each direction (beyond `SLOW`), viscous, and an offset. A coupled motor adds its
friction and rotor on the speeds of the other joints that it turns with. `load` are the ten inertial parameters of a
body on the last link. All is least squares on the rows that train; what counts is what is left of the rows that test.
"""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.regressor import INERTIAL, Regressor
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.ranking.filtered_log import FilteredLog
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import friction_torque
from lwr_dyn.model.transmission import Transmission

SLOW = 0.01
"""[rad/s or m/s] up to which a joint has no Coulomb friction."""
LOAD, GAIN, ROTOR, COUPLING = FREE = ("load", "gain", "rotor", "coupling")
"""What can be freed beside the friction."""
LOAD_CUT, FLOOR_CUT = 1e-5, 1e-4
"""Singular values, as shares of the largest, below which directions of the parameters are left out."""
PASSES = 3
"""Passes of the least squares in which joints are weighted by what the pass before left of them."""
UNSURE = 0.1
"""Standard error of a gain, by residuals taken as white, beyond which it is not said."""
TURNS, SETTLED = 200, 1e-10
"""Passes between gains and load at most; relative change of the squares at which they end."""


@dataclass(frozen=True, slots=True, eq=False)
class Modelled:
    """A log with the torques of one set: `log`, `model` (k, n), and `body` (k, n, 10) of a load on the last link."""

    log: FilteredLog
    model: Array
    body: Array


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """What was found beside a set on the rows that train.

    `left` (k, n) is what it leaves of the torques of the rows that test, `predicted` those of train and test. `gains`
    (n,) are torques of the log over those of the model, NaN where uncertain by more than `UNSURE`; `rotors` (n,)
    [kg m^2], `load` (10,) [kg, kg m, kg m^2]; None where not fitted.
    """

    free: tuple[str, ...]
    left: Array
    predicted: tuple[Array, Array]
    gains: Array | None = None
    rotors: Array | None = None
    load: Array | None = None

    @property
    def rms(self) -> Array:
        """What is left of each joint, (n,) [N m or N]."""
        return np.asarray(np.sqrt(np.mean(np.square(self.left), axis=0)))

    @property
    def total(self) -> float:
        """What is left over all joints."""
        return float(np.sqrt(np.mean(np.square(self.left))))


class Torques:
    """Torques of arms on one log, train and test; columns of bodies are shared by sets of one geometry."""

    def __init__(self, train: FilteredLog, test: FilteredLog) -> None:
        self.train, self.test = train, test
        self._bodies: dict[bytes, tuple[Array, Array]] = {}

    def of(self, arm: Arm) -> tuple[Modelled, Modelled]:
        """Train and test with the torques of the arm's bodies, without rotors and friction."""
        dynamics, bodies = dynamics_of(arm), self.bodies(arm)
        last = slice(-len(INERTIAL), None)
        train, test = (
            Modelled(log, dynamics.inverse_dynamics(log.q, log.dq, log.ddq) - log.ddq * arm.armature, Y[..., last])
            for log, Y in zip((self.train, self.test), bodies, strict=True)
        )
        return train, test

    def bodies(self, arm: Arm) -> tuple[Array, Array]:
        """Columns (k, n, 10 n) of the ten parameters of each link, train and test."""
        chain = arm.chain
        places = [
            x for link in chain.links for pose in (link.before, link.after) for x in (pose.rotation, pose.position)
        ]
        key = b"".join(np.ascontiguousarray(x).tobytes() for x in (*places, chain.gravity))
        if key not in self._bodies:
            Y, count = Regressor(chain), len(INERTIAL) * chain.n
            train, test = (Y(log.q, log.dq, log.ddq)[..., :count] for log in (self.train, self.test))
            self._bodies[key] = train, test
        return self._bodies[key]


def with_own_friction(both: tuple[Modelled, Modelled], arm: Arm) -> Fit | None:
    """The set with the friction that it publishes, and nothing fitted; None where it publishes none."""
    if not arm.has_friction:
        return None
    train, test = (one.model + friction_torque(arm.friction_models(), one.log.dq, one.model) for one in both)
    return Fit((), both[1].log.tau - test, (train, test))


def joint_columns(log: FilteredLog, j: int, free: Collection[str], transmission: Transmission | None) -> Array:
    """Friction of joint j (from 0), (k, f): up, down, speed, 1; then its rotor; then what coupled motors add."""
    dq, ddq = log.dq[:, j], log.ddq[:, j]
    columns = [dq > SLOW, -1.0 * (dq < -SLOW), dq, np.ones(len(dq))]
    columns += [ddq] if ROTOR in free else []
    if COUPLING in free and transmission is not None:
        for motor in transmission.matrix[transmission.matrix[:, j] != 0.0]:
            others = [k for k in np.flatnonzero(motor) if k != j]
            if others:
                columns += [log.dq[:, k] for k in others] + [np.sign(log.dq @ motor)]
                columns += [log.ddq[:, k] for k in others] if ROTOR in free else []
    return np.column_stack(columns).astype(np.float64)


def fit_set(both: tuple[Modelled, Modelled], free: tuple[str, ...], transmission: Transmission | None = None) -> Fit:
    """The set with its friction, and what is freed, fitted on the first of both and tried on the second."""
    train, test = both
    n = train.model.shape[1]
    X, Z = ([joint_columns(one.log, j, free, transmission) for j in range(n)] for one in both)
    if LOAD in free:
        found = (_load_and_gains if GAIN in free else _load)(train, X)
    else:
        found = _joint_by_joint(train, X, GAIN in free)
    predicted = [
        np.column_stack([
            found.gains[j] * (one.model[:, j] + one.body[:, j] @ found.load) + columns[j] @ found.own[j]
            for j in range(n)
        ])
        for one, columns in ((train, X), (test, Z))
    ]  # fmt: skip
    return Fit(
        free, test.log.tau - predicted[1], (predicted[0], predicted[1]),
        gains=_sure(train, X, found) if GAIN in free else None,
        rotors=np.array([own[4] for own in found.own]) if ROTOR in free else None,
        load=found.load if LOAD in free else None,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """Gains (n,), load (10,) and the own columns of each joint."""

    gains: Array
    load: Array
    own: list[Array]


def _sure(train: Modelled, X: list[Array], found: _Found) -> Array:
    """Gains (n,), NaN where the model's torque differs too little from the joint's own columns."""
    out = found.gains.copy()
    for j, columns in enumerate(X):
        model = train.model[:, j] + train.body[:, j] @ found.load
        apart = model - columns @ _squares(columns, model)
        left = train.log.tau[:, j] - found.gains[j] * model - columns @ found.own[j]
        if not UNSURE**2 * np.sum(np.square(apart)) > np.mean(np.square(left)):
            out[j] = np.nan
    return out


def _joint_by_joint(train: Modelled, X: list[Array], gain: bool) -> _Found:
    gains, own = np.ones(len(X)), []
    for j, columns in enumerate(X):
        if gain:
            both = np.column_stack([columns, train.model[:, j]])
            *found, gains[j] = _squares(both, train.log.tau[:, j])
            own.append(np.array(found))
        else:
            own.append(_squares(columns, train.log.tau[:, j] - train.model[:, j]))
    return _Found(gains, np.zeros(len(INERTIAL)), own)


def _load(train: Modelled, X: list[Array], gains: Array | None = None) -> _Found:
    """Load and friction together: the load is that of all joints."""
    k, n = train.model.shape
    scale = np.ones(n) if gains is None else gains
    ends = np.cumsum([len(INERTIAL), *(columns.shape[1] for columns in X)])
    A = np.zeros((k, n, ends[-1]))
    A[..., : len(INERTIAL)] = train.body * scale[:, None]
    for j, columns in enumerate(X):
        A[:, j, ends[j] : ends[j + 1]] = columns
    found = _squares(A.reshape(k * n, -1), (train.log.tau - train.model * scale).ravel(), LOAD_CUT)
    return _Found(scale, found[: len(INERTIAL)], np.split(found, ends[:-1])[1:])


def _load_and_gains(train: Modelled, X: list[Array]) -> _Found:
    """In turn: the load with the gains as they are, the gains with that load."""
    gains, before = np.ones(len(X)), np.inf
    for _ in range(TURNS):
        load = _load(train, X, gains).load
        whole = Modelled(train.log, train.model + train.body @ load, train.body)
        found = _joint_by_joint(whole, X, gain=True)
        gains = found.gains
        squares = sum(
            float(np.sum(np.square(train.log.tau[:, j] - gains[j] * whole.model[:, j] - X[j] @ found.own[j])))
            for j in range(len(X))
        )
        if before - squares <= SETTLED * squares:
            break
        before = squares
    return _Found(gains, load, found.own)


def _squares(A: Array, b: Array, cut: float | None = None) -> Array:
    return np.asarray(np.linalg.lstsq(A, b, rcond=cut)[0])


def floor_of(torques: Torques, arm: Arm, free: tuple[str, ...]) -> Array:
    """What the least squares of all parameters leave of the rows that test, (k, n): no set of bodies need have them.

    The same friction, and rotors and couplings where they are free; `PASSES` passes of joint weights.
    """
    n = arm.n
    sides = []
    for log, Y in zip((torques.train, torques.test), torques.bodies(arm), strict=True):
        own = [joint_columns(log, j, free, arm.transmission) for j in range(n)]
        ends = np.cumsum([Y.shape[2], *(columns.shape[1] for columns in own)])
        A = np.zeros((len(log), n, ends[-1]))
        A[..., : Y.shape[2]] = Y
        for j, columns in enumerate(own):
            A[:, j, ends[j] : ends[j + 1]] = columns
        sides.append(A)
    train, test = sides
    weight = np.ones(n)
    for _ in range(PASSES):
        rows = (train * weight[:, None]).reshape(-1, train.shape[2])
        found = _squares(rows, (torques.train.tau * weight).ravel(), FLOOR_CUT)
        weight = 1.0 / np.sqrt(np.mean(np.square(torques.train.tau - train @ found), axis=0))
    return np.asarray(torques.test.tau - test @ found)
