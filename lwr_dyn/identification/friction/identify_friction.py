"""Friction of an arm from constant-velocity runs, as the WAM paper identifies it; figure and document."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Literal, TypedDict

import numpy as np

from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import LogError, LwrDynError, OptionError
from lwr_dyn.foundation.tables import Heading, Table, with_error
from lwr_dyn.identification.friction import friction_map
from lwr_dyn.identification.friction.direction_fit import NAMES, DirectionFit, Model, fit_direction
from lwr_dyn.identification.friction.friction_map import CruiseRule, FrictionPoint, Subtract
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
    rule: CruiseRule = friction_map.DEFAULT_CRUISE


DEFAULT_FIT = FitOptions()


@dataclass(frozen=True, slots=True, eq=False)
class FrictionIdentification:
    """The map, a fit for each joint and direction that the logs determine, an error for each that they do not."""

    points: tuple[FrictionPoint, ...]
    fits: tuple[DirectionFit, ...]
    faults: tuple[LwrDynError, ...] = ()
    options: FitOptions = DEFAULT_FIT
    subtracted: Subtract = "none"
    """What the arm's model took out of the torques."""
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def document(self) -> Document:
        """The fits for people and programs."""
        return friction_document(self)

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
    model = None if arm is None else friction_map.ModelTorque(arm, subtract)
    points: list[FrictionPoint] = []
    faults: list[LwrDynError] = []
    for log in logs:
        try:
            points += friction_map.map_points(log, model, options.rule)
        except LogError as fault:
            faults.append(fault)
    fits, misses = _fits(points, options, subtract in ("none", "gravity"))
    return FrictionIdentification(tuple(points), fits, (*faults, *misses), options, "none" if arm is None else subtract)


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
            if (repeat := repeated(log, seen)) is None:
                yield log
            else:
                faults.append(repeat)

    result = identify_friction(readable(), arm, subtract, options)
    return replace(result, faults=(*faults, *result.faults))


def _fits(
    points: Sequence[FrictionPoint], options: FitOptions, inertia_left_in: bool
) -> tuple[tuple[DirectionFit, ...], list[LogError]]:
    fits: list[DirectionFit] = []
    misses: list[LogError] = []
    for joint in sorted({p.joint for p in points}):
        for sign, way in ((1, "positive"), (-1, "negative")):
            chosen = friction_map.points_of(points, joint, sign)
            try:
                if not chosen:
                    files = ", ".join(dict.fromkeys(p.source for p in points if p.joint == joint))
                    needed = "cruises at two or more speeds in either direction"
                    raise LogError(files, f"column q{joint}", f"no cruise in the {way} direction", needed)
                given = options.model, options.robust, options.equal_weights
                fits.append(fit_direction(chosen, *given, inertia_left_in))
            except LogError as fault:
                misses.append(fault)
    return tuple(fits), misses


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
        points = [(p.velocity, p.torque) for p in identification.points if p.joint == joint]
        speeds, torques = np.array(points).T
        curves = [Curve("mean of a cruise", torques, speeds, "points", colour=0)]
        for fit in (f for f in identification.fits if f.joint == joint):
            curves += [_fitted(fit, f"fit, {fit.model}", fit.slowest, fit.fastest)]
            curves += [_fitted(fit, BEYOND, 0.0, fit.slowest)]
        panels.append(Panel(f"joint {joint}", "friction", "N m", tuple(curves)))
    return Figure("friction-maps", "Friction-velocity maps", "", "velocity", "rad/s", tuple(panels), columns=2)


def _fitted(fit: DirectionFit, label: str, start: float, end: float) -> Curve:
    speed = np.linspace(start, end, 200)
    torque = fit.sign * fit.magnitude(speed)
    return Curve(label, torque, fit.sign * speed, dashed=label == BEYOND, colour=1)


_TAKEN = {"none": "nothing", "gravity": "g", "inertia": "B ddq + C dq", "all": "B ddq + C dq + g"}
_UNITS = {"coulomb": "N m", "viscous": "N m s/rad", "static": "N m", "stribeck_velocity": "rad/s"}


class FittedRecord(TypedDict):
    """A parameter of a fit: coulomb, viscous, static, stribeck_velocity."""

    value: Annotated[float, "Against the motion."]
    standard_error: Annotated[float, "Null where there are as many cruises as parameters."]
    three_sigma: Annotated[float, "Half width of the interval of 99.73 %, by Student's t: what the text shows."]
    unit: Annotated[str, "Of the value."]
    bias_of_averaging: Annotated[
        float | None, "What the mean of B ddq + C dq puts on it where that is left in; null without a model."
    ]


def friction_document(result: FrictionIdentification, robot: str | None = None) -> Document:
    """The fits; `robot` is the name of the one whose model was taken out."""
    options, points = result.options, result.points
    files, loss = len({p.source for p in points}), "Huber's loss" if options.robust else "least squares"
    verdict = f"{len(points)} cruises in {files} files, {loss}, taken out of the torques: {_TAKEN[result.subtracted]}"
    facts = [
        Fact("robot", robot, "Name of the robot.", kind=str | None),
        Fact("subtracted", result.subtracted, "What its model took out: g, B ddq + C dq, or both.", kind=Subtract),
        Fact("model", options.model, "What is fitted.", kind=Model),
        Fact("robust", options.robust, "Whether the loss is Huber's."),
        Fact("weights", "equal" if options.equal_weights else "samples", "What a cruise counts by.",
             kind=Literal["equal", "samples"]),
        Fact("rule", asdict(options.rule), "What counts as a cruise.", kind=CruiseRule),
    ]  # fmt: skip
    bias, exact = _bias(result), any(fit.estimate.dof == 0 for fit in result.fits)
    fits = Section("", [
        _table(result),
        Note("no error: as many cruises as parameters", exact),
        Note(bias, bool(bias)),
        Fact("map", [asdict(point) for point in points], "The points of the friction-velocity map.",
             kind=list[FrictionPoint]),
        Note([str(fault) for fault in result.faults], key="faults", says="What could not be read or fitted, and why.",
             page=True),
    ], brief=True)  # fmt: skip
    return Document("Friction from cruises", verdict, [fits], "lwr-dyn identify friction", facts=facts, caveats=())


def _table(result: FrictionIdentification) -> Table:
    """One row a joint and direction."""
    names = NAMES[result.options.model]
    columns = (
        Heading("joint", says="From 1."),
        Heading("way", "", lambda way: "+" if way == "positive" else "-", "direction", "positive or negative."),
        *(Heading(name, _UNITS[name], key=None) for name in names),
        Heading(key="parameters", kind=dict[str, FittedRecord], says="Name -> value; coulomb, viscous, ..."),
        Heading("RMS", "N m", ".3g", "residual_rms", "Of what is left of the cruises' torques."),
        Heading("speeds", "rad/s", lambda ends: "{:.4g} to {:.4g}".format(*ends), "speeds", "Slowest and fastest."),
        Heading("cruises", key="cruises", says="How many were fitted."),
        Heading(key="dof", says="Cruises less parameters."),
    )  # fmt: skip
    rows = []
    for fit in result.fits:
        e = fit.estimate
        shown = [with_error(v, s) for v, s in zip(e.values, e.half_widths, strict=True)]
        rows.append((fit.joint, "positive" if fit.sign > 0 else "negative", *shown, _parameters(fit), e.rms,
                     [fit.slowest, fit.fastest], int(e.residuals.size), e.dof))  # fmt: skip
    note = (
        "value +- half of the interval of 99.73 % (Student's t of cruises less parameters); magnitudes against the "
        "motion; an offset raises one way, lowers the other"
    )
    return Table("", columns, rows, note, "fits", "One for each joint and direction.")


def _parameters(fit: DirectionFit) -> dict[str, FittedRecord]:
    e = fit.estimate
    return {
        name: {
            "value": e.values[i], "standard_error": e.standard_errors[i], "three_sigma": e.half_widths[i],
            "unit": _UNITS[name], "bias_of_averaging": None if fit.bias is None else fit.bias[i],
        }
        for i, name in enumerate(fit.names)
    }  # fmt: skip


def _bias(result: FrictionIdentification) -> str:
    """What averaging a cruise does to its torque; "" without a model."""
    known = [(abs(p.inertia), p.joint) for p in result.points if p.inertia is not None]
    if not known:
        return ""
    largest, joint = max(known, key=lambda one: one[0])
    said = f"the mean of B ddq + C dq over a cruise is at most {largest:.3g} N m (joint {joint})"
    if result.subtracted in ("inertia", "all"):
        return f"{said}; it is taken out"
    biases = [
        (abs(float(b)), f"{name} of joint {fit.joint}{'+' if fit.sign > 0 else '-'}")
        for fit in result.fits
        if fit.bias is not None
        for b, name in zip(fit.bias, fit.names, strict=True)
    ]
    if biases:
        said += "; left in, it moves a parameter by at most {:.3g} ({})".format(*max(biases))
    return f"{said}; --subtract all takes it out"
