"""yourdfpy's reading of a file: kinematics, limits and masses; it has no dynamics."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yourdfpy

from lwr_dyn.checks.engines.engine import ArmInFile
from lwr_dyn.foundation.arrays import Array


class YourdfpyFile:
    """The parsed file with its graph of frames; meshes are not loaded."""

    def __init__(self, path: Path, scope: ArmInFile) -> None:
        self.urdf = yourdfpy.URDF.load(str(path), build_scene_graph=True, load_meshes=False)
        self.scope = scope
        self.mass = float(sum(link.inertial.mass for link in self.urdf.robot.links if link.inertial is not None))

    def flange(self, q: Array) -> Array:
        """Pose of the tip in the base link."""
        places = dict(self.scope.held) | dict(zip(self.scope.joints, map(float, q), strict=True))
        known = self.urdf.actuated_joint_names
        self.urdf.update_cfg({name: value for name, value in places.items() if name in known})
        return np.array(self.urdf.get_transform(self.scope.tip, self.urdf.base_link))

    def held(self) -> dict[str, Array]:
        """Limits, damping and friction as parsed."""
        joints = [self.urdf.joint_map[name] for name in self.scope.joints]
        out = {}
        for name in ("lower", "upper", "velocity", "effort"):
            endless = ("continuous",) if name in ("lower", "upper") else ()
            values = [None if j.limit is None or j.type in endless else getattr(j.limit, name) for j in joints]
            none = -np.inf if name == "lower" else np.inf
            out[name] = np.array([none if value is None else float(value) for value in values])
        for name, theirs in (("viscous", "damping"), ("coulomb", "friction")):
            values = [None if j.dynamics is None else getattr(j.dynamics, theirs) for j in joints]
            out[name] = np.array([float(value or 0.0) for value in values])
        return out

    def links(self) -> list[str]:
        """All links."""
        return list(self.urdf.link_map)


def load(path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> YourdfpyFile:
    """The file; there are no options."""
    return YourdfpyFile(path, scope)
