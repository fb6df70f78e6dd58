"""What every loader returns, and the table of loaders."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol

import numpy as np

from tests.tolerances import EXACT, METRES, PYBULLET_INERTIA, PYBULLET_POSE

Array = np.ndarray


class LoadedModel(Protocol):
    """A model file as an engine reads it, base fixed, gravity as in the file's header; q, dq (n,) in SI."""

    mass: float
    """Sum of the masses of all links that the engine knows [kg]."""

    def mass_matrix(self, q: Array) -> Array:
        """B (n, n)."""

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """C dq (n,)."""

    def gravity_torque(self, q: Array) -> Array:
        """g (n,), the torque that holds the arm."""

    def flange(self, q: Array) -> Array:
        """Pose of the flange in the base (4, 4)."""


@dataclass(frozen=True)
class Engine:
    """A loader of this folder: the package that it needs, and the kinds of file that it reads."""

    name: str
    package: str
    keeps_rotors: dict[str, bool]
    """Ending of the file -> whether the engine takes the rotors from it."""
    inertia: float = EXACT
    """Tolerance of B and C dq, relative."""
    pose: float = METRES
    """Tolerance of the flange's pose [m]."""
    needs_masses: bool = False
    """Whether it refuses a moving link without mass."""

    def installed(self) -> bool:
        return find_spec(self.package) is not None

    def reads(self, path: Path, with_masses: bool) -> bool:
        """Whether the engine takes such a file at all."""
        return path.suffix in self.keeps_rotors and (with_masses or not self.needs_masses)

    def load(self, path: Path, gravity: Array, tip: str = "flange") -> LoadedModel:
        """The model in a file; whatever the engine prints, it prints."""
        load: Callable[..., LoadedModel] = import_module(f"tests.parity.{self.name}_loader").load
        return load(path, gravity, tip)


ENGINES = {
    "pinocchio": Engine("pinocchio", "pinocchio", {".urdf": False}),
    "mujoco": Engine("mujoco", "mujoco", {".urdf": False, ".xml": True}, needs_masses=True),
    "drake": Engine("drake", "pydrake", {".urdf": True, ".xml": True}),
    "pybullet": Engine("pybullet", "pybullet", {".urdf": False}, PYBULLET_INERTIA, PYBULLET_POSE),
}
"""Pinocchio and MuJoCo come with the extra `test`, Drake and PyBullet with `parity`, since they are large."""
