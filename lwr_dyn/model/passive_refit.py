"""The nearest passive friction, and its difference from the given one."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.model.passivity import SIDES, Side, SideCurve, certificate


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

    Parameters
    ----------
    models : sequence of JointFriction or None
    speed : float, optional
        [rad/s or m/s]; the speed `covered` of each joint if not given.

    Raises
    ------
    OptionError
        A speed that is not above 0, or none for a joint without `covered`.

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
