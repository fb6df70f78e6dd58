"""Friction of the simulated arm: set-valued with true stick, its smooth form, none, or a function of the caller.

What holds joints at rest is a boxed linear complementarity problem: the resisting force lies between bounds, and at a
bound the joint moves.

    low <= f <= high,   w = b - M f,   f < high => w <= 0,   f > low => w >= 0

With w the accelerations of joints at rest and f what resists them, this is dry friction at zero speed (Gauss's
principle of least constraint). A position stop has one infinite bound; an impact is the same problem with speeds as w.
M = J B^-1 J^T is positive definite, so there is one solution.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import FRICTIONLESS, Direction, JointFriction, sigmoid_friction, smooth_friction

SIGN = 1e-12
"""Share of the largest datum below which a sign counts as zero: two zeros must not switch each other for ever."""

Sides = NDArray[np.int_]
"""One of +1 (moves on, positive), -1 (moves on, negative) and 0 (at rest) a joint, (n,)."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxedLcpSolution:
    """The resisting force (m,) and which joints move: `sides` +1 with f = high, -1 with f = low, 0 where w = 0."""

    force: Array
    sides: Sides


def boxed_lcp(M: Array, b: Array, low: Array, high: Array, start: Sides | None = None) -> BoxedLcpSolution:
    """The solution of the problem above for a positive definite M, m >= 1, by least-index pivoting (Murty).

    Parameters
    ----------
    M : (m, m) array
    b : (m,) array
        w without any resistance.
    low, high : (m,) arrays
        Bounds, low <= high; they may be infinite.
    start : (m,) array, optional
        Sides to begin from. On the border between rest and motion, where both are solutions, it decides.

    References
    ----------
    Cottle, Pang, Stone, *The Linear Complementarity Problem*, section 4.4.

    >>> boxed_lcp(np.eye(2), np.array([3.0, 0.5]), -np.ones(2), np.ones(2)).force
    array([1. , 0.5])
    """
    slack_w = SIGN * float(np.abs(b).max())
    slack_f = slack_w / float(M.diagonal().max())
    sides = np.zeros(b.size, dtype=int) if start is None else start.copy()
    f = np.zeros(b.size)
    for _ in range(3 ** (b.size + 1)):
        moving, still = sides != 0, sides == 0
        f[moving] = np.where(sides > 0, high, low)[moving]
        f[still] = np.linalg.solve(M[np.ix_(still, still)], b[still] - M[np.ix_(still, moving)] @ f[moving])
        above, below = still & (f > high + slack_f), still & (f < low - slack_f)
        wrong = above | below | (moving & (sides * (b - M @ f) < -slack_w))
        if not wrong.any():
            break
        first = int(np.argmax(wrong))
        sides[first] = int(above[first]) - int(below[first])
    return BoxedLcpSolution(np.clip(f, low, high), sides)


FORMS = ("set-valued", "smooth", "none")

FrictionTorque = Callable[[Array], Array]
"""tau_friction(dq), (n,) -> (n,) [N m], smooth in dq; it opposes the motion: B ddq + C dq + g = tau - tau_friction."""

FrictionOption = str | Sequence[JointFriction | None] | FrictionTorque | None
"""See `simulate`; None is the default, "set-valued"."""

Mask = NDArray[np.bool_]
"""One yes or no a joint, (n,)."""

SMOOTH_SPEED = 1e-3
"""[rad/s or m/s] of the smooth form: tanh(dq / SMOOTH_SPEED) in place of the sign."""

RULE = (
    "a joint at rest stays at rest if its static level holds it; those that it cannot hold resist with Coulomb's level "
    "only, and what remains at rest is judged again"
)


@dataclass(frozen=True, slots=True, eq=False)
class ArmFriction:
    """Friction of n joints; arrays (2, n) hold the positive and the negative direction [N m, N m s/rad].

    `lowest`, `highest` (n,) bound what friction can hold at rest; `lowest_slip`, `highest_slip` (n,) are its values at
    vanishing speed, which are smaller where static friction falls to Coulomb's at the first motion.
    """

    form: str  # one of `FORMS`, or "viscous", "sigmoid" or "given" for a smooth function of the speeds
    smooth: FrictionTorque | None  # the torque of the smooth forms, in place of all arrays below
    coulomb: Array
    viscous: Array
    stribeck_drop: Array  # (static - coulomb) where it falls with speed, else 0 [N m]
    sharpness: Array  # 1 / stribeck_velocity^2, or 0
    offset: Array  # (n,)
    lowest: Array
    highest: Array
    lowest_slip: Array
    highest_slip: Array
    slope: Array  # steepest slope of the torque over the speed, (n,) [N m s/rad]; 0 where it is not known
    sigmoid: FrictionTorque | None = field(default=None, kw_only=True)  # added to the set-valued torque

    @classmethod
    def of(cls, joints: Sequence[JointFriction | None]) -> Self:
        """Set-valued, from the friction of each joint; None has none."""
        each = [joint or FRICTIONLESS for joint in joints]
        table = np.array([[_numbers(joint.positive) for joint in each], [_numbers(joint.negative) for joint in each]])
        coulomb, viscous, drop, sharpness, hold = np.moveaxis(table, -1, 0)
        offset = np.array([joint.offset for joint in each])
        bounds = (offset - hold[1], offset + hold[0], offset - (coulomb + drop)[1], offset + (coulomb + drop)[0])
        slope = np.maximum(viscous.max(axis=0), 0.0) + _steepest(each)
        arrays = map(read_only, (coulomb, viscous, drop, sharpness, offset, *bounds, slope))
        return cls(FORMS[0], None, *arrays, sigmoid=sigmoid_friction(joints))

    @classmethod
    def function(cls, form: str, n: int, torque: FrictionTorque | None, slope: Array | None = None) -> Self:
        """A smooth function of the speeds of n joints; None is no friction."""
        pair, none = read_only(np.zeros((2, n))), read_only(np.zeros(n))
        steepest = none if slope is None else read_only(slope)
        return cls(form, torque, pair, pair, pair, pair, none, none, none, none, none, steepest)

    @property
    def directional(self) -> Mask:
        """Joints that can stick, or whose friction depends on the direction of the motion, (n,)."""
        return np.asarray((self.highest > self.lowest) | (self.viscous[0] != self.viscous[1]))

    def torque(self, sides: Sides, at_rest: Mask) -> FrictionTorque | None:
        """tau_friction(dq) of joints that move to these sides (n,), 0 of those at rest; None without friction.

        It is smooth through dq = 0, so that a trial step may pass it.
        """
        if self.form != FORMS[0]:
            return self.smooth
        way = np.where(sides < 0, 1, 0)

        def of_moving(table: Array) -> Array:
            return np.where(at_rest, 0.0, np.take_along_axis(table, way[None], axis=0)[0])

        level = sides * of_moving(self.coulomb) + np.where(at_rest, 0.0, self.offset)
        slope, drop, fall = of_moving(self.viscous), sides * of_moving(self.stribeck_drop), -of_moving(self.sharpness)
        if (smooth := self.sigmoid) is not None:
            return lambda dq: level + slope * dq + drop * np.exp(fall * dq * dq) + np.where(at_rest, 0.0, smooth(dq))
        if not drop.any():
            return lambda dq: level + slope * dq
        return lambda dq: level + slope * dq + drop * np.exp(fall * dq * dq)

    def record(self) -> dict[str, Any]:
        """The friction as JSON values."""
        if self.form == "smooth":
            return {"form": self.form, "smooth_speed": SMOOTH_SPEED}
        if self.form != FORMS[0]:
            return {"form": self.form}
        levels = {name: getattr(self, name).tolist() for name in ("coulomb", "viscous", "lowest", "highest")}
        return {"form": self.form, "rule": RULE, **levels}


def chosen_friction(arm: Arm, option: FrictionOption = None) -> ArmFriction:
    """The friction that an option of `simulate` names.

    Raises `OptionError`: a form of another name, friction given with a share of the load, which runs do not have (that
    of the arm itself is left out, and `Arm.caveat` says so); `ShapeError`: another number of joints.
    """
    if callable(option):
        return ArmFriction.function("given", arm.n, option)
    if isinstance(option, str) and option not in FORMS:
        raise OptionError("friction", repr(option), f"{', '.join(FORMS)}, one JointFriction a joint, or a function")
    own = option is None or isinstance(option, str)
    models = arm.friction_models() if option is None or isinstance(option, str) else _given(tuple(option), arm.n)
    if option == "none" or (own and all(model is None for model in models)):
        return ArmFriction.function("none", arm.n, None)
    set_valued = ArmFriction.of(models)
    if option == "smooth":
        jump = (set_valued.coulomb + set_valued.stribeck_drop).max(axis=0)
        slope = set_valued.viscous.max(axis=0) + jump / SMOOTH_SPEED + _steepest(models)
        return ArmFriction.function("smooth", arm.n, smooth_friction(models, SMOOTH_SPEED), slope)
    if not (set_valued.directional.any() or set_valued.offset.any()):
        coefficients, sigmoid = set_valued.viscous[0], set_valued.sigmoid
        if sigmoid is not None:
            return ArmFriction.function("sigmoid", arm.n, lambda dq: coefficients * dq + sigmoid(dq), set_valued.slope)
        return ArmFriction.function("viscous", arm.n, lambda dq: coefficients * dq, set_valued.slope)
    return set_valued


def _given(models: tuple[JointFriction | None, ...], n: int) -> tuple[JointFriction | None, ...]:
    if len(models) != n:
        raise ShapeError("friction", f"{len(models)} joints", f"{n}, one a joint, None where there is none")
    for j, model in enumerate(models, 1):
        if model is not None and model.load:
            found, allowed = f"{model.load:.2g} of the load", "none of the load: no run has it"
            raise OptionError(f"friction of joint {j}", found, allowed)
    return models


def braking_rate(B: Array, slope: Array) -> Array:
    """Fastest rates at which friction brakes [1/s], (...,): the largest eigenvalue of B^-1 diag(slope).

    Parameters
    ----------
    B : (..., n, n) array
        Mass matrices.
    slope : (..., n) array
        Of the friction torque over the speed, 0 or more [N m s/rad].
    """
    brakes = np.linalg.solve(B, slope[..., None, :] * np.eye(slope.shape[-1]))
    return np.asarray(np.linalg.eigvals(brakes).real.max(axis=-1))


def _steepest(joints: Sequence[JointFriction | None]) -> Array:
    """Of the sigmoids (n,), 0 without."""
    given = (None if joint is None else joint.sigmoid for joint in joints)
    return np.array([0.0 if one is None else one.steepest for one in given])


def _numbers(d: Direction) -> tuple[float, ...]:
    """Coulomb, viscous, Stribeck drop, sharpness, and what holds at rest."""
    if d.stribeck_velocity is None:
        return d.coulomb, d.viscous, 0.0, 0.0, d.holding
    return d.coulomb, d.viscous, d.holding - d.coulomb, d.stribeck_velocity**-2, d.holding
