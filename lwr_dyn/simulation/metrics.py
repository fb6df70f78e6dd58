"""Figures of merit of a run: errors joint by joint, error of the tip, torques and speeds against their limits.

The tip is placed by the joint positions alone: `RIGID` says so wherever one of its figures is shown. A stop takes part
in the motion, like a hand that holds the joint: the errors of a run that met one are not the controller's alone.
`StopContacts.sentence` is the one place that puts it into words, for text, JSON, pages and tables.
"""

from dataclasses import dataclass, fields
from itertools import zip_longest
from typing import Annotated, Any, Self, TypedDict

import numpy as np

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays, read_only
from lwr_dyn.foundation.document import Document, Note, Section
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Run, repr_html, short_repr


@dataclass(frozen=True, slots=True, eq=False)
class StopContacts:
    """Of each joint: `seconds` (n,) at its stop [s], and `impacts`, how often it ran into it."""

    joints: tuple[str, ...]
    seconds: Array
    impacts: tuple[int, ...]
    first_s: tuple[float | None, ...] = ()
    """When each ran into its stop first [s]."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "seconds")

    @property
    def met(self) -> bool:
        """Whether a joint met a stop at all."""
        return any(self.impacts) or bool((self.seconds > 0.0).any())

    def sentence(self) -> str:
        """Which joints were on their stops, and for how long in all; empty if none was.

        >>> StopContacts(("a", "b"), np.array([0.0, 0.93]), (0, 4)).sentence()
        'b on its stop for 0.93 s'
        """
        return ", ".join(
            f"{name} on its stop for {time:.2g} s" if time > 0.0 else f"{name} met its stop"
            for name, time, impacts in zip(self.joints, self.seconds, self.impacts, strict=True)
            if time > 0.0 or impacts
        )

    def contacts(self) -> str:
        """The same with the impacts.

        >>> StopContacts(("a", "b"), np.array([0.0, 0.93]), (0, 4), (None, 0.02)).contacts()
        'b ran into its stop 4 times (first at 0.02 s) and was on it for 0.93 s'
        """
        return ", ".join(
            f"{name} {' and '.join(_contact(time, impacts, first))}"
            for name, time, impacts, first in zip_longest(self.joints, self.seconds, self.impacts, self.first_s)
            if time > 0.0 or impacts
        )


def _contact(time: float, impacts: int, first: float | None) -> list[str]:
    often = {1: "once", 2: "twice"}.get(impacts, f"{impacts} times")
    when = "" if first is None else f" (first at {first:.3g} s)" if impacts > 1 else f" (at {first:.3g} s)"
    ran = [f"ran into its stop {often}{when}"] if impacts else []
    return ran + ([f"was on {'it' if impacts else 'its stop'} for {time:.2g} s"] if time > 0.0 else [])


def stop_contacts(run: Run, arm: Arm) -> StopContacts:
    """The stops that joints met in a run.

    The simulation counts the samples in which a stop holds a joint with a torque: a joint that stands at its limit by
    itself, or that friction alone holds there, does not lean on it. In a run file without that count, two samples at a
    limit of `arm`, to the last bit, one after the other, are time at the stop.
    """
    times = [[e.t for e in run.events if e.kind == "stop" and e.joint == j] for j in range(run.n)]
    first = tuple(t[0] if t else None for t in times)
    counted, at_limit = run.meta.get("at_stop_s"), (run.q == arm.lower) | (run.q == arm.upper)
    seconds = np.diff(run.t) @ (at_limit[:-1] & at_limit[1:]) if counted is None else counted
    return StopContacts(arm.joint_names, fixed_array("at_stop_s", seconds, (run.n,)), tuple(map(len, times)), first)


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


Joints = list[float]


class ErrorsRecord(TypedDict):
    """`ErrorFigures` in a record, one number a joint."""

    mean: Annotated[Joints, "ref - actual, signed."]
    mean_abs: Annotated[Joints, "Of the sizes."]
    max: Annotated[Joints, "Largest, signed."]
    min: Annotated[Joints, "Least, signed."]
    rms: Annotated[Joints, "Root of the mean square."]


class MetricsRecord(TypedDict):
    """`Metrics.to_json`."""

    position_mrad: Annotated[ErrorsRecord, "Errors of position, mrad (mm for a sliding joint), one number a joint."]
    velocity_mrad_s: Annotated[ErrorsRecord, "Errors of velocity, mrad/s."]
    tip_max_mm: Annotated[float, "Largest error of the tip, mm."]
    tip_rms_mm: Annotated[float, "RMS error of the tip, mm."]
    peak_torque: Annotated[Joints, "N m (N), one number a joint."]
    peak_command: Annotated[Joints, "Of what the controller asked for, N m (N)."]
    torque_use: Annotated[Joints, "Peak over limit; null where the limit is unknown."]
    peak_speed: Annotated[Joints, "rad/s (m/s)."]
    speed_use: Annotated[Joints, "Peak over limit; null where the limit is unknown."]
    limit_margin: Annotated[Joints, "Least distance from the position limits, rad (m); null without limits."]
    saturated_s: Annotated[Joints, "Seconds beyond the torque limit; null where it is unknown."]
    at_stop_s: Annotated[Joints, "Seconds on the stop."]
    stop_impacts: Annotated[list[int], "How often each joint ran into its stop."]
    within_limits: Annotated[
        bool | None, "Whether the controller kept all limits; null where none was broken and some are unknown."
    ]
    limits: Annotated[
        str, "The same in words: what was kept, what not, what is unknown, and the stops that joints met."
    ]
    tip_caveat: Annotated[str, "What the errors of the tip rest on."]


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
    saturated_s: Array  # time in which the command was beyond the torque limit [s], NaN where it is unknown
    stops: StopContacts
    units: tuple[str, ...]  # of the errors of each joint: "mrad", or "mm" if it slides
    bodies: str = RIGID
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def within_limits(self) -> bool | None:
        """Whether the controller kept every limit of position, speed and torque: no torque cut, no stop met.

        None where no known limit was broken and some limit is unknown: that is no "kept".
        """
        broken, unknown = self._judged()
        if self.stops.met or any(broken.values()):
            return False
        return None if any(unknown.values()) else True

    def _judged(self) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
        """Joints that broke a limit, and joints whose limit is unknown, by what is limited."""
        cut = (self.torque_use > 1.0) | (self.saturated_s > 0.0)  # NaN, an unknown limit, is not above 1
        broken = {"position": ~(self.limit_margin >= 0.0), "speed": self.speed_use > 1.0, "torque": cut}
        unknown = {
            "position": np.isposinf(self.limit_margin), "speed": np.isnan(self.speed_use),
            "torque": np.isnan(self.torque_use),
        }  # fmt: skip
        named = [
            {what: [j for j, yes in zip(self.stops.joints, each, strict=True) if yes] for what, each in found.items()}
            for found in (broken, unknown)
        ]
        return named[0], named[1]

    @property
    def limits(self) -> str:
        """Whether the limits were kept, in words: what was not, and whose; what is unknown; stops that joints met."""
        broken, unknown = self._judged()
        said: dict[str, list[str]] = {}
        for what in broken:
            said.setdefault(_verdict(broken[what], unknown[what], len(self.stops.joints)), []).append(what)
        groups = [f"{_listed(whats)} {verdict}" for verdict, whats in sorted(said.items())]  # NOT before kept
        words = "kept" if list(said) == ["kept"] else "; ".join(groups)
        return f"{words}, but {self.stops.contacts()}" if self.stops.met else words

    @property
    def caveat(self) -> str:
        """What the errors of the tip rest on, in words: `RIGID` or `ELASTIC`, and the stops that joints met."""
        return "; ".join([self.bodies, *([self.stops.sentence()] if self.stops.met else [])])

    def table(self, full: bool = False) -> Table:
        """RMS and largest errors, or with `full` all of them, and uses of the limits, one row a joint."""
        p, v = self.position_mrad, self.velocity_mrad_s
        errors = {"RMS": p.rms, "max": np.maximum(p.max, -p.min) + 0.0}  # no -0
        if full:
            errors = {"mean": p.mean, "mean|e|": p.mean_abs, "max": p.max, "min": p.min, "RMS": p.rms}
            errors |= {"mean|de|": v.mean_abs, "max de": v.max, "min de": v.min}
        uses = (self.peak_torque, self.torque_use, self.speed_use, self.saturated_s)
        headings = [Heading("joint"), Heading("error in"), *(Heading(name, format=".3g") for name in errors)]
        force = "N m" if "mm" not in self.units else "N" if "mrad" not in self.units else "N m, N"
        headings += [Heading(f"peak torque [{force}]", format=".4g"), *USES]
        return Table("", headings, list(zip(self.stops.joints, self.units, *errors.values(), *uses, strict=True)))

    def parts(self, full: bool = False) -> tuple[Table | Note, ...]:
        """Of a document: the table, the error of the tip, and whether limits were kept."""
        tip = f"largest {self.tip_max_mm:.6g} mm, RMS {self.tip_rms_mm:.6g} mm"
        said = (f"tip error ({self.caveat}): {tip}", f"limits of position, speed and torque: {self.limits}")
        return self.table(full), Note(said)

    @property
    def document(self) -> Document:
        """The figures for people."""
        return Document("Errors and uses of limits", "", [Section("", self.parts(), brief=True)])

    def to_json(self) -> dict[str, Any]:
        """The figures as JSON values; None for NaN and infinity; "tip_caveat" is `caveat`, "at_stop_s" is by joint."""
        said = {"at_stop_s": self.stops.seconds, "stop_impacts": list(self.stops.impacts), "tip_caveat": self.caveat}
        names = MetricsRecord.__annotations__
        return {name: _json(said[name] if name in said else getattr(self, name)) for name in names}


def _listed(words: list[str]) -> str:
    """
    >>> _listed(["position", "speed", "torque"])
    'position, speed and torque'
    """
    return " and ".join(part for part in (", ".join(words[:-1]), words[-1]) if part)


def _verdict(broken: list[str], unknown: list[str], joints: int) -> str:
    """Of one kind of limit: kept or not, and by whom; unknown of all joints or of some."""
    if broken:
        return f"NOT kept ({', '.join(broken)})"
    if len(unknown) == joints:
        return "unknown"
    return f"kept where known, unknown of {', '.join(unknown)}" if unknown else "kept"


def _share(use: float) -> str:
    """A use of a limit; a question mark where the limit is not known."""
    return "?" if np.isnan(use) else f"{use:.0%}"


def _seconds(time: float) -> str:
    """Time beyond a limit; a question mark where the limit is not known."""
    return "?" if np.isnan(time) else f"{time:.3g}"


USES = (
    Heading("of limit", format=_share), Heading("speed of limit", format=_share),
    Heading("saturated [s]", format=_seconds),
)  # fmt: skip
"""Columns of how much of the limits was used."""


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
        saturated_s=read_only(np.where(np.isfinite(effort), steps @ (command > effort), np.nan)),
        stops=stop_contacts(run, arm),
        units=tuple("mrad" if link.kind is JointKind.REVOLUTE else "mm" for link in arm.chain.links),
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
    if isinstance(value, ErrorFigures):
        return {f.name: _json(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, np.ndarray):
        return [_json(float(x)) for x in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
