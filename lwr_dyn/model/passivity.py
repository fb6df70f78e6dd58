"""Passivity of friction: the speeds at which it adds energy instead of dissipating it, and the nearest that never does.

Friction adds energy where tau_friction(dq) dq < 0. In one direction, with v = |dq| and a the Coulomb level plus
(positive) or minus (negative) the offset, that is where a + viscous v + (static - coulomb) exp(-(v / v_s)^2) < 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.friction import Direction, JointFriction, friction_torque

Side = Literal["positive", "negative"]
SIDES: tuple[Side, Side] = ("positive", "negative")
TIGHT = 1e-15
"""Tolerance of the roots, relative and absolute: the precision of floats."""
FADED = 30.0
"""Speed over Stribeck velocity at which the Stribeck part is zero in floats: exp(-30^2)."""


@dataclass(frozen=True, slots=True)
class SidePassivity:
    """Passivity of the friction of one joint (0-based) in one direction of motion."""

    joint: int
    side: Side
    from_speed: float | None
    """Friction adds energy at speeds above this [rad/s or m/s]; None if it is passive."""
    to_speed: float
    """... and below this [rad/s or m/s], may be infinite; the first such range if there are two."""
    least_slope: float
    """Least d tau_friction / d dq over all speeds [N m s/rad or N s/m]: its least share in a loop's damping."""
    covered: float | None
    """The speed up to which the friction was measured."""

    @property
    def passive(self) -> bool:
        """Whether it adds energy at no speed."""
        return self.from_speed is None

    def net_damping(self, Kd: float) -> float:
        """Kd + least slope [N m s/rad or N s/m]: below 0 a velocity gain Kd cannot keep slow motion stable."""
        return Kd + self.least_slope


@dataclass(frozen=True, slots=True)
class SideCurve:
    """Friction in one direction, offset included: a + b v + e exp(-(v / scale)^2), v = |dq| > 0."""

    a: float
    b: float
    e: float
    scale: float

    @classmethod
    def of(cls, model: JointFriction, side: Side) -> SideCurve:
        """The curve of one side of a joint."""
        direction: Direction = getattr(model, side)
        share = model.offset if side == "positive" else -model.offset
        fading = direction.holding - direction.coulomb if direction.stribeck_velocity else 0.0
        return cls(direction.coulomb + share, direction.viscous, fading, direction.stribeck_velocity or 1.0)

    def at(self, v: float) -> float:
        """Value at speed v [N m or N]."""
        x = v / self.scale
        return self.a + self.b * v + self.e * math.exp(-x * x)

    def slope(self, v: float) -> float:
        """Derivative at speed v [N m s/rad or N s/m]."""
        x = v / self.scale
        return self.b - 2.0 * self.e * x / self.scale * math.exp(-x * x)


def certificate(models: Sequence[JointFriction | None]) -> tuple[SidePassivity, ...]:
    """Both directions of every joint with known friction, joint by joint.

    >>> wam_4 = JointFriction(Direction(1.5414, -2.7045), Direction(0.7342, -1.0969), covered=0.4)
    >>> [round(side.from_speed, 3) for side in certificate([wam_4])]
    [0.57, 0.669]
    >>> round(certificate([wam_4])[0].net_damping(2.0), 4)
    -0.7045
    """
    out = []
    for i, model in ((i, m) for i, m in enumerate(models) if m is not None):
        for side in SIDES:
            curve = SideCurve.of(model, side)
            low, high = _negative_from_to(curve)
            least_slope = curve.slope(curve.scale / math.sqrt(2.0)) if curve.e > 0.0 else curve.b
            out.append(SidePassivity(i, side, low, high, least_slope, model.covered))
    return tuple(out)


def feeds_energy(models: Sequence[JointFriction | None], dq: ArrayLike) -> NDArray[np.bool_]:
    """Whether friction adds energy at dq (..., n) [rad/s or m/s], (..., n) bool."""
    v = np.asarray(dq, dtype=float)
    return np.asarray(friction_torque(tuple(models), v) * v < 0.0)


def _negative_from_to(c: SideCurve) -> tuple[float | None, float]:
    """The first range of speeds in which the curve is below zero."""
    start: float | None = 0.0 if c.at(0.0) < 0.0 else None
    for low, high in pairwise(_monotone_pieces(c)):
        before, after = c.at(low), c.at(high)
        if start is None and before >= 0.0 > after:
            start = float(brentq(c.at, low, high, xtol=TIGHT, rtol=TIGHT))
        elif start is not None and before < 0.0 <= after:
            return start, float(brentq(c.at, low, high, xtol=TIGHT, rtol=TIGHT))
    if start is None:  # beyond the pieces only the line is left
        root = -c.a / c.b if c.b < 0.0 else math.inf
        return (root, math.inf) if math.isfinite(root) else (None, math.inf)
    return start, -c.a / c.b if c.b > 0.0 else math.inf


def _monotone_pieces(c: SideCurve) -> list[float]:
    """Speeds between which the curve is monotone, up to where its Stribeck part is exactly zero.

    The slope is least at v_s / sqrt(2), where the Stribeck part falls steepest. Without a Stribeck part: no piece.
    """
    if c.e <= 0.0:
        return []
    steepest, faded = c.scale / math.sqrt(2.0), FADED * c.scale
    if c.b <= 0.0 or c.slope(steepest) >= 0.0:
        return [0.0, faded]
    return [0.0, *(float(brentq(c.slope, *ends)) for ends in ((0.0, steepest), (steepest, faded))), faded]


@dataclass(frozen=True, slots=True)
class FrictionChange:
    """The change of one direction of one joint (0-based)."""

    joint: int
    side: Side
    before: Direction
    after: Direction
    rms: float
    """Root mean square of the difference over speeds from 0 to `speed` [N m or N]."""
    speed: float


@dataclass(frozen=True, slots=True)
class Refit:
    """Passive friction, and its changes from the given friction; empty where that is passive."""

    models: tuple[JointFriction | None, ...]
    changes: tuple[FrictionChange, ...]


def passive_refit(models: Sequence[JointFriction | None], speed: float | None = None) -> Refit:
    """The nearest friction that adds energy at no speed; joints with passive friction are unchanged.

    Coulomb level (with the offset's share) and slope of each direction become at least 0, such that the mean square of
    the difference over speeds from 0 to `speed` is least. The Stribeck part stays: static friction keeps its distance
    from Coulomb, so a lower Coulomb level lowers break-away too.

    `speed` [rad/s or m/s] is that `covered` of each joint if not given. Raises `OptionError` for one that is not above
    0, or none for a joint without `covered`.

    >>> wam_4 = JointFriction(Direction(1.5414, -2.7045), Direction(0.7342, -1.0969), covered=0.4)
    >>> up, down = passive_refit([wam_4]).changes
    >>> round(up.after.coulomb, 4), up.after.viscous, round(up.rms, 3)
    (1.0005, 0.0, 0.312)
    """
    if speed is not None and not (math.isfinite(speed) and speed > 0.0):
        raise OptionError("speed", speed, "a number above 0, or none")
    out, changes = list(models), []
    active = sorted({side.joint for side in certificate(models) if not side.passive})
    for i in active:
        model = models[i]
        top = speed if speed is not None or model is None else model.covered
        if model is None or top is None:
            raise OptionError(
                "speed", f"not given, and joint {i + 1} does not say up to where it was measured", "a speed"
            )
        after = _passive(model, top)
        out[i] = after
        changes += _changes(i, model, after, top)
    return Refit(tuple(out), tuple(changes))


def _passive(model: JointFriction, top: float) -> JointFriction:
    (up, up_slope), (down, down_slope) = (_nearest(SideCurve.of(model, side), top) for side in SIDES)
    offset = min(max(model.offset, -down), up)
    return replace(
        model,
        positive=_with_line(model.positive, up - offset, up_slope),
        negative=_with_line(model.negative, down + offset, down_slope),
        offset=offset,
    )


def _nearest(c: SideCurve, top: float) -> tuple[float, float]:
    """Level and slope, both at least 0, with the least mean square difference from the curve over 0 to `top`."""
    if c.a >= 0.0 and c.b >= 0.0:
        return c.a, c.b
    flat = max(c.a + c.b * top / 2.0, 0.0), 0.0
    through_zero = 0.0, max(c.b + 1.5 * c.a / top, 0.0)
    return min((flat, through_zero), key=lambda pair: _rms(pair[0] - c.a, pair[1] - c.b, top))


def _rms(level: float, slope: float, top: float) -> float:
    """Root mean square of level + slope v over v from 0 to top."""
    return math.sqrt(max(level**2 + level * slope * top + (slope * top) ** 2 / 3.0, 0.0))


def _with_line(d: Direction, coulomb: float, viscous: float) -> Direction:
    static = None if d.static is None else coulomb + (d.static - d.coulomb)
    return replace(d, coulomb=coulomb, viscous=viscous, static=static)


def _changes(i: int, before: JointFriction, after: JointFriction, top: float) -> list[FrictionChange]:
    out = []
    for side in SIDES:
        old, new = SideCurve.of(before, side), SideCurve.of(after, side)
        if (old.a, old.b) != (new.a, new.b):
            rms = _rms(new.a - old.a, new.b - old.b, top)
            out.append(FrictionChange(i, side, getattr(before, side), getattr(after, side), rms, top))
    return out
