"""What the program has set when a motion is planned: its speeds, and how its end may be passed."""

from __future__ import annotations

from dataclasses import dataclass

from lwr_dyn.foundation.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class Speeds:
    """The speeds when a motion is planned: axes (n,) [rad/s, rad/s^2], path [m/s, m/s^2], orientation [rad/s ...]."""

    axis: Array
    axis_ramp: Array
    cp: float
    cp_ramp: float
    ori: float
    ori_ramp: float
    advance: int = 3
    """$ADVANCE: motions that are planned ahead."""


@dataclass(frozen=True, slots=True)
class Blend:
    """How a point may be passed: the keywords of the statement, and the distances when it is planned."""

    kinds: tuple[str, ...]
    cdis: float
    """[m]"""
    cptp: float
    """[%]"""
    cori: float
    """[rad]"""
    cvel: float
    """[%]"""


@dataclass(frozen=True, slots=True)
class Corner:
    """The shares of the motions before and after a point, at most a half, in which it may be passed."""

    before: float
    after: float


@dataclass(frozen=True, slots=True)
class ProfileBounds:
    """The bounds of a motion profile: speed and acceleration of its parameter [per s, per s^2]."""

    speed: float
    ramp: float
