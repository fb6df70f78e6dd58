"""Pinocchio on a foreign file itself against our reading of it: FK, B, g, inverse dynamics, over random states.

Road A builds Pinocchio's model from the URDF that we write; this verdict leaves out our reader and our writer. Joints
outside the chain are held where our reader holds them, in place of `buildReducedModel`, which fails where a link and a
joint share a name. Pinocchio reads no rotors from a URDF, so none are expected.
"""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from lwr_dyn.checks.arm.identities import EXACT, SLIDE, relative
from lwr_dyn.checks.arm.verdict import Verdict
from lwr_dyn.checks.engines.engine_prints import one_line, quiet
from lwr_dyn.checks.engines.pinocchio_loader import PinocchioFile
from lwr_dyn.checks.engines.reference import FileReference, as_urdf, reference_of
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm

STATES = 200
_NAME = "Pinocchio on the file itself - our reading"


def file_verdicts(arm: Arm) -> tuple[list[Verdict], list[str]]:
    """The verdicts on the file that an arm was read from, and why there are none where Pinocchio cannot read it.

    The file is read again with the arm's tip and locks, so a payload or a mounting changes nothing here.
    """
    given = arm.loaded_with
    with as_urdf(Path(arm.file), given.get("xacro_args", {})) as path:
        reference = reference_of(path, given.get("tip"), given.get("lock", {}), STATES)
        try:
            with quiet() as printed:
                model = PinocchioFile(path, reference.scope, None)
        except Exception as refusal:  # its parser raises what C++ throws
            return [], [f"{_NAME}: {one_line(refusal, printed)}"]
    extreme = _extreme_axes(reference.arm)
    if extreme:
        return [], [f"{_NAME}: its parser squares an axis, and that of {', '.join(extreme)} has no square as a float"]
    return _agreement(model, reference), []


def _extreme_axes(arm: Arm) -> list[str]:
    joints = () if arm.layout is None else arm.layout.joints
    return [x.joint for x in joints if not 1e-300 < sum(a * a for a in x.axis) < math.inf]


def _agreement(model: PinocchioFile, reference: FileReference) -> list[Verdict]:
    x, ours = reference.states, reference.flange()
    size = max(1.0, float(np.abs(ours).max()))
    pose = float(np.abs(_over(model.flange, x.q) - ours).max())
    verdicts = [Verdict(f"FK: {_NAME}", pose, EXACT * size, "m")]
    if not reference.has_dynamics:
        return verdicts
    bare = newton_euler_dynamics(reference.arm.chain, rotors="none")
    torque = bare.inverse_dynamics(x.q, x.dq, x.ddq)
    weight = sum(body.mass for body in reference.arm.chain.bodies or ()) * float(
        np.linalg.norm(reference.scope.gravity)
    )
    floor = max(1e-3 * float(np.abs(torque).max()), 1e-2 * weight * min(size, SLIDE))
    pairs = {
        "B": (_over(model.mass_matrix, x.q), bare.mass_matrix(x.q), 0.0),
        "g": (_over(model.gravity_torque, x.q), bare.gravity_vector(x.q), floor),
        "inverse dynamics": (_over(model.torque, x.q, x.dq, x.ddq), torque, 0.0),
    }
    return verdicts + [Verdict(f"{name}: {_NAME}", relative(*pair), EXACT, "relative") for name, pair in pairs.items()]


def _over(function: Callable[..., Array], *rows: Array) -> Array:
    return np.array([function(*row) for row in zip(*rows, strict=True)])
