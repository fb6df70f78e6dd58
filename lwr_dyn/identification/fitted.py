"""The values of a fit with their standard errors, and the arm with them: bodies, rotors and friction of its logs."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lwr_dyn.arms.papers.schema import LOAD, SIDES
from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.identification.bodies.consistent import ConsistentFit
from lwr_dyn.identification.log_digests import LogDigest, log_digests
from lwr_dyn.identification.motion.friction_rows import load_words
from lwr_dyn.identification.motion.motion_result import MotionIdentification, expected
from lwr_dyn.identification.regression.joints_alone import between_words, seen_alone
from lwr_dyn.model.arm import Arm, JointLimits, Source
from lwr_dyn.model.chain import Body, ChainLink, JointKind, Rotor
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.model.inertial_parameters import TENSOR
from lwr_dyn.model.spatial import steiner

READING = "fitted"
"""The name of the reading of a fitted arm."""
UNITS = {
    "armature": ("kg m^2", "kg"), "coulomb": ("N m", "N"), "static": ("N m", "N"), "offset": ("N m", "N"),
    "viscous": ("N m s/rad", "N s/m"), "stribeck_velocity": ("rad/s", "m/s"), "covered": ("rad/s", "m/s"),
}  # fmt: skip
"""Quantities of a joint, and their units where it turns and where it slides."""


class Fitted(NamedTuple):
    """Numbers [SI] and their standard errors, (n, ...) each."""

    value: Array
    sigma: Array


@dataclass(frozen=True, slots=True, eq=False)
class FittedValues:
    """What a fit says of an arm of n joints, SI; tensors about the origins of the links' frames, in their axes. Errors
    are NaN, written `unknown`, where no torque shows a number.

    `mass` (n,), `com` (n, 3), `inertia` (n, 3, 3), `armature` (n,); `friction`, one model a joint, with
    `friction_sigma`: quantity of a direction ("positive_coulomb", ..., "offset", "load") -> (n,), NaN where there is
    none; `covered` (n,): the largest speed that was seen [rad/s or m/s], 0 for a joint that did not move. `joints` is
    False where rotors and friction were fitted to motors with units of their own: those of the arm stay then, and these
    are not used. Of motors that turn several joints, seen at the joints, they are what each joint shows alone.
    """

    mass: Fitted
    com: Fitted
    inertia: Fitted
    armature: Fitted
    friction: tuple[JointFriction, ...]
    friction_sigma: dict[str, Array]
    covered: Array
    logs: tuple[LogDigest, ...]
    about: str
    """How they were fitted."""
    joints: bool = True
    contradicted: str = ""
    """By what the log contradicts the bodies; empty where it does not."""
    lacks: str = ""
    """What was fitted and no model has a place for; empty where there is nothing."""

    @property
    def where(self) -> str:
        """The source of the numbers, for a data file."""
        return f"fitted to {', '.join(Path(log.source).name for log in self.logs)}; digests in [document]"

    @property
    def bodies(self) -> tuple[tuple[str, Fitted, str], ...]:
        """Name, numbers and unit of what a link has."""
        return ("mass", self.mass, "kg"), ("com", self.com, "m"), ("inertia", self.inertia, "kg m^2")


def fitted_values(result: MotionIdentification) -> FittedValues:
    """The values of the consistent fit of an identification.

    com = m c / m has the variance (var(m c) - 2 c cov(m c, m) + c^2 var(m)) / m^2, to first order.

    Raises
    ------
    MissingDataError
        The arm has no masses, so there was no consistent fit.
    """
    columns = result.columns
    if result.consistent is None:
        raise MissingDataError(result.arm.name, "masses", "a fitted model")
    parameters, cov, shown = _of_joints(result, result.consistent)
    n, ten = result.arm.n, len(INERTIAL)
    pi, sigma = (x[: columns.bodies].reshape(n, ten) for x in (parameters, shown))
    com = pi[:, 1:4] / pi[:, :1]
    own = np.einsum("iaib->iab", cov[: columns.bodies, : columns.bodies].reshape(n, ten, n, ten))
    variance = np.diagonal(own, axis1=1, axis2=2)[:, 1:4] - 2.0 * com * own[:, 0, 1:4] + np.square(com) * own[:, 0, :1]
    com_sigma = np.sqrt(np.maximum(variance, 0.0)) / pi[:, :1] + 0.0 * sigma[:, 1:4]
    rotors = columns.rotor_indices
    covered = np.where(result.samples.used, np.abs(result.samples.dq), 0.0).max(axis=0)
    return FittedValues(
        Fitted(pi[:, 0], sigma[:, 0]), Fitted(com, com_sigma), Fitted(pi[:, TENSOR], sigma[:, TENSOR]),
        Fitted(parameters[rotors], shown[rotors]), columns.friction_of(parameters),
        _friction_sigma(result, cov), covered, tuple(log_digests(result.samples)), _about(result),
        columns.transmission is None or columns.transmission.seen_at_joints, result.contradiction, _between(result),
    )  # fmt: skip


def _between(result: MotionIdentification) -> str:
    fit, columns = result.consistent, result.columns
    assert fit is not None
    return between_words(columns.transmission, fit.parameters[columns.rotor_indices])


def _of_joints(result: MotionIdentification, fit: ConsistentFit) -> tuple[Array, Array, Array]:
    """Parameters (p,), covariance (p, p) and standard errors (p,); rotors and friction of joints (`seen_alone`)."""
    shown = np.array(result.shown_sigma, dtype=np.float64)
    alone = seen_alone(result.columns.names, result.columns.transmission)
    if alone is None:
        return fit.parameters, fit.covariance, shown
    cov = alone @ fit.covariance @ alone.T
    unknown = (alone != 0.0) @ np.isnan(shown)
    mixed = np.count_nonzero(alone, axis=1) > 1
    sigma = np.where(mixed, np.sqrt(np.maximum(np.diag(cov), 0.0)), shown)
    return alone @ fit.parameters, cov, np.where(unknown, np.nan, sigma)


def _friction_sigma(result: MotionIdentification, covariance: Array) -> dict[str, Array]:
    """Standard errors of the columns of a data file; NaN for a number that is not fitted."""
    columns, wanted = result.columns, {"offset": {"offset"}, LOAD: {LOAD}}
    for side, sign in zip(SIDES, "+-", strict=True):
        for name, sum_of in (("coulomb", ["coulomb"]), ("viscous", ["viscous"]), ("static", ["coulomb", "stribeck"])):
            wanted[f"{side}_{name}"] = {*sum_of, *(each + sign for each in sum_of)}
    out = {name: np.full(columns.n, np.nan) for name in wanted}
    for j, joint in enumerate(columns.joints):
        for name, parts in wanted.items():
            at = [columns.of_joint(j).start + k for k, each in enumerate(joint.names) if each in parts]
            if at:
                out[name][j] = np.sqrt(max(0.0, float(covariance[np.ix_(at, at)].sum())))
    return out


def _about(result: MotionIdentification) -> str:
    fit, rule = result.consistent, result.rule
    assert fit is not None
    map_, motors = result.columns.transmission, "; rotors and friction were fitted to the motors: not here"
    if map_ is None or map_.seen_at_joints:
        motors = f"; {left}" if (left := _between(result)) else ""
    known = f", known: {'; '.join(fit.constraints)}" if fit.constraints else ""
    terms = " with Stribeck terms" if rule.stribeck else ""
    if rule.gains is not None:
        terms += f", gains known to {rule.gains:.3g}"
    if rule.load_friction:
        terms += f"; {load_words(result.information)}"
    return (
        f"bodies near reading {result.arm.reading}, expected off it {expected(fit)}, {result.equations} "
        f"equations, {result.identified} of {result.base.count} base parameters identified, friction {rule.friction}"
        f"{terms}, positions through {rule.samples.cutoff} Hz, price {np.nanmax(fit.price.rms):.2g} N m (N) RMS at the "
        f"worst joint{known}{motors}; sigma: one standard error, unknown where the number is that of the table"
    )


def fitted_arm(arm: Arm, values: FittedValues) -> Arm:
    """The arm with the values; limits, gains and shapes stay, and where they were fitted to motors rotors and friction.

    `limits` hold friction that is the same both ways, as a URDF has it: the mean of the directions, no slope below 0.
    """
    links = tuple(_link(link, values, i) for i, link in enumerate(arm.chain.links))
    fitted = replace(
        arm, chain=replace(arm.chain, links=links), reading=READING, sources={**arm.sources, **_sources(arm, values)},
        errata=(), caveats=replace(arm.caveats, contradicted=values.contradicted),
    )  # fmt: skip
    if not values.joints:
        return fitted
    limits = tuple(_limits(old, model) for old, model in zip(arm.limits, values.friction, strict=True))
    friction = tuple(
        replace(model, covered=float(v) or None) for model, v in zip(values.friction, values.covered, strict=True)
    )
    return replace(fitted, limits=limits, friction=friction)


def _link(link: ChainLink, values: FittedValues, i: int) -> ChainLink:
    mass, com = float(values.mass.value[i]), values.com.value[i]
    rotor = rotor_of(link.rotor, values.armature.value[i]) if values.joints else link.rotor
    return replace(link, body=Body(mass, com, values.inertia.value[i] - steiner(mass, com)), rotor=rotor)


def rotor_of(table: Rotor | None, armature: float) -> Rotor:
    """A rotor of that inertia at the joint, with the gear ratio of the table's where one is known."""
    if table is None or table.reflected:
        return Rotor(1.0, float(armature), reflected=True)
    return Rotor(table.gear_ratio, float(armature) / table.gear_ratio**2)


def _limits(limits: JointLimits, model: JointFriction) -> JointLimits:
    viscous, coulomb = ((getattr(model.positive, x) + getattr(model.negative, x)) / 2 for x in ("viscous", "coulomb"))
    return replace(limits, viscous=max(0.0, viscous), coulomb=coulomb)


def _sources(arm: Arm, values: FittedValues) -> dict[str, tuple[Source, ...]]:
    out: dict[str, tuple[Source, ...]] = {}
    how = "; ".join(filter(None, ("least squares, bodies near the table", values.lacks)))

    def add(name: str, unit: str, value: object, sigma: object) -> None:
        out[name] = (Source("", values.where, "fitted", _plain(value), unit, how, sigma=_plain(sigma)),)

    for i, link in enumerate(arm.chain.links):
        for name, numbers, unit in values.bodies:
            add(f"{link.link}.{name}", unit, *(x[i] for x in numbers))
    for i, link in enumerate(arm.chain.links if values.joints else ()):
        for name in ("armature", "rotor_inertia"):
            add(f"{link.joint}.{name}", unit_of("armature", link.kind), *(x[i] for x in values.armature))
        for quantity in (f"{side}_{name}" for side in SIDES for name in ("coulomb", "viscous")):
            side, name = quantity.split("_")
            value, sigma = getattr(getattr(values.friction[i], side), name), values.friction_sigma[quantity][i]
            for place in (f"friction.{quantity}", *((name,) if side == SIDES[0] else ())):
                add(f"{link.joint}.{place}", unit_of(name, link.kind), value, sigma)
    _add_loads(arm, values, add)
    return out


def _add_loads(arm: Arm, values: FittedValues, add: Callable[[str, str, object, object], None]) -> None:
    """Shares of the load by which friction grows, where they were fitted."""
    if values.joints and any(model.load for model in values.friction):
        for joint, model, sigma in zip(arm.joint_names, values.friction, values.friction_sigma[LOAD], strict=True):
            add(f"{joint}.friction.{LOAD}", "1", model.load, sigma)


def unit_of(name: str, kind: JointKind) -> str:
    """The unit of a quantity of `UNITS`."""
    return UNITS[name][kind is not JointKind.REVOLUTE]


def _plain(value: Any) -> object:
    return tuple(map(_plain, value)) if np.ndim(value) else float(value)
