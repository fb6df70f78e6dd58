"""The engines, and what the loader of each returns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol

from lwr_dyn.foundation.arrays import Array
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


class LoadedModel(Protocol):
    """A model file as an engine reads it, base fixed; q, dq, ddq (n,) of the scope's joints in SI."""

    mass: float
    """Sum of the masses of all links that the engine knows [kg]; those it fixes to the ground may be left out."""

    def mass_matrix(self, q: Array) -> Array:
        """B (n, n)."""

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """C dq (n,)."""

    def gravity_torque(self, q: Array) -> Array:
        """g (n,), the torque that holds the arm."""

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """What the engine's own motion needs (n,): B ddq + C dq + g with rotors and friction, if it has them."""

    def flange(self, q: Array) -> Array:
        """Pose of the tip in the root (4, 4)."""

    def held(self) -> dict[str, Array]:
        """Those of `HELD` that the engine has, (n,) each."""

    def links(self) -> list[str]:
        """Names of the links that it still knows."""


class KinematicModel(Protocol):
    """A model file as a reader without dynamics has it."""

    mass: float

    def flange(self, q: Array) -> Array:
        """Pose of the tip in the root (4, 4)."""

    def held(self) -> dict[str, Array]:
        """Those of `HELD` that the reader has, (n,) each."""

    def links(self) -> list[str]:
        """Names of the links."""


Load = Callable[[Path, ArmInFile, Mapping[str, Any]], "LoadedModel | KinematicModel"]
"""File, scope, options of the engine -> model."""

ENGINES: Registry[Load] = Registry(
    "parity_engine",
    {
        "pinocchio": Row(
            "lwr_dyn.checks.engines.pinocchio_loader:load", "pip install pin", facts={"package": "pinocchio"}
        ),
        "mujoco": Row(
            "lwr_dyn.checks.engines.mujoco_loader:load",
            "pip install mujoco",
            extra="parity",
            facts={"package": "mujoco"},
        ),
        "drake": Row(
            "lwr_dyn.checks.engines.drake_loader:load",
            "pip install drake",
            extra="parity",
            facts={"package": "pydrake"},
        ),
        "pybullet": Row(
            "lwr_dyn.checks.engines.pybullet_loader:load",
            "pip install pybullet",
            extra="parity",
            # B, C dq: tensors are turned to principal axes by rotations that stop at 1e-6 of their size; poses are
            # single precision; the torque of its motion is a difference quotient of one step
            facts={"package": "pybullet", "inertia": 1e-8, "pose": 1e-6, "torque": 1e-4},
        ),
        "yourdfpy": Row(
            "lwr_dyn.checks.engines.yourdfpy_loader:load",
            "pip install yourdfpy",
            facts={"package": "yourdfpy", "kinematics": True},
        ),
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
