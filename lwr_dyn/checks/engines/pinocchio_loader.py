"""Pinocchio's own reading of a file, through the only door to Pinocchio, and its agreement with ours.

Road A builds Pinocchio's model from the URDF that we write; here FK, B, g and inverse dynamics are compared without our
reader and our writer. Joints outside the chain are held where our reader holds them, in place of `buildReducedModel`,
which fails where a link and a joint share a name. Pinocchio reads no rotors from a URDF, so none are expected.
"""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.checks.arm.model_laws import EXACT, SLIDE, Verdict, equality
from lwr_dyn.checks.engines.child_process import one_line, quiet
from lwr_dyn.checks.engines.engine import ArmInFile
from lwr_dyn.checks.engines.losses import FileReference, as_urdf, reference_of
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.dynamics.pinocchio_engine import PinocchioCalls, file_model, flange_poses
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm


class PinocchioFile:
    """The whole tree: joints outside the scope are held, so the scope's rows are those of the reduced model.

    A continuous joint has a cosine and a sine in place of its angle. The option `rotors` names an .srdf.
    """

    def __init__(self, path: Path, scope: ArmInFile, options: Mapping[str, Any]) -> None:
        self.model = file_model(path, options.get("rotors"))
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


STATES = 200
_NAME = "Pinocchio on the file itself against our reading"


def file_verdicts(arm: Arm) -> tuple[list[Verdict], list[str]]:
    """The verdicts on the file that an arm was read from, and why there are none where Pinocchio cannot read it.

    The file is read again with the arm's tip and locks, so a payload or a mounting changes nothing here.
    """
    given = arm.loaded_with
    with as_urdf(Path(arm.file), given) as path:
        reference = reference_of(path, given.get("tip"), given.get("lock", {}), STATES)
        try:
            with quiet() as printed:
                model = PinocchioFile(path, reference.scope, {})
        except Exception as refusal:  # its parser raises what C++ throws
            return [], [f"{_NAME}: {one_line(refusal, printed)}"]
    joints = () if reference.arm.layout is None else reference.arm.layout.joints
    extreme = [x.joint for x in joints if not 1e-300 < sum(a * a for a in x.axis) < math.inf]
    if extreme:
        return [], [f"{_NAME}: its parser squares an axis, and that of {', '.join(extreme)} has no square as a float"]
    return _agreement(model, reference), []


def _agreement(model: PinocchioFile, reference: FileReference) -> list[Verdict]:
    x, ours = reference.states, reference.flange()
    size = max(1.0, float(np.abs(ours).max()))
    pose = float(np.abs(_over(model.flange, x.q) - ours).max())
    kinematics = Verdict(f"FK: {_NAME}", pose, EXACT * size, "m")
    if not reference.has_dynamics:
        return [kinematics]
    bare = newton_euler_dynamics(reference.arm.chain, rotors="none")
    torque = bare.inverse_dynamics(x.q, x.dq, x.ddq)
    mass = sum(body.mass for body in reference.arm.chain.bodies or ())
    weight = mass * float(np.linalg.norm(reference.scope.gravity))
    floor = max(1e-3 * float(np.abs(torque).max()), 1e-2 * weight * min(size, SLIDE))
    return [
        kinematics,
        equality(f"B: {_NAME}", _over(model.mass_matrix, x.q), bare.mass_matrix(x.q)),
        equality(f"g: {_NAME}", _over(model.gravity_torque, x.q), bare.gravity_vector(x.q), floor),
        equality(f"inverse dynamics: {_NAME}", _over(model.torque, x.q, x.dq, x.ddq), torque),
    ]


def _over(function: Callable[..., Array], *rows: Array) -> Array:
    return np.array([function(*row) for row in zip(*rows, strict=True)])
