"""The arm with fitted bodies, rotors and friction in place of its source's, each number with its source."""

from dataclasses import replace

import numpy as np

from lwr_dyn.identification.fitted.fitted_values import FittedValues
from lwr_dyn.model.arm import Arm, JointLimits, Source
from lwr_dyn.model.chain import Body, ChainLink, Rotor
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.friction import JointFriction
from lwr_dyn.model.spatial import steiner

READING = "fitted"
"""The name of the reading of a fitted arm."""
HOW = "least squares, bodies near the table"


def fitted_arm(arm: Arm, values: FittedValues) -> Arm:
    """The arm with the values; limits, gains and shapes stay, and where they were fitted to motors rotors and friction.

    `limits` hold friction that is the same both ways, as a URDF has it: the mean of the directions, no slope below 0.
    """
    links = tuple(_link(link, values, i) for i, link in enumerate(arm.chain.links))
    sources = {**arm.sources, **_sources(arm, values)}
    if not values.joints:
        return replace(arm, chain=replace(arm.chain, links=links), reading=READING, sources=sources, errata=())
    sources |= _joint_sources(arm, values)
    limits = tuple(_limits(old, model) for old, model in zip(arm.limits, values.friction, strict=True))
    return replace(
        arm, chain=replace(arm.chain, links=links), reading=READING, limits=limits, friction=_friction(values),
        sources=sources, errata=(),
    )  # fmt: skip


def _link(link: ChainLink, values: FittedValues, i: int) -> ChainLink:
    com, inertia = values.com[i], values.inertia[i] - steiner(float(values.mass[i]), values.com[i])
    rotor = rotor_of(link.rotor, values.armature[i]) if values.joints else link.rotor
    return replace(link, body=Body(float(values.mass[i]), com, inertia), rotor=rotor)


def rotor_of(table: Rotor | None, armature: float) -> Rotor:
    """A rotor of that inertia at the joint, with the gear ratio of the table's where one is known."""
    if table is None or table.reflected:
        return Rotor(1.0, float(armature), reflected=True)
    return Rotor(table.gear_ratio, float(armature) / table.gear_ratio**2)


def _friction(values: FittedValues) -> tuple[JointFriction, ...]:
    return tuple(
        replace(model, covered=float(v) if v > 0.0 else None)
        for model, v in zip(values.friction, values.covered, strict=True)
    )


def _limits(limits: JointLimits, model: JointFriction) -> JointLimits:
    viscous, coulomb = ((getattr(model.positive, x) + getattr(model.negative, x)) / 2 for x in ("viscous", "coulomb"))
    return replace(limits, viscous=max(0.0, viscous), coulomb=coulomb)


def _source(values: FittedValues, value: object, sigma: object, unit: str) -> tuple[Source, ...]:
    return (Source("", values.where, "fitted", _plain(value), unit, HOW, sigma=_plain(sigma)),)


def _sources(arm: Arm, values: FittedValues) -> dict[str, tuple[Source, ...]]:
    out: dict[str, tuple[Source, ...]] = {}
    for i, link in enumerate(arm.chain.links):
        out[f"{link.link}.mass"] = _source(values, values.mass[i], values.mass_sigma[i], "kg")
        out[f"{link.link}.com"] = _source(values, values.com[i], values.com_sigma[i], "m")
        out[f"{link.link}.inertia"] = _source(values, values.inertia[i], values.inertia_sigma[i], "kg m^2")
    return out


def _joint_sources(arm: Arm, values: FittedValues) -> dict[str, tuple[Source, ...]]:
    out: dict[str, tuple[Source, ...]] = {}
    for i, link in enumerate(arm.chain.links):
        turns = link.kind is JointKind.REVOLUTE
        force, slope = ("N m", "N m s/rad") if turns else ("N", "N s/m")
        rotor = _source(values, values.armature[i], values.armature_sigma[i], "kg m^2" if turns else "kg")
        out |= {f"{link.joint}.{name}": rotor for name in ("armature", "rotor_inertia")}
        for side, direction in (("positive", values.friction[i].positive), ("negative", values.friction[i].negative)):
            for name, unit in (("coulomb", force), ("viscous", slope)):
                sigma = values.friction_sigma[f"{side}_{name}"][i]
                out[f"{link.joint}.friction.{side}_{name}"] = _source(values, getattr(direction, name), sigma, unit)
        for name in ("coulomb", "viscous"):
            out[f"{link.joint}.{name}"] = out[f"{link.joint}.friction.positive_{name}"]
    return out


def _plain(value: object) -> object:
    listed = np.asarray(value).tolist()
    return _tuples(listed)


def _tuples(value: object) -> object:
    return tuple(_tuples(x) for x in value) if isinstance(value, list) else value
