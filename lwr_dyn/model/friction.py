"""Friction of one joint: Coulomb, viscous, static and Stribeck per direction, an offset, or a sigmoid of the speed.

The numbers of a `Direction` are magnitudes, positive when friction opposes the motion in that direction. The friction
torque has the sign of the velocity: B ddq + C dq + g = tau - tau_friction(dq).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import OptionError


@dataclass(frozen=True, slots=True)
class Direction:
    """Friction of a joint in one direction of motion.

    magnitude(v) = coulomb + viscous v + (static - coulomb) exp(-(v / stribeck_velocity)^2),  v = |dq| > 0.

    Parameters
    ----------
    coulomb : float
        Level of a moving joint at vanishing speed, at least 0 [N m or N].
    viscous : float
        Slope [N m s/rad or N s/m]. May be negative: beyond some speed such friction adds energy
        (see `lwr_dyn.model.passivity`).
    static : float, optional
        Largest friction at rest, at least `coulomb` [N m or N]; None is unknown and counts as `coulomb`.
    stribeck_velocity : float, optional
        Speed scale of the drop from static to Coulomb, above 0 [rad/s or m/s]; None drops at once.

    Raises
    ------
    OptionError
        A number is not finite or out of its range.

    References
    ----------
    WAM paper, eq. (6), for Coulomb and viscous; Olsson et al., Friction models and friction compensation (1998).
    """

    coulomb: float
    viscous: float
    static: float | None = None
    stribeck_velocity: float | None = None

    def __post_init__(self) -> None:
        for name in ("coulomb", "viscous", "static", "stribeck_velocity"):
            value = getattr(self, name)
            if value is not None and not math.isfinite(value):
                raise OptionError(f"friction {name}", value, "a finite number")
        if self.coulomb < 0.0:
            raise OptionError("friction coulomb", self.coulomb, "0 or more")
        if self.static is not None and self.static < self.coulomb:
            raise OptionError("friction static", self.static, f"at least the Coulomb level {self.coulomb:g}, or none")
        if self.stribeck_velocity is not None and self.stribeck_velocity <= 0.0:
            raise OptionError("friction stribeck_velocity", self.stribeck_velocity, "above 0, or none")

    @property
    def holding(self) -> float:
        """Largest friction at rest: static, or Coulomb if static is unknown [N m or N]."""
        return self.coulomb if self.static is None else self.static

    def magnitude(self, speed: ArrayLike) -> Array:
        """Magnitude of friction at speeds (...) > 0 [rad/s or m/s]; shape (...) [N m or N]."""
        v = np.asarray(speed, dtype=float)
        level = self.coulomb + self.viscous * v
        drop = self.holding - self.coulomb
        if drop > 0.0 and self.stribeck_velocity is not None:
            level = level + drop * np.exp(-np.square(v / self.stribeck_velocity))
        return np.asarray(level)


def _logistic(x: ArrayLike) -> Array:
    """1 / (1 + exp(-x)), without overflow."""
    return np.asarray(0.5 * (1.0 + np.tanh(0.5 * np.asarray(x, dtype=float))))


@dataclass(frozen=True, slots=True)
class Sigmoid:
    """Friction as a sigmoid of the velocity less its value at rest: smooth, so that it holds no joint at rest.

    torque(dq) = level / (1 + exp(-slope (dq + shift))) - level / (1 + exp(-slope shift))

    Parameters
    ----------
    level : float
        From its lowest to its highest value, at least 0 [N m or N].
    slope : float
        Above 0 [s/rad or s/m].
    shift : float
        Of the speed at which it is steepest, -shift [rad/s or m/s].

    Raises
    ------
    OptionError
        A number is not finite or out of its range.

    References
    ----------
    Gaz et al., Dynamic identification of the Franka Emika Panda robot (2019), eq. (24), with the constants of the
    authors' `get_FrictionTorque.m`.

    >>> Sigmoid(0.54615, 5.1181, 0.039533).torque([-2.0, 0.0, 2.0]).round(4).tolist()
    [-0.3006, 0.0, 0.2455]
    """

    level: float
    slope: float
    shift: float

    def __post_init__(self) -> None:
        for name in ("level", "slope", "shift"):
            if not math.isfinite(getattr(self, name)):
                raise OptionError(f"friction sigmoid {name}", getattr(self, name), "a finite number")
        for name, is_bad, least in (("level", self.level < 0.0, "0 or more"), ("slope", self.slope <= 0.0, "above 0")):
            if is_bad:
                raise OptionError(f"friction sigmoid {name}", getattr(self, name), least)

    def torque(self, dq: ArrayLike) -> Array:
        """Of velocities (...) [rad/s or m/s]; shape (...) [N m or N]."""
        moved = _logistic(self.slope * (np.asarray(dq, dtype=float) + self.shift))
        return np.asarray(self.level * (moved - _logistic(self.slope * self.shift)))

    @property
    def most(self) -> float:
        """The largest size that it tends to at high speeds of either direction [N m or N]."""
        at_rest = float(_logistic(self.slope * self.shift))
        return self.level * max(at_rest, 1.0 - at_rest)

    @property
    def steepest(self) -> float:
        """Its largest slope over the velocity [N m s/rad or N s/m]."""
        return self.level * self.slope / 4.0

    def from_motor(self, ratio: float) -> "Sigmoid":
        """As seen at the joint, r f(r dq), of one that is printed for the motor's speed r dq."""
        return Sigmoid(abs(ratio) * self.level, abs(ratio) * self.slope, self.shift / ratio)


@dataclass(frozen=True, slots=True)
class JointFriction:
    """Friction of one joint: a pair of directions and an offset that is there at any speed, rest included.

    >>> wam_1 = JointFriction(positive=Direction(4.4748, 1.3348), negative=Direction(4.3609, 0.8266))
    >>> wam_1.torque([-0.1, 0.1]).round(4).tolist()
    [-4.4436, 4.6083]
    >>> wam_1.breakaway
    (-4.3609, 4.4748)
    """

    positive: Direction
    negative: Direction
    offset: float = 0.0
    covered: float | None = None
    """The largest speed at which it was measured [rad/s or m/s]; None is unknown."""
    sigmoid: Sigmoid | None = None
    """Added to the directions and the offset."""
    load: float = 0.0
    """Share of the torque that the gear carries, at least 0 and below 1: load |tau_carried| sign(dq) more in both
    directions, tau_carried what bodies and rotor ask. `torque`, which has no such torque, leaves it out, and runs do
    (`Arm.friction_with_load`)."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.load < 1.0:
            raise OptionError("friction load", self.load, "a share of at least 0 and below 1")
        if not math.isfinite(self.offset):
            raise OptionError("friction offset", self.offset, "a finite number")
        if self.covered is not None and not (math.isfinite(self.covered) and self.covered > 0.0):
            raise OptionError("friction covered", self.covered, "a speed above 0, or none")

    def torque(self, dq: ArrayLike) -> Array:
        """Friction torque of a moving joint, offset + sign(dq) magnitude(|dq|), to be subtracted from the drive torque.

        (...) [N m or N] for its velocity dq (...) [rad/s or m/s]. At exactly 0 friction has any value between the two
        `breakaway` levels; the offset is returned.
        """
        v = np.asarray(dq, dtype=float)
        moving = np.where(v > 0.0, self.positive.magnitude(np.abs(v)), -self.negative.magnitude(np.abs(v)))
        smooth = 0.0 if self.sigmoid is None else self.sigmoid.torque(v)
        return np.asarray(self.offset + np.where(v == 0.0, 0.0, moving) + smooth)

    @property
    def is_zero(self) -> bool:
        """Whether it is none at any speed."""
        smooth = 0.0 if self.sigmoid is None else self.sigmoid.level
        sides = (self.positive, self.negative)
        return self.offset == smooth == self.load == 0.0 and all(x.holding == x.viscous == 0.0 for x in sides)

    @property
    def breakaway(self) -> tuple[float, float]:
        """Limits of friction at rest (most negative, most positive) [N m or N]; beyond them the joint moves."""
        return self.offset - self.negative.holding, self.offset + self.positive.holding


FRICTIONLESS = JointFriction(Direction(0.0, 0.0), Direction(0.0, 0.0))
"""The model of a joint whose friction is unknown."""


def symmetric(coulomb: float, viscous: float) -> JointFriction:
    """The same Coulomb and viscous friction in both directions, as in a URDF.

    >>> symmetric(2.0, 0.5).torque(-1.0).item()
    -2.5
    """
    both = Direction(coulomb, viscous)
    return JointFriction(both, both)


def sigmoid_friction(models: Sequence[JointFriction | None]) -> Callable[[Array], Array] | None:
    """The sigmoids of the joints as one function (..., n) -> (..., n) [N m or N]; None where no joint has one."""
    given = [None if model is None else model.sigmoid for model in models]
    if all(one is None for one in given):
        return None
    level, slope, shift = np.array([(0.0, 1.0, 0.0) if x is None else (x.level, x.slope, x.shift) for x in given]).T
    at_rest = _logistic(slope * shift)
    return partial(_sigmoids, level, slope, shift, at_rest)


def _sigmoids(level: Array, slope: Array, shift: Array, at_rest: Array, dq: Array) -> Array:
    """`sigmoid_friction` at dq; parameters are (n,)."""
    return np.asarray(level * (_logistic(slope * (dq + shift)) - at_rest))


def friction_torque(models: tuple[JointFriction | None, ...], dq: ArrayLike, carried: ArrayLike | None = None) -> Array:
    """Friction torques tau_friction(dq) of an arm (..., n) at joint velocities (..., n); 0 where unknown.

    `carried` (..., n) is what bodies and rotors ask of the joints [N m or N], of which friction is a share beside the
    rest; without it that share is left out. Raises `ShapeError` for arrays that do not have one column per joint, or
    are not finite.

    >>> grows = JointFriction(Direction(1.0, 0.0), Direction(1.0, 0.0), load=0.1)
    >>> friction_torque((grows,), [[-0.5], [0.5]], [[20.0], [20.0]]).tolist()
    [[-3.0], [3.0]]
    """
    v = joint_array("dq", dq, len(models))
    out = np.stack([(m or FRICTIONLESS).torque(v[..., i]) for i, m in enumerate(models)], axis=-1)
    if carried is None:
        return out
    shares = np.array([(m or FRICTIONLESS).load for m in models])
    return np.asarray(out + shares * np.abs(joint_array("carried", carried, len(models))) * np.sign(v))


def smooth_friction(models: Sequence[JointFriction | None], width: float = 1e-3) -> Callable[[Array], Array]:
    """The function tau_friction(dq) with tanh(dq / width) in place of sign(dq), (..., n) -> (..., n) [N m or N].

    It cannot hold a joint at rest: under a load F below break-away the joint creeps at about width F/F_c.

    tau = offset + level(|dq|) tanh(dq / width) + viscous dq, level and viscous those of the direction of dq, and what
    a sigmoid adds. It is
    continuous, with a kink at 0 where the directions differ; at 0 it is the offset. Ungated, for loops. `models` has
    one entry per joint; `width` [rad/s or m/s] is the speed at which friction reaches 76 % of its level. Raises
    `OptionError` for a width that is not a number above 0.

    >>> friction = smooth_friction([symmetric(2.0, 0.5)], width=1e-3)
    >>> friction(np.array([0.0])).item(), friction(np.array([-1.0])).item()
    (0.0, -2.5)
    """
    if not (np.isfinite(width) and width > 0.0):
        raise OptionError("width", width, "a speed above 0")
    joints = [m or FRICTIONLESS for m in models]
    offset = np.array([m.offset for m in joints])
    both = [[m.positive for m in joints], [m.negative for m in joints]]
    coulomb, viscous = (
        np.array([[getattr(d, name) for d in side] for side in both]) for name in ("coulomb", "viscous")
    )
    drop = np.array([[d.holding - d.coulomb if d.stribeck_velocity else 0.0 for d in side] for side in both])
    scale = np.array([[d.stribeck_velocity or 1.0 for d in side] for side in both])
    stribeck = (drop, scale) if drop.any() else None
    return partial(_smooth_torque, width, offset, coulomb, viscous, stribeck, sigmoid_friction(models))


def _smooth_torque(
    width: float, offset: Array, coulomb: Array, viscous: Array, stribeck: tuple[Array, Array] | None,
    sigmoid: Callable[[Array], Array] | None, dq: Array,
) -> Array:  # fmt: skip
    """`smooth_friction` at dq; levels are (2, n), positive over negative."""
    forward = dq > 0.0
    level = np.where(forward, coulomb[0], coulomb[1])
    if stribeck is not None:
        drop, scale = stribeck
        x = dq / np.where(forward, scale[0], scale[1])
        level = level + np.where(forward, drop[0], drop[1]) * np.exp(-np.square(x))
    smooth = offset + level * np.tanh(dq / width) + np.where(forward, viscous[0], viscous[1]) * dq
    return np.asarray(smooth if sigmoid is None else smooth + sigmoid(dq))
