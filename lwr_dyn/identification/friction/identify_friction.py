"""Friction of an arm from recordings of constant-velocity runs, as the WAM paper identifies it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lwr_dyn.foundation.errors import LogError, LwrDynError, OptionError
from lwr_dyn.identification.friction.cruise import DEFAULT_CRUISE, CruiseRule
from lwr_dyn.identification.friction.direction_fit import DirectionFit, Model, fit_direction
from lwr_dyn.identification.friction.friction_map import FrictionPoint, map_points, points_of
from lwr_dyn.identification.friction.torque_model import ModelTorque, Subtract
from lwr_dyn.identification.logs.column_map import NO_MAP, ColumnMap
from lwr_dyn.identification.logs.joint_log import JointLog, read_log
from lwr_dyn.identification.logs.repeated import repeated
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.model.shown import repr_html, short_repr
from lwr_dyn.pages.replay.figures import Curve, Figure, Panel

BEYOND = "fit, beyond the data"


@dataclass(frozen=True, slots=True)
class FitOptions:
    """How a friction map is fitted and what is taken out of the torques before."""

    model: Model = "viscous+coulomb"
    robust: bool = False
    equal_weights: bool = False
    rule: CruiseRule = DEFAULT_CRUISE


DEFAULT_FIT = FitOptions()


@dataclass(frozen=True, slots=True, eq=False)
class FrictionIdentification:
    """The map, a fit for each joint and direction that the logs determine, an error for each that they do not."""

    points: tuple[FrictionPoint, ...]
    fits: tuple[DirectionFit, ...]
    faults: tuple[LwrDynError, ...] = ()
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def joints(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints that have points."""
        return tuple(sorted({p.joint for p in self.points}))

    def fit(self, joint: int, sign: int) -> DirectionFit | None:
        """The fit of a joint (from 1) in direction +1 or -1, None where the logs do not determine it."""
        return next((f for f in self.fits if f.joint == joint and f.sign == sign), None)

    def friction(self) -> dict[int, JointFriction]:
        """Friction models of the joints fitted both ways; raises `OptionError` for levels no friction can have."""
        pairs = {joint: (self.fit(joint, 1), self.fit(joint, -1)) for joint in self.joints}
        return {
            j: JointFriction(a.direction(), b.direction(), covered=min(a.fastest, b.fastest))
            for j, (a, b) in pairs.items()
            if a and b
        }


def identify_friction(
    logs: Iterable[JointLog], arm: Arm | None = None, subtract: Subtract = "gravity", options: FitOptions = DEFAULT_FIT
) -> FrictionIdentification:
    """The friction map of all logs together and its fits.

    Parameters
    ----------
    logs : iterable of JointLog
    arm : Arm, optional
        Its model is taken out of the torques; without it the torques count as friction as they are.
    subtract : {"none", "gravity", "inertia", "all"}
        What the model takes out: g(q), B ddq + C dq, or both.
    options : FitOptions
        The friction model, the loss and the rule for cruises.

    Returns
    -------
    FrictionIdentification
        A log without a cruise, and a direction that cannot be fitted, are among its `faults`.

    Raises
    ------
    OptionError, MissingDataError
        Another model or word; an arm without inertias.
    """
    model = None if arm is None else ModelTorque(arm, subtract)
    points: list[FrictionPoint] = []
    faults: list[LwrDynError] = []
    for log in logs:
        try:
            points += map_points(log, model, options.rule)
        except LogError as fault:
            faults.append(fault)
    fits, misses = _fits(points, options, subtract in ("none", "gravity"))
    return FrictionIdentification(tuple(points), fits, (*faults, *misses))


def identify_friction_files(
    paths: Sequence[str | Path], units: Mapping[str, str] | None = None, arm: Arm | None = None,
    subtract: Subtract = "gravity", options: FitOptions = DEFAULT_FIT, columns: ColumnMap = NO_MAP,
) -> FrictionIdentification:  # fmt: skip
    """The same from files, one in memory at a time; a file that cannot be used is a fault, the others still count.

    Raises as `identify_friction`.
    """
    faults: list[LwrDynError] = []
    seen: dict[bytes, str] = {}

    def readable() -> Iterable[JointLog]:
        for path in paths:
            try:
                log = read_log(path, units, arm, columns)
            except LwrDynError as fault:
                faults.append(fault)
                continue
            repeat = repeated(log, seen)
            if repeat is None:
                yield log
            else:
                faults.append(repeat)

    result = identify_friction(readable(), arm, subtract, options)
    return FrictionIdentification(result.points, result.fits, (*faults, *result.faults))


def _fits(
    points: Sequence[FrictionPoint], options: FitOptions, inertia_left_in: bool
) -> tuple[tuple[DirectionFit, ...], list[LogError]]:
    fits: list[DirectionFit] = []
    misses: list[LogError] = []
    for joint in sorted({p.joint for p in points}):
        for sign, way in ((1, "positive"), (-1, "negative")):
            chosen = points_of(points, joint, sign)
            try:
                if not chosen:
                    raise _points_of_direction(points, joint, way)
                fits.append(
                    fit_direction(chosen, options.model, options.robust, options.equal_weights, inertia_left_in)
                )
            except LogError as fault:
                misses.append(fault)
    return tuple(fits), misses


def _points_of_direction(points: Sequence[FrictionPoint], joint: int, way: str) -> LogError:
    files = ", ".join(dict.fromkeys(p.source for p in points if p.joint == joint))
    found = f"no cruise in the {way} direction"
    return LogError(files, f"column q{joint}", found, "cruises at two or more speeds in either direction")


def friction_map_figure(identification: FrictionIdentification) -> Figure:
    """One panel a joint, as the WAM paper's Figure 6: measured points, fitted curves over the speeds they cover.

    Raises
    ------
    OptionError
        Nothing was measured.
    """
    if not identification.joints:
        raise OptionError("friction map", "without a point", "at least one cruise")
    panels = []
    for joint in identification.joints:
        points = [p for p in identification.points if p.joint == joint]
        speeds, torques = (np.array([getattr(p, name) for p in points]) for name in ("velocity", "torque"))
        curves = [Curve("mean of a cruise", torques, speeds, "points", colour=0)]
        for fit in (f for f in identification.fits if f.joint == joint):
            curves += [_fitted(fit, f"fit, {fit.model}", fit.slowest, fit.fastest)]
            curves += [_fitted(fit, BEYOND, 0.0, fit.slowest)]
        panels.append(Panel(f"joint {joint}", "friction", "N m", tuple(curves)))
    title = "Friction-velocity maps"
    return Figure("friction-maps", title, "", "velocity", "rad/s", tuple(panels), columns=2)


def _fitted(fit: DirectionFit, label: str, start: float, end: float) -> Curve:
    speed = np.linspace(start, end, 200)
    torque = fit.sign * fit.magnitude(speed)
    return Curve(label, torque, fit.sign * speed, dashed=label == BEYOND, colour=1)
