"""A function q(t) as a reference: its speeds and accelerations are found, or given as functions, and checked.

Before it is used, the function is tried every 5 ms or less: numbers of the right shape, inside the limits of the arm,
without jumps of position or speed; derivatives that are given are those of q.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from lwr_dyn.foundation.arrays import Array, fixed_array, real_array
from lwr_dyn.foundation.errors import OptionError, PathLimitError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Motion, short_repr
from lwr_dyn.trajectory.references.position_limits import largest_violation
from lwr_dyn.trajectory.references.time_derivatives import Function, TimeFunction, jump_of, time_function

SHORTEST, LONGEST = 1e-3, 1e5
"""[s] Range of durations."""
TRIED, FEWEST, MOST = 5e-3, 400, 20000
"""[s] Time between trials, and how many intervals there are at least and at most."""
JUMP = {"position": (2e-9, 1e-8), "speed": (5e-6, 1e-6)}
"""Quantity -> the reach [s] at which a jump differs from a fast change, and the least jump [rad or m, per s]."""
NEAR = 1e-6
"""[s] Half of the time over which the speed is taken that is searched for jumps."""
SAME, SURE = 1e-4, 10.0
"""Share of the largest value, and times the error of the difference, by which a given derivative may be off."""
MEASURED = 101
"""Times at which the error of the derivatives is measured."""


@dataclass(frozen=True, slots=True, eq=False)
class FunctionReference:
    """q(t) on 0 to `duration`, at rest before and after; `speed` and `acceleration` where they are given."""

    position: TimeFunction
    speed: TimeFunction | None
    acceleration: TimeFunction | None
    about: Mapping[str, Any]
    """Under "derivatives": how dq and ddq are found, and the largest error measured [rad/s, rad/s^2; m]."""
    name: ClassVar[str] = "FunctionReference"
    """In run files."""
    __repr__ = short_repr

    @property
    def duration(self) -> float:
        """[s]"""
        return self.position.duration

    def sample(self, t: Array) -> Motion:
        """The motion at times t (k,) [s]; the function is called several times for each.

        >>> from lwr_dyn import load, reference
        >>> move = reference(lambda t: [0.2 * t**3] * 7, load("lwr4plus"), duration=1.0)
        >>> move.sample(np.array([0.5])).ddq[0, :2].round(9).tolist()
        [0.6, 0.6]
        """
        times = np.atleast_1d(real_array("t", t))
        inside = np.clip(times, 0.0, self.duration)
        moving = (np.abs(times - inside) <= 1e-12 * self.duration)[:, None]
        rates = (np.where(moving, rate(inside), 0.0) for rate in (self.rate, self.second_rate))
        return Motion(times, self.position.values(inside), *rates)

    def rate(self, times: Array) -> Array:
        """dq (k, n) [rad/s or m/s] at times (k,) within the duration."""
        return self.position.rate(times) if self.speed is None else self.speed.values(times)

    def second_rate(self, times: Array) -> Array:
        """ddq (k, n) [rad/s^2 or m/s^2], as `rate`."""
        if self.acceleration is not None:
            return self.acceleration.values(times)
        return self.position.second_rate(times) if self.speed is None else self.speed.rate(times)


def function_reference(
    function: Function,
    arm: Arm,
    *,
    duration: float,
    dq: Function | None = None,
    ddq: Function | None = None,
    limits: bool = True,
) -> FunctionReference:
    """A reference from a function q(t) of the time [s] that gives (n,) [rad or m].

    Parameters
    ----------
    function : callable
        Where it takes complex numbers (NumPy's functions do, those of `math` do not), dq is exact and ddq is a
        difference of it (relative error about 1e-10); else both are differences (about 1e-9 and 1e-7 for motions of a
        few Hz). `about["derivatives"]` says which, and the error that was measured.
    arm : Arm
    duration : float
        [s]; the function is called from 0 to there.
    dq, ddq : callable, optional
        Its derivatives, functions of the time like it; dq alone is differentiated for ddq.
    limits : bool
        Whether positions and speeds must be inside the limits of the arm.

    Raises
    ------
    OptionError
        No functions, a duration outside 1 ms to 1e5 s, a function that fails; a jump of the position, or of the speed
        unless dq and ddq are given; dq or ddq that is not the derivative: says when, which joint and by how much.
    ShapeError
        A value that is not n finite numbers.
    PathLimitError
        Positions or speeds outside the limits.
    """
    given = {"q": function, "dq": dq, "ddq": ddq}
    for name, one in given.items():
        if one is not None and not callable(one):
            raise OptionError(f"reference {name}", repr(one), "a function of the time")
    end = float(fixed_array("duration", duration, ()))
    if not SHORTEST <= end <= LONGEST:
        raise OptionError("duration", f"{end:g}", f"{SHORTEST:g} to {LONGEST:g} s")
    times = np.linspace(0.0, end, int(np.clip(np.ceil(end / TRIED), FEWEST, MOST)) + 1)
    plain = TimeFunction(function, arm.n, end, "reference q(t)")
    q = plain.values(times)
    _check_jumps(arm, plain.value, times, "position", "a function without jumps")
    if dq is None or ddq is None:
        allowed = "a function without jumps of speed, or dq and ddq given as functions"
        _check_jumps(arm, lambda t: _speed(plain, t), times, "speed", allowed)
    some = times[:: max(1, len(times) // FEWEST)]
    position = time_function(function, arm.n, end, plain.name, some)
    speed = None if dq is None else time_function(dq, arm.n, end, "reference dq(t)", some)
    acceleration = None if ddq is None else TimeFunction(ddq, arm.n, end, "reference ddq(t)")
    move = FunctionReference(position, speed, acceleration, {})
    if speed is not None:
        _check_same(arm, times, "dq", speed, position.rate)
    if acceleration is not None:
        _check_same(arm, times, "ddq", acceleration, (position.second_rate if speed is None else speed.rate))
    if limits:
        _check_limits(arm, times, q, move.rate(times))
    about = {"task": "function", "function": _name(function), "derivatives": _found_by(move, times)}
    return FunctionReference(position, speed, acceleration, about)


def _name(function: Function) -> str:
    return str(getattr(function, "__qualname__", type(function).__qualname__))


def _found_by(move: FunctionReference, times: Array) -> dict[str, Any]:
    """How the derivatives are found, and the largest error that was measured."""
    places = times[:: max(1, len(times) // MEASURED)]
    exact, base = ("complex step", "difference of the complex step"), ("differences", "differences")
    way = dict(zip(("dq", "ddq"), exact if move.position.takes_complex else base, strict=True))
    error = {"dq": move.position.rate_error(places), "ddq": 0.0}
    if move.speed is not None:
        way["dq"], error["dq"] = "given", 0.0
        way["ddq"], error["ddq"] = exact[0] if move.speed.takes_complex else base[0], move.speed.rate_error(places)
    elif move.acceleration is None:
        error["ddq"] = move.position.rate_error(places, second=True)
    if move.acceleration is not None:
        way["ddq"], error["ddq"] = "given", 0.0
    return {name: {"by": way[name], "error": error[name]} for name in way}


def _speed(plain: TimeFunction, t: float) -> Array:
    a, b = max(t - NEAR, 0.0), min(t + NEAR, plain.duration)
    return (plain.value(b) - plain.value(a)) / (b - a)


def _check_jumps(arm: Arm, value: Callable[[float], Array], times: Array, what: str, allowed: str) -> None:
    reach, least = JUMP[what]
    found = jump_of(value, times, reach, least * max(1.0, float(times[-1])))
    if found is not None:
        joint, t, size = found
        unit = f"{_unit(arm, joint)}{'/s' if what == 'speed' else ''}"
        jumps = f"the {what} of {arm.joint_names[joint]} jumps by {size:.3g} {unit} at t = {round(t, 5):g} s"
        raise OptionError("reference q(t)", jumps, allowed)


def _check_same(arm: Arm, times: Array, name: str, given: TimeFunction, found: Callable[..., Array]) -> None:
    """Raise `OptionError` where a given derivative differs from the one found at two trials in a row."""
    own, near = given.values(times), found(times)
    error = np.abs(near - found(times, 2.0))
    off = np.abs(own - near) > SAME * (1e-3 + np.abs(near).max(axis=0)) + SURE * error
    wrong = np.argwhere(off[:-1] & off[1:])
    if wrong.size:
        k, j = (int(x) for x in wrong[0])
        values = f"{own[k, j]:.6g} at t = {times[k]:.6g} s, where {name[1:]} changes by {near[k, j]:.6g} a second"
        raise OptionError(f"reference {name}(t) of {arm.joint_names[j]}", values, f"the derivative of {name[1:]}")


def _check_limits(arm: Arm, times: Array, q: Array, dq: Array) -> None:
    outside = largest_violation(arm, q)
    if outside is not None:
        t = float(times[outside.row])
        raise PathLimitError(t, "reference q(t)", outside.fault, outside.allowed, outside.joint, outside.excess)
    share = np.abs(dq) / arm.velocity
    k, j = (int(x) for x in np.unravel_index(int(np.argmax(share)), share.shape))
    if share[k, j] > 1.0:
        name, unit = arm.joint_names[j], f"{_unit(arm, j)}/s"
        fault = f"{name} at {abs(dq[k, j]):.6g} {unit}, {share[k, j]:.3g} times its speed limit"
        allowed = f"up to {arm.velocity[j]:.6g} {unit}, or limits=False"
        raise PathLimitError(float(times[k]), "reference q(t)", fault, allowed, name, abs(dq[k, j]) - arm.velocity[j])


def _unit(arm: Arm, joint: int) -> str:
    return "rad" if arm.chain.links[joint].kind is JointKind.REVOLUTE else "m"
