"""The engines, what the model of each computes, and the features of a URDF that an engine may drop or misread.

Each feature is a change that takes it out of a copy of the file without meshes and mimic tags, so that what an engine
refuses does not stand in the way; shapes are a feature of their own.
"""

import copy
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol
from xml.etree import ElementTree

from lwr_dyn.foundation.arrays import Array, number_of
from lwr_dyn.foundation.registry import Registry, Row

EXACT = 1e-12
"""Relative tolerance of an engine that computes in double precision throughout."""
HELD = ("lower", "upper", "velocity", "effort", "viscous", "coulomb")
"""Numbers of a joint that an engine may keep beside its dynamics; (n,) each, infinite where it knows no limit."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmInFile:
    """The part of a file that is an arm: its joints from the base outward, what is held, the last link, gravity."""

    joints: tuple[str, ...]
    tip: str
    gravity: tuple[float, ...]
    held: Mapping[str, float] = field(default_factory=dict)
    """Other joints -> where they are held [rad or m]; those not named are at 0."""


class KinematicModel(Protocol):
    """A model file as a reader without dynamics has it, base fixed; q (n,) of the scope's joints in SI."""

    mass: float
    """Sum of the masses of all links that the engine knows [kg]; those it fixes to the ground may be left out."""

    def flange(self, q: Array) -> Array:
        """Pose of the tip in the root (4, 4)."""

    def held(self) -> dict[str, Array]:
        """Those of `HELD` that the engine has, (n,) each."""

    def links(self) -> list[str]:
        """Names of the links that it still knows."""


class LoadedModel(KinematicModel, Protocol):
    """A model file as an engine reads it; q, dq, ddq (n,)."""

    def mass_matrix(self, q: Array) -> Array:
        """B (n, n)."""

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """C dq (n,)."""

    def gravity_torque(self, q: Array) -> Array:
        """g (n,), the torque that holds the arm."""

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """What the engine's own motion needs (n,): B ddq + C dq + g with rotors and friction, if it has them."""


Load = Callable[[Path, ArmInFile, Mapping[str, Any]], "LoadedModel | KinematicModel"]
"""File, scope, options of the engine -> model."""


def _row(target: str, pip: str, package: str, extra: str = "", **facts: Any) -> Row:
    return Row(f"lwr_dyn.checks.engines.{target}", f"pip install {pip}", extra, {"package": package, **facts})


ENGINES: Registry[Load] = Registry(
    "parity_engine",
    {
        "pinocchio": _row("pinocchio_loader:PinocchioFile", "pin", "pinocchio"),
        "mujoco": _row("loaders:MujocoFile", "mujoco", "mujoco", "parity"),
        "drake": _row("loaders:DrakeFile", "drake", "pydrake", "parity"),
        # B, C dq: tensors are turned to principal axes by rotations that stop at 1e-6 of their size; poses are
        # single precision; the torque of its motion is a difference quotient of one step
        "pybullet": _row("loaders:BulletFile", "pybullet", "pybullet", "parity", inertia=1e-8, pose=1e-6, torque=1e-4),
        "yourdfpy": _row("loaders:YourdfpyFile", "yourdfpy", "yourdfpy", kinematics=True),
    },
)
"""Loaders by engine; `about` is how to install it. Facts: the Python package; tolerances (relative; m) other than
`EXACT`; `kinematics` for a reader without dynamics."""


def is_installed(engine: str) -> bool:
    """Whether the engine's own package is there."""
    return find_spec(ENGINES[engine].facts["package"]) is not None


def tolerance(engine: str, of: str) -> float:
    """The tolerance of an engine for "inertia", "torque" (relative) or "pose" [m]."""
    return float(ENGINES[engine].facts.get(of, EXACT))


Tree = ElementTree.Element
_DRAKE = ("https://drake.mit.edu/", "http://drake.mit.edu", "https://drake.mit.edu", "http://drake.mit.edu/")
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@dataclass(frozen=True, slots=True)
class Feature:
    """A thing that a URDF says, and how to take it out or change it: `change` returns whether the file has it."""

    name: str
    change: Callable[[Tree, ArmInFile], bool]
    held: tuple[str, ...] = ()
    """Numbers beside the dynamics that show it."""


def without_meshes(root: Tree) -> Tree:
    """A copy without the `<visual>` and `<collision>` that are meshes, and without `<mimic>`: such joints are held."""
    out = _without(root, lambda shape: shape.find("geometry/mesh") is not None)
    for joint in out.findall("joint"):
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)
    return out


def without_shapes(root: Tree) -> Tree:
    """A copy without any `<visual>` and `<collision>`."""
    return _without(root, lambda shape: True)


def _without(root: Tree, drop: Callable[[Tree], bool]) -> Tree:
    out = copy.deepcopy(root)
    for link in out.findall("link"):
        for shape in [x for x in link if x.tag in ("visual", "collision") and drop(x)]:
            link.remove(shape)
    return out


def xml_of(root: Tree) -> str:
    """The text of a tree; Drake's prefix stays `drake`, which its parser looks for."""
    found = {str(x.tag)[1:].partition("}")[0] for x in root.iter() if str(x.tag).startswith("{")}
    for space in found & set(_DRAKE):
        ElementTree.register_namespace("drake", space)
    return ElementTree.tostring(root, encoding="unicode")


def _rotor(root: Tree, scope: ArmInFile) -> bool:
    tags = {f"{{{space}}}{tag}" for space in _DRAKE for tag in ("rotor_inertia", "gear_ratio")}
    found = [(parent, x) for parent in root.iter() for x in parent if x.tag in tags]
    for parent, x in found:
        parent.remove(x)
    return any(float(x.get("value", "0")) != 0.0 for _, x in found if x.tag.endswith("rotor_inertia"))


def _joints(root: Tree, scope: ArmInFile, tag: str) -> Iterator[tuple[Tree, Tree]]:
    """The arm's joints that have an element, with it."""
    for joint in root.findall("joint"):
        element = joint.find(tag)
        if joint.get("name") in scope.joints and element is not None:
            yield joint, element


def _scaled(tag: str, names: tuple[str, ...], factor: float) -> Callable[[Tree, ArmInFile], bool]:
    """The numbers of an element of the arm's joints times a factor."""

    def change(root: Tree, scope: ArmInFile) -> bool:
        seen = False
        for _, element in _joints(root, scope, tag):
            for name in (x for x in names if element.get(x)):
                value = number_of(element.attrib[name])
                seen = seen or (value != 0.0 and math.isfinite(value))
                element.set(name, repr(factor * value))
        return seen

    return change


def _position_limits(root: Tree, scope: ArmInFile) -> bool:
    """1 rad or m farther out, so that every state stays inside."""
    limits = [limit for joint, limit in _joints(root, scope, "limit") if joint.get("type") != "continuous"]
    for limit in limits:
        for name, more in (("lower", -1.0), ("upper", 1.0)):
            limit.set(name, repr(number_of(limit.get(name, "0")) + more))
    return bool(limits)


def _continuous(root: Tree, scope: ArmInFile) -> bool:
    found = [x for x in root.findall("joint") if x.get("name") in scope.joints and x.get("type") == "continuous"]
    for joint in found:
        joint.set("type", "revolute")
        limit = joint.find("limit")
        limit = ElementTree.SubElement(joint, "limit") if limit is None else limit
        given = {"effort": "1000", "velocity": "1000"} | dict(limit.attrib)
        limit.attrib.update(given | {"lower": "-9", "upper": "9"})
    return bool(found)


def _inertials(root: Tree) -> Iterator[tuple[Tree, Tree]]:
    for link in root.findall("link"):
        inertial = link.find("inertial")
        if inertial is not None:
            yield link, inertial


def _inertial_rpy(root: Tree, scope: ArmInFile) -> bool:
    origins = [x for _, inertial in _inertials(root) if (x := inertial.find("origin")) is not None]
    turned = [x for x in origins if any(map(number_of, x.get("rpy", "").split()))]
    for origin in turned:
        origin.set("rpy", "0 0 0")
    return bool(turned)


def _zero_inertials(root: Tree, scope: ArmInFile) -> bool:
    found = [(link, x) for link, x in _inertials(root) if not (_weighs(x) or _has_moments(x))]
    for link, inertial in found:
        link.remove(inertial)
    return bool(found)


def _moments_without_mass(root: Tree, scope: ArmInFile) -> bool:
    found = [x for _, x in _inertials(root) if _has_moments(x) and not _weighs(x)]
    for inertia in (x for inertial in found for x in inertial.iter("inertia")):
        inertia.attrib.update(dict.fromkeys(_MOMENTS, "0"))
    return bool(found)


def _weighs(inertial: Tree) -> bool:
    mass = inertial.find("mass")
    return mass is not None and number_of(mass.get("value", "0")) != 0.0


def _has_moments(inertial: Tree) -> bool:
    inertia = inertial.find("inertia")
    return inertia is not None and any(number_of(inertia.get(x, "0")) for x in _MOMENTS)


def _no_inertial(root: Tree, scope: ArmInFile) -> bool:
    found = [link for link in root.findall("link") if link.find("inertial") is None]
    for link in found:
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "mass", value="0")
        ElementTree.SubElement(inertial, "inertia", dict.fromkeys(_MOMENTS, "0"))
    return bool(found)


FEATURES = (
    Feature("rotor inertia", _rotor),
    Feature("viscous friction", _scaled("dynamics", ("damping",), 0.0), ("viscous",)),
    Feature("Coulomb friction", _scaled("dynamics", ("friction",), 0.0), ("coulomb",)),
    Feature("effort limits", _scaled("limit", ("effort",), 2.0), ("effort",)),
    Feature("velocity limits", _scaled("limit", ("velocity",), 2.0), ("velocity",)),
    Feature("position limits", _position_limits, ("lower", "upper")),
    Feature("continuous joints", _continuous, ("lower", "upper")),
    Feature("inertial rpy", _inertial_rpy),
    Feature("zero inertials", _zero_inertials),
    Feature("moments without mass", _moments_without_mass),
    Feature("links without inertial", _no_inertial),
)
"""All but shapes and merged links, which show by loading the file itself."""


def variants(root: Tree, scope: ArmInFile) -> dict[str, Tree]:
    """Feature -> the file without it, for those that the file has."""
    out = {}
    for feature in FEATURES:
        changed = copy.deepcopy(root)
        if feature.change(changed, scope):
            out[feature.name] = changed
    return out
