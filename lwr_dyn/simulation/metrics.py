"""Figures of merit of a run: errors joint by joint, error of the tip, torques and speeds against their limits.

The tip is placed by the joint positions alone: `RIGID` says so wherever one of its figures is shown.
"""

from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np

from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.model.shown import repr_html, short_repr
from lwr_dyn.simulation.stop_contacts import StopContacts, stop_contacts

MILLI = 1e3
RIGID = "rigid links and joints"
ELASTIC = "rigid links, elastic joints"
"""What every error of the tip is computed with. A real arm bends, in its joints first: a drive with elastic gears (the
LWR's) leaves an error at the tip that no figure here contains."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorFigures:
    """Of an error ref - actual over the samples, joint by joint (n,)."""

    mean: Array  # signed
    mean_abs: Array
    max: Array
    min: Array
    rms: Array

    @classmethod
    def of(cls, error: Array) -> Self:
        """Of errors (k, n), in their unit."""
        size = np.abs(error)
        rms = np.sqrt((error**2).mean(axis=0))
        figures = (error.mean(axis=0), size.mean(axis=0), error.max(axis=0), error.min(axis=0), rms)
        return cls(*(read_only(f) for f in figures))


@dataclass(frozen=True, slots=True, eq=False)
class Metrics:
    """Position errors in mrad (mm for a sliding joint), velocity errors in mrad/s, the tip's in mm.

    The errors of the tip are those of an arm with rigid links: what their bending adds is not in them, nor, where the
    joints were rigid, what elastic ones add. A use is a peak over its limit, NaN where the limit is unknown. Where a
    joint met its stop, the figures are not the controller's alone; `caveat` says both in words.
    """

    position_mrad: ErrorFigures
    velocity_mrad_s: ErrorFigures
    tip_max_mm: float
    tip_rms_mm: float
    peak_torque: Array  # largest |tau_applied| [N m]
    peak_command: Array  # largest |tau_command| [N m]
    torque_use: Array
    peak_speed: Array  # [rad/s]
    speed_use: Array
    limit_margin: Array  # least distance from the position limits [rad], negative beyond one
    saturated_s: Array  # time in which the command was beyond the torque limit [s]
    stops: StopContacts
    bodies: str = RIGID
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def within_limits(self) -> bool:
        """Whether the controller kept every known limit of torque, speed and position: no torque cut, no stop met."""
        return self._inside and not self.stops.met

    @property
    def _inside(self) -> bool:
        return not self._exceeded()

    def _exceeded(self) -> list[str]:
        """The limits that were not kept, in words: whose, and of what."""
        cut = (self.torque_use > 1.0) | (self.saturated_s > 0.0)  # NaN, an unknown limit, is not above 1
        beyond = {"position": ~(self.limit_margin >= 0.0), "speed": self.speed_use > 1.0, "torque": cut}
        found = {
            what: [j for j, bad in zip(self.stops.joints, each, strict=True) if bad] for what, each in beyond.items()
        }
        return [f"{what} of {', '.join(joints)}" for what, joints in found.items() if joints]

    @property
    def limits(self) -> str:
        """Whether the limits were kept, in words: what was not, and whose; the stops that joints ran into."""
        kept = "kept" if self._inside else f"NOT kept ({'; '.join(self._exceeded())})"
        return f"{kept}, but {self.stops.contacts()}" if self.stops.met else kept

    @property
    def caveat(self) -> str:
        """What the errors of the tip rest on, in words: `RIGID` or `ELASTIC`, and the stops that joints met."""
        return "; ".join([self.bodies, *([self.stops.sentence()] if self.stops.met else [])])

    def to_json(self) -> dict[str, Any]:
        """The figures as JSON values; None for NaN and infinity; "tip_caveat" is `caveat`, "at_stop_s" is by joint."""
        words = {"within_limits": self.within_limits, "limits": self.limits, "tip_caveat": self.caveat}
        stops = {"at_stop_s": self.stops.seconds.tolist(), "stop_impacts": list(self.stops.impacts)}
        return {**_json(self), **stops, **words}


def metrics(run: Run, arm: Arm) -> Metrics:
    """Figures of merit of a run by the limits and the kinematics of `arm`.

    Raises `ShapeError` for a run of an arm with another number of joints.
    """
    if run.n != arm.n:
        raise ShapeError("run", f"{run.n} joints", f"{arm.n} joints, as {arm.name}")
    command, effort = np.abs(run.tau_command), arm.effort
    steps = np.diff(run.t, append=run.t[-1])  # the last sample has no duration
    tip = MILLI * np.linalg.norm(_tip(arm, run.q_ref) - _tip(arm, run.q), axis=-1)
    peak_torque, peak_speed = np.abs(run.tau_applied).max(axis=0), np.abs(run.dq).max(axis=0)
    return Metrics(
        position_mrad=ErrorFigures.of(MILLI * (run.q_ref - run.q)),
        velocity_mrad_s=ErrorFigures.of(MILLI * (run.dq_ref - run.dq)),
        tip_max_mm=float(tip.max()),
        tip_rms_mm=float(np.sqrt((tip**2).mean())),
        peak_torque=read_only(peak_torque),
        peak_command=read_only(command.max(axis=0)),
        torque_use=_use(peak_torque, effort),
        peak_speed=read_only(peak_speed),
        speed_use=_use(peak_speed, arm.velocity),
        limit_margin=read_only(np.minimum(run.q - arm.lower, arm.upper - run.q).min(axis=0)),
        saturated_s=read_only(steps @ (command > effort)),
        stops=stop_contacts(run, arm),
        bodies=tip_model(run),
    )


def tip_model(run: Run) -> str:
    """`RIGID` or `ELASTIC`, as a run's joints were."""
    return RIGID if run.meta.get("elasticity") is None else ELASTIC


def _tip(arm: Arm, q: Array) -> Array:
    return flange_pose(arm.chain, q)[..., :3, 3]


def _use(peak: Array, limit: Array) -> Array:
    return read_only(np.where(np.isfinite(limit), peak / limit, np.nan))


def _json(value: Any) -> Any:
    if isinstance(value, Metrics | ErrorFigures):
        return {f.name: _json(getattr(value, f.name)) for f in fields(value) if f.name not in ("stops", "bodies")}
    if isinstance(value, np.ndarray):
        return [_json(float(x)) for x in value]
    return value if np.isfinite(value) else None
