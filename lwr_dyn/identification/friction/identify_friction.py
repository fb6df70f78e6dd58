"""Friction of an arm from constant-velocity runs, as the WAM paper identifies it; as figure, text and record."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import LogError, LwrDynError, OptionError
from lwr_dyn.foundation.tables import aligned
from lwr_dyn.identification.friction.direction_fit import NAMES, DirectionFit, Model, fit_direction
from lwr_dyn.identification.friction.friction_map import (
    DEFAULT_CRUISE,
    CruiseRule,
    FrictionPoint,
    ModelTorque,
    Subtract,
    map_points,
    points_of,
)
from lwr_dyn.identification.logs.joint_log import JointLog, read_log, repeated
from lwr_dyn.identification.logs.log_columns import NO_MAP, ColumnMap
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.model.run import repr_html, short_repr
from lwr_dyn.pages.figures.figure import Curve, Figure, Panel

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


_TAKEN = {"none": "nothing", "gravity": "g", "inertia": "B ddq + C dq", "all": "B ddq + C dq + g"}
_UNITS = {"coulomb": "N m", "viscous": "N m s/rad", "static": "N m", "stribeck_velocity": "rad/s"}


def friction_record(
    result: FrictionIdentification, options: FitOptions, robot: str | None, subtract: str
) -> dict[str, Any]:
    """Fits, map and faults."""
    return {
        "robot": robot, "subtracted": subtract, "model": options.model, "robust": options.robust,
        "weights": "equal" if options.equal_weights else "samples", "rule": asdict(options.rule),
        "fits": [_fit_record(fit, result) for fit in result.fits],
        "map": [asdict(point) for point in result.points],
        "faults": [str(fault) for fault in result.faults],
    }  # fmt: skip


def _fit_record(fit: DirectionFit, result: FrictionIdentification) -> dict[str, Any]:
    e = fit.estimate
    parameters = {
        name: {
            "value": e.values[i], "standard_error": e.standard_errors[i], "three_sigma": e.half_widths[i],
            "unit": _UNITS[name], "bias_of_averaging": None if fit.bias is None else fit.bias[i],
        }
        for i, name in enumerate(fit.names)
    }  # fmt: skip
    return {
        "joint": fit.joint, "direction": "positive" if fit.sign > 0 else "negative", "parameters": parameters,
        "residual_rms": e.rms, "speeds": [fit.slowest, fit.fastest], "cruises": int(e.residuals.size), "dof": e.dof,
    }  # fmt: skip


def friction_text(result: FrictionIdentification, options: FitOptions, subtract: str) -> str:
    """One row a joint and direction, and what averaging does to it."""
    names = NAMES[options.model]
    head = ("joint", "way", *(f"{n} [{_UNITS[n]}]" for n in names), "RMS [N m]", "speeds [rad/s]", "cruises")
    files = len({p.source for p in result.points})
    loss = "Huber's loss" if options.robust else "least squares"
    lines = [f"{len(result.points)} cruises in {files} files, {loss}, taken out of the torques: {_TAKEN[subtract]}"]
    if result.fits:
        lines.append(aligned([_row(fit) for fit in result.fits], head))
        lines.append(
            "value +- standard error; magnitudes against the motion; an offset raises one way, lowers the other"
        )
    lines += _bias_lines(result, subtract)
    return "\n".join(lines)


def _row(fit: DirectionFit) -> tuple[str, ...]:
    e = fit.estimate
    cells = [with_error(v, s) for v, s in zip(e.values, e.standard_errors, strict=True)]
    speeds = f"{fit.slowest:.4g} to {fit.fastest:.4g}"
    return (str(fit.joint), "+" if fit.sign > 0 else "-", *cells, f"{e.rms:.3g}", speeds, str(e.residuals.size))


def with_error(value: float, error: float) -> str:
    """`value +- standard error`."""
    return f"{value:.5g}" + (" (no error: as many cruises as parameters)" if np.isnan(error) else f" +- {error:.2g}")


def _bias_lines(result: FrictionIdentification, subtract: str) -> list[str]:
    known = [p for p in result.points if p.inertia is not None]
    if not known:
        return []
    worst = max(known, key=lambda p: abs(p.inertia or 0.0))
    sentence = (
        f"the mean of B ddq + C dq over a cruise is at most {abs(worst.inertia or 0.0):.3g} N m (joint {worst.joint})"
    )
    if subtract in ("inertia", "all"):
        return [f"{sentence}; it is taken out"]
    biases = [
        (abs(float(b)), f"{name} of joint {fit.joint}{'+' if fit.sign > 0 else '-'}")
        for fit in result.fits
        if fit.bias is not None
        for b, name in zip(fit.bias, fit.names, strict=True)
    ]
    if biases:
        size, where = max(biases)
        sentence += f"; left in, it moves a parameter by at most {size:.3g} ({where})"
    return [f"{sentence}; --subtract all takes it out"]
