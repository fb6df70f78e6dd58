"""Pinocchio's own reading of a file, without anything of ours; through the only door to Pinocchio."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.checks.engines.engine import ArmInFile
from lwr_dyn.dynamics.pinocchio_engine import PinocchioCalls, file_model, flange_poses
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError


class PinocchioFile:
    """The whole tree: joints outside the scope are held, so the scope's rows are those of the reduced model.

    A continuous joint has a cosine and a sine in place of its angle.
    """

    def __init__(self, path: Path, scope: ArmInFile, rotors: str | None) -> None:
        self.model = file_model(path, rotors)
        self.calls = PinocchioCalls(self.model)
        names = list(self.model.names)
        for name in (x for x in scope.joints if x not in names):
            raise OptionError(f"joint {name}", "not in Pinocchio's model", "a joint that its parser keeps")
        self.at = [names.index(name) for name in scope.joints]
        self.dofs = [self.model.idx_vs[k] for k in self.at]
        self.model.gravity.linear = np.array(scope.gravity)
        self.tip = scope.tip
        self.rest = np.zeros(self.model.nq)
        for k, name in enumerate(names):
            if k:
                self._place(self.rest, k, scope.held.get(name, 0.0))
        self.mass = float(sum(inertia.mass for inertia in self.model.inertias))

    def mass_matrix(self, q: Array) -> Array:
        """B of the scope."""
        return np.array(self.calls.mass_matrix(self._whole(q)))[np.ix_(self.dofs, self.dofs)]

    def velocity_torque(self, q: Array, dq: Array) -> Array:
        """C dq."""
        return self.torque(q, dq, np.zeros_like(q)) - self.gravity_torque(q)

    def gravity_torque(self, q: Array) -> Array:
        """Its own function for g."""
        return np.array(self.calls.gravity_vector(self._whole(q)))[self.dofs]

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Recursive Newton-Euler with armature; `aba` leaves out friction as well."""
        return np.array(self.calls.inverse_dynamics(self._whole(q), self._rates(dq), self._rates(ddq)))[self.dofs]

    def flange(self, q: Array) -> Array:
        """Pose of the tip."""
        return np.asarray(flange_poses(self.model, self._whole(q)[None], self.tip)[0])

    def held(self) -> dict[str, Array]:
        """Numbers of the model that no algorithm above uses are there all the same."""
        m, n = self.model, [self.model.idx_qs[k] for k in self.at]
        turns = np.array([self.model.nqs[k] > 1 for k in self.at])
        out = {"lower": np.where(turns, -np.inf, m.lowerPositionLimit[n])}
        out["upper"] = np.where(turns, np.inf, m.upperPositionLimit[n])
        names = {"velocity": "upperVelocityLimit", "effort": "upperEffortLimit"}
        names |= {"viscous": "damping", "coulomb": "upperDryFrictionLimit"}
        return out | {name: np.array(getattr(m, theirs))[self.dofs] for name, theirs in names.items()}

    def links(self) -> list[str]:
        """All its frames, links behind fixed joints among them."""
        return [frame.name for frame in self.model.frames]

    def _whole(self, q: Array) -> Array:
        whole = self.rest.copy()
        for k, value in zip(self.at, q, strict=True):
            self._place(whole, k, float(value))
        return whole

    def _place(self, whole: Array, k: int, value: float) -> None:
        start, width = self.model.idx_qs[k], self.model.nqs[k]
        at_rest = {1: (value,), 2: (np.cos(value), np.sin(value)), 4: (0.0, 0.0, 1.0, 0.0)}  # 4: planar
        whole[start : start + width] = at_rest.get(width, (*[0.0] * (width - 1), 1.0))  # floating: a quaternion

    def _rates(self, values: Array) -> Array:
        whole = np.zeros(self.model.nv)
        whole[self.dofs] = values
        return whole


def load(path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> PinocchioFile:
    """The file; `rotors` names an .srdf beside it."""
    return PinocchioFile(path, scope, options.get("rotors"))
